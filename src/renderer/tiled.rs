//! The frame of presets `fast` and `exact`, by compute alone: whole clusters are culled, drops are entered into tiles and
//! composited front to back. Each pass is explained where it is: `src/passes/tiles.rs`, `composite.rs`, `glints.rs`, `pane/`.
//!
//! The order is that of [`Tiled::record`], read downwards: `clusters`, `sky` (if what is behind the drops has changed),
//! `gather`, `large`, `rays`, `glints`, `composite`, `pane`. Every barrier between them is here. `sky` makes the far drops' pictures
//! that are missing, too. What a host brings is recorded before, with its barriers, by `src/renderer/view.rs`.

use std::sync::Arc;

use super::lighting::Lighting;
use crate::Result;
use crate::gpu::{Buffer, Device, Recorder, Timestamps, Use, memory_barrier};
use crate::passes::appearance::{Directions, FarDrop};
use crate::passes::background::{BackgroundImages, Behind};
use crate::passes::composite::{Composite, Prepared};
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::glints::SplatTable;
use crate::passes::pane::{Before, Pane, PaneDrops};
use crate::passes::rain_field::RainField;
use crate::passes::tiles::Tiles;
use crate::passes::tone_map::Source;
use crate::plan::FramePlan;
use crate::rain::field::Seen;
use crate::scene::Scene;
use crate::scene::model::{Lens, Motion, Optics};
use crate::scene::projection::View;

/// The passes of the frame, up to its radiance.
pub(super) struct Tiled {
    pub tiles: Tiles,
    pub composite: Composite,
    /// Between the rain and the display; none without a pane.
    pub pane: Option<Pane>,
    /// The environment as drops see it, and the tables of a far drop by direction: pictures, glints, light of flattened drops.
    pub far: Arc<FarDrop>,
    pub splats: SplatTable,
    /// Whether frames read `splats`: splats do, and flattened drops, whose mean light is in that table.
    reads_splats: bool,
    /// Whether far rain is a medium, which `sky` draws.
    has_medium: bool,
    /// Whether frames read the tables of `far`, which `sky` fills before they do.
    shows_far: bool,
    /// Whether drops may move or be out of focus. They may be seen in a part of the picture that their place is not in, so the tables
    /// are then filled for the directions of the whole picture, not for those of the part that is drawn.
    is_spread: bool,
}

impl Tiled {
    pub fn new(
        lighting: &Lighting,
        rain: &RainField,
        frame: &FrameBuffer,
        scene: &Scene,
        plan: &FramePlan,
        behind: Option<&Behind>,
    ) -> Result<Self> {
        let device = lighting.device();
        // Three read a far drop's tables: optics `appearance`, far rain, and drops out of focus, whose glints are found there.
        let shows_sources = plan.lens != Lens::Pinhole && lighting.shows_sources(&plan.light);
        let filled =
            plan.optics == Optics::Appearance || scene.real_rain().is_some() || shows_sources;
        let has_flat = plan.shape.flattens_rain(scene) || plan.shape.flattens_placed(scene);
        let far = lighting.far_drop(&plan.light, true, filled, has_flat)?;
        let FarDrop { seen, glints, .. } = &*far;
        let nothing = plan.layers.then(|| Behind::Plate(Arc::new(BackgroundImages::default())));
        let behind = behind.or(nothing.as_ref());
        let has_depth = behind.is_some_and(Behind::has_depth);
        let tiles = Tiles::new(device, frame, &far, rain, scene, plan, has_depth)?;
        let splats = SplatTable::new(device, &far, &tiles)?;
        let prepared = Prepared {
            environment: &lighting.environment,
            seen_by_drops: seen,
            glints,
            splats: &splats,
            tiles: &tiles,
        };
        let (size, is_renewed) = (scene.picture_size(), lighting.renewal.is_some());
        let composite = Composite::new(device, prepared, size, plan, behind, is_renewed)?;
        let pane = match plan.draws_pane() {
            true => {
                let drops = &match scene.host_pane_drops {
                    0 => rain.on_pane(scene)?,
                    most => Arc::new(PaneDrops::of_host(device, most)?),
                };
                let picture = &composite.radiance;
                let environment = &lighting.environment;
                let before = Before { frame, picture, environment, behind, drops };
                Some(Pane::new(device, scene, plan, before)?)
            }
            false => None,
        };
        Ok(Self {
            tiles,
            composite,
            pane,
            splats,
            reads_splats: plan.splat_px > 0.0 || has_flat,
            has_medium: scene.real_rain().is_some(),
            shows_far: filled,
            is_spread: plan.lens != Lens::Pinhole || plan.motion != Motion::Instant,
            far,
        })
    }

