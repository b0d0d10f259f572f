//! What has the size of one picture: its targets, the lists of its tiles, and the passes that fill them.

use std::sync::Arc;

use ash::vk;

use super::lighting::Lighting;
use super::points::Points;
use super::tiled::Tiled;
use crate::Result;
use crate::gpu::{
    Buffer, Device, Image, ImageInfo, Recorder, Samples, Timestamps, Use, image_discard,
    memory_barrier,
};
use crate::passes::background::BackgroundImages;
use crate::passes::drops::guard_band;
use crate::passes::frame::{Frame, FrameBuffer, Surroundings};
use crate::passes::rain_field::RainField;
use crate::passes::tiles;
use crate::passes::tone_map::{DELTA, DISPLAY, FinalSums, Source, ToneMap};
use crate::plan::FramePlan;
use crate::rain::Tick;
use crate::rain::field::Seen;
use crate::scene::Scene;
use crate::scene::model::Primitive;

/// From a scene to its radiance.
pub(super) enum Drawing {
    Points(Box<Points>),
    Tiled(Box<Tiled>),
}

impl Drawing {
    pub fn counters(&self) -> Option<&Buffer> {
        match self {
            Self::Points(points) => points.simulate().map(|simulate| &simulate.counters),
            Self::Tiled(tiled) => Some(&tiled.tiles.counters),
        }
    }

    /// What the tiles' passes hand to each other, counts among it.
    pub fn totals(&self) -> Option<&Buffer> {
        match self {
            Self::Points(_) => None,
            Self::Tiled(tiled) => Some(tiled.tiles.totals()),
        }
    }

    /// What the table of a drop's light is, and the milliseconds that it took.
    pub fn table_ms(&self) -> Option<(&'static str, f64)> {
        match self {
            Self::Points(points) => points.table_ms(),
            Self::Tiled(tiled) => tiled.far.ms.map(|ms| ("appearance", ms)),
        }
    }
}

/// The pass that turns radiance into display colour, and its target.
pub(super) struct Display {
    pub tone_map: ToneMap,
    pub image: Image,
    /// Whether the frame sums up the logarithms that a derived exposure needs.
    pub log_average: bool,
}

/// The passes of a picture and their targets.
pub(super) struct View {
    frame: FrameBuffer,
    pub surroundings: Surroundings,
    pub size: (u32, u32),
    /// Tiles across and down.
    pub lattice: [u32; 2],
    // Views what `drawing` holds, so it is freed first.
    pub display: Option<Display>,
    pub drawing: Drawing,
}

/// What the device and the environment add to the constants of a frame.
pub(super) fn surroundings(
    lighting: &Lighting,
    scene: &Scene,
    plan: &FramePlan,
) -> Result<Surroundings> {
    let (width, height) = scene.picture_size();
    // Only who draws points asks what the device does with them.
    let point_limit_px = match plan.primitive {
        Primitive::Tile => 0.0,
        _ => guard_band(lighting.device(), width, height)?.1,
    };
    let environment = &lighting.environment;
    let scale = f64::from(environment.radiance_scale);
    let delta = (DELTA * lighting.mean_luminance / scale) as f32;
    Ok(Surroundings {
        point_limit_px,
        texel_angle: environment.texel_angle,
        radiance_scale: environment.radiance_scale,
        // In an all-black environment any δ keeps the logarithm finite.
        delta: delta.max(f32::MIN_POSITIVE),
    })
}

/// Tiles of a scene's picture, across and down; those of the whole, so that their number is not told by its size.
pub(super) fn lattice_of(scene: &Scene) -> [u32; 2] {
    let (first, end) = tiles::of_view(&scene.view());
    [end[0] - first[0], end[1] - first[1]]
}

