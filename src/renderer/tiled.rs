//! The fast frame: whole clusters culled, drops in tiles front to back, by compute alone.

use std::sync::Arc;

use super::lighting::Lighting;
use crate::Result;
use crate::gpu::{Buffer, Device, Recorder, Timestamps, Use, memory_barrier};
use crate::passes::appearance::{Directions, FarDrop};
use crate::passes::background::{BackgroundImages, Behind};
use crate::passes::composite::{Composite, Prepared};
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::glints::SplatTable;
use crate::passes::pane::{Before, Pane};
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
    /// What drops show, far ones from a table.
    pub far: Arc<FarDrop>,
    pub splats: SplatTable,
    /// Whether frames read what splats show: flattened far rain has its light there.
    reads_splats: bool,
    has_medium: bool,
    /// Whether there are far drops of whom something is shown, and whether they are spread over more than their places.
    shows_far: bool,
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
        // Far rain shows what is in the table, and drops out of focus what sources do in them.
        let shows_sources = plan.lens != Lens::Pinhole && lighting.shows_sources(&plan.light);
        let filled =
            plan.optics == Optics::Appearance || scene.real_rain().is_some() || shows_sources;
        let is_flat = plan.shape.flattens_rain(scene);
        let far = lighting.far_drop(&plan.light, true, filled, is_flat)?;
        let FarDrop { seen, glints, .. } = &*far;
        let nothing = plan.layers.then(|| Behind::Plate(Arc::new(BackgroundImages::none())));
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
                let (picture, drops) = (&composite.radiance, &rain.on_pane(scene)?);
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
            reads_splats: plan.splat_px > 0.0 || is_flat,
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
            // Nothing draws lines.
            frame.streaks[2] = 0;
        }
    }

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

    /// Its sums of log luminance, tile by tile.
    pub fn log_sums(&self) -> &Buffer {
        self.pane.as_ref().map_or(&self.composite.log_sums, Pane::log_sums)
    }

    /// What the display passes read.
    pub fn source(&self) -> Source<'_> {
        self.pane.as_ref().map_or_else(|| self.composite.source(), Pane::source)
    }

    /// From the frame's constants to the radiance buffer. `recording`: number of what is recorded.
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

    /// Records the frame up to the tiles' lists, the colours of all that is in them, and the sky.
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
        time.time(commands, "clusters", || {
            barrier(&[Use::TransferWrite], &[Use::Uniform, Use::ComputeWrite]);
            self.tiles.record_clusters(device, commands, seen);
        });
        if self.composite.needs_sky(frame, recording) {
            time.time(commands, "sky", || {
                if self.shows_far {
                    let seen = if self.is_spread { Directions::ALL } else { Directions::of(frame) };
                    self.far.appearance.record(commands, seen);
                    if let Some(flat) = &self.far.flat {
                        flat.record(commands, Directions::of(frame));
                    }
                    barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
                }
                if self.reads_splats {
                    self.splats.record(commands);
                    // The sky's medium reads it; without one it is read after the sky.
                    if self.has_medium {
                        barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
                    }
                }
                self.composite.record_sky(device, commands);
            });
        }
        time.time(commands, "gather", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::Indirect]);
            self.tiles.record_gather(device, commands);
        });
        time.time(commands, "large", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::Indirect]);
            self.tiles.record_large(device, commands);
        });
        time.time(commands, "rays", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::Indirect]);
            self.composite.record_rays(device, commands, &self.tiles);
        });
        if self.far.glints.count > 0 {
            time.time(commands, "glints", || {
                barrier(
                    &[Use::ComputeWrite],
                    &[Use::ComputeWrite, Use::ComputeRead, Use::Indirect],
                );
                self.composite.record_glints(device, commands, &self.tiles);
            });
        }
    }

    /// What is in the lists over one another and over the sky.
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