    /// Completes a frame's constants.
    pub fn complete(&self, frame: &mut Frame) {
        self.tiles.complete(frame);
        if self.far.glints.count == 0 {
            // LINE_PARTS of `streak_layer.glsl`: without a bright source no streak has lines.
            frame.streaks[2] = 0;
        }
    }

    /// Records what empties the lists and counters of the frame before. `until`: the view and the seconds to where motion in
    /// layers ends; `seen`: the cells of real rain that are in view.
    pub fn record_reset(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        until: (&View, f64),
        seen: Option<&Seen>,
    ) {
        self.tiles.record_reset(device, commands, scene, until, seen);
        self.composite.record_reset(device, commands);
        if let Some(pane) = &self.pane {
            pane.record_reset(device, commands, scene);
        }
    }

    /// The picture, with the pane where there is one.
    pub fn radiance(&self) -> &Buffer {
        self.pane.as_ref().map_or(&self.composite.radiance, Pane::radiance)
    }

    /// That picture's sums of log luminance, tile by tile.
    pub fn log_sums(&self) -> &Buffer {
        self.pane.as_ref().map_or(&self.composite.log_sums, Pane::log_sums)
    }

    /// That picture as the display passes read it.
    pub fn source(&self) -> Source<'_> {
        self.pane.as_ref().map_or_else(|| self.composite.source(), Pane::source)
    }

    /// Records all passes from the frame's constants to the radiance buffer. `recording` counts the view's recordings: by it
    /// `composite` knows whether the sky that it keeps was ever executed.
    pub fn record(
        &mut self,
        device: &Device,
        commands: Recorder<'_>,
        time: &mut Timestamps,
        recording: u32,
        frame: &Frame,
        seen: Option<&Seen>,
    ) {
        self.record_lists(device, commands, time, recording, frame, seen);
        self.record_composite(device, commands, time);
        if let Some(pane) = &self.pane {
            time.time(commands, "pane", || {
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
                pane.record(device, commands);
            });
        }
    }

    /// Records all before `composite`: the tiles' lists, the colours of the drops in them, and the sky.
    pub fn record_lists(
        &mut self,
        device: &Device,
        commands: Recorder<'_>,
        time: &mut Timestamps,
        recording: u32,
        frame: &Frame,
        seen: Option<&Seen>,
    ) {
        let barrier =
            |before: &[Use], after: &[Use]| memory_barrier(device, commands, before, after);
        // Readers take the lists as buffers of words or of texels, and as arguments of dispatches.
        let read = [Use::ComputeWrite, Use::ComputeRead, Use::Indirect];
        time.time(commands, "clusters", || {
            barrier(&[Use::TransferWrite], &[Use::Uniform, Use::ComputeWrite, Use::ComputeRead]);
            self.tiles.record_clusters(device, commands, seen);
        });
        if self.composite.needs_sky(frame, seen, recording) {
            time.time(commands, "sky", || {
                if self.shows_far {
                    let directions = match self.is_spread {
                        true => Directions::of_whole(frame),
                        false => Directions::of(frame),
                    };
                    self.far.appearance.record(commands, directions);
                    if let Some(flat) = &self.far.flat {
                        flat.record(commands, directions);
                    }
                    barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
                }
                if self.reads_splats {
                    self.splats.record(commands);
                    // The sky's medium reads the table. Without a medium its first reader is after the barrier of `gather`.
                    if self.has_medium {
                        barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
                    }
                }
                self.composite.record_sky(device, commands);
            });
        }
        time.time(commands, "gather", || {
            barrier(&[Use::ComputeWrite], &read);
            self.tiles.record_gather(device, commands);
        });
        time.time(commands, "large", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::Indirect]);
            self.tiles.record_large(device, commands);
        });
        time.time(commands, "rays", || {
            barrier(&[Use::ComputeWrite], &read);
            self.composite.record_rays(device, commands, &self.tiles);
        });
        if self.far.glints.count > 0 {
            time.time(commands, "glints", || {
                barrier(&[Use::ComputeWrite], &read);
                self.composite.record_glints(device, commands, &self.tiles);
            });
        }
    }

    /// Records the pass that composites the lists' drops over one another and over the sky.
    pub fn record_composite(&self, device: &Device, commands: Recorder<'_>, time: &mut Timestamps) {
        let barrier =
            |before: &[Use], after: &[Use]| memory_barrier(device, commands, before, after);
        time.time(commands, "composite", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
            self.composite.record(device, commands, &self.tiles);
        });
    }

    /// Makes the radiance ready for the display pass.
    pub fn record_display(&self, device: &Device, commands: Recorder<'_>) {
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ShaderRead]);
    }
}