impl View {
    pub fn new(
        lighting: &Arc<Lighting>,
        rain: &Arc<RainField>,
        scene: &Scene,
        plan: &FramePlan,
        background: Option<&Arc<BackgroundImages>>,
    ) -> Result<Self> {
        let device = lighting.device();
        let (width, height) = scene.picture_size();
        let frame = FrameBuffer::new(device)?;
        let surroundings = surroundings(lighting, scene, plan)?;
        let drawing = match plan.primitive {
            Primitive::Point | Primitive::Quad => {
                Drawing::Points(Box::new(Points::new(lighting, &frame, scene, plan)?))
            }
            Primitive::Tile => {
                let tiled = Tiled::new(lighting, rain, &frame, scene, plan, background)?;
                Drawing::Tiled(Box::new(tiled))
            }
        };
        let display = match plan.tone_map {
            Some(operator) => {
                let source = match &drawing {
                    Drawing::Points(points) => Source::Image(&points.radiance),
                    Drawing::Tiled(tiled) => tiled.composite.source(),
                };
                let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
                    | vk::ImageUsageFlags::TRANSFER_SRC
                    | vk::ImageUsageFlags::SAMPLED;
                let (name, format) = ("display", DISPLAY);
                let samples = Samples::One;
                let info =
                    ImageInfo { name, width, height, levels: 1, layers: 1, format, usage, samples };
                let tone_map = ToneMap::new(device, &frame, source, operator)?;
                let log_average = plan.log_average;
                Some(Display { tone_map, image: Image::new(device, &info)?, log_average })
            }
            None => None,
        };
        let (size, lattice) = ((width, height), lattice_of(scene));
        Ok(Self { frame, surroundings, size, lattice, display, drawing })
    }

    /// The constants of a frame of `scene`; `last_tick` is the time of the stored positions, if there are any.
    pub fn frame_of(&self, scene: &Scene, last_tick: Option<Tick>) -> Frame {
        let mut frame = Frame::new(scene, &self.surroundings, last_tick);
        match &self.drawing {
            Drawing::Tiled(tiled) => tiled.tiles.complete(&mut frame),
            Drawing::Points(_) => {
                frame.tiles[0] = self.display.as_ref().map_or(0, |display| display.tone_map.count);
            }
        }
        frame
    }

    /// The commands that were recorded last are on the queue.
    pub fn submitted(&mut self) {
        if let Drawing::Tiled(tiled) = &mut self.drawing {
            tiled.composite.submitted();
        }
    }

    /// Records a frame of a scene, from its constants to the display image. `whole`: sums of log luminance in place of its own.
    pub fn record(
        &mut self,
        device: &Device,
        commands: Recorder<'_>,
        time: &mut Timestamps,
        (scene, frame, seen): (&Scene, &Frame, Option<&Seen>),
        whole: Option<&FinalSums>,
    ) {
        self.frame.record(device, commands, frame);
        match &mut self.drawing {
            Drawing::Points(points) => {
                points.record_reset(device, commands, scene);
                points.record(device, commands, time);
            }
            Drawing::Tiled(tiled) => {
                tiled.record_reset(device, commands, scene, seen);
                tiled.record(device, commands, time, frame, seen);
            }
        }
        let Some(display) = &self.display else { return };
        let tone_map = &display.tone_map;
        match &self.drawing {
            Drawing::Points(points) => points.record_display(device, commands),
            Drawing::Tiled(tiled) => tiled.record_display(device, commands),
        }
        // A factor of 0: to be derived from the picture.
        let derives_exposure = frame.tone[2] == 0.0;
        if let (true, Some(sums)) = (derives_exposure, whole) {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferWrite]);
            tone_map.record_sums(device, commands, sums);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::GraphicsRead]);
        } else if derives_exposure {
            time.time(commands, "log luminance", || {
                tone_map.record_log_luminance(device, commands);
            });
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::GraphicsRead]);
        }
        let before = [Use::TransferRead, Use::ColorAttachment];
        image_discard(device, commands, &display.image, &before, Use::ColorAttachment);
        time.time(commands, "tone map", || tone_map.record(device, commands, &display.image));
    }
}
