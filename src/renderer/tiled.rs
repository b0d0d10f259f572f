//! The fast frame: whole clusters culled, drops in tiles front to back, by compute alone.

use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use crate::Result;
use crate::environment::bright::Bright;
use crate::gpu::{Device, Timestamps, Use, memory_barrier};
use crate::passes::appearance::Appearance;
use crate::passes::composite::Composite;
use crate::passes::environment::EnvironmentMap;
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::glints::Glints;
use crate::passes::tiles::Tiles;
use crate::plan::FramePlan;
use crate::rain::field::Seen;
use crate::scene::Scene;
use crate::scene::model::Optics;

/// The passes of the frame, up to its radiance.
pub(super) struct Tiled {
    pub tiles: Tiles,
    pub composite: Composite,
    /// What the table of a drop's light is, and the milliseconds that it took.
    pub table_ms: Option<(&'static str, f64)>,
    glints: Glints,
    _appearance: Appearance,
    /// The environment without what [`Glints`] shows of it; none where that is all.
    _seen_by_drops: Option<EnvironmentMap>,
}

impl Tiled {
    pub fn new(
        device: &Arc<Device>,
        scene: &Scene,
        constants: &Frame,
        frame: &FrameBuffer,
        environment: &EnvironmentMap,
        bright: Option<&Bright>,
        plan: &FramePlan,
    ) -> Result<Self> {
        let scale = environment.radiance_scale;
        let rest =
            bright.map(|bright| EnvironmentMap::new(device, &bright.rest, scale)).transpose()?;
        let seen_by_drops = rest.as_ref().unwrap_or(environment);
        let appearance = Appearance::new(device, frame, seen_by_drops, &plan.light)?;
        let glints = Glints::new(device, frame, &appearance, bright, scale, &plan.light)?;
        let table_ms = if plan.optics == Optics::Appearance || scene.real_rain().is_some() {
            let before = Instant::now();
            appearance.fill(device, frame, constants)?;
            glints.fill(device)?;
            Some(("appearance", before.elapsed().as_secs_f64() * 1e3))
        } else {
            None
        };
        let tiles = Tiles::new(device, frame, &appearance, scene, plan)?;
        let size = scene.picture_size();
        let composite = Composite::new(
            device,
            frame,
            environment,
            seen_by_drops,
            &appearance,
            &glints,
            &tiles,
            size,
            plan,
        )?;
        Ok(Self {
            tiles,
            composite,
            table_ms,
            glints,
            _appearance: appearance,
            _seen_by_drops: rest,
        })
    }

    pub fn record_reset(
        &self,
        device: &Device,
        commands: vk::CommandBuffer,
        scene: &Scene,
        seen: Option<&Seen>,
    ) {
        self.tiles.record_reset(device, commands, scene, seen);
    }

    /// From the frame's constants to the radiance buffer.
    pub fn record(
        &mut self,
        device: &Device,
        commands: vk::CommandBuffer,
        time: &mut Timestamps,
        frame: &Frame,
        seen: Option<&Seen>,
    ) {
        let barrier =
            |before: &[Use], after: &[Use]| memory_barrier(device, commands, before, after);
        time.time(commands, "clusters", || {
            barrier(&[Use::TransferWrite], &[Use::Uniform, Use::ComputeWrite]);
            self.tiles.record_clusters(device, commands, seen);
        });
        if self.composite.needs_sky(frame) {
            time.time(commands, "sky", || {
                self.glints.record_table(commands);
                // Far rain shows what is in the table.
                barrier(&[Use::ComputeWrite], &[Use::ComputeWrite]);
                self.composite.record_sky(commands);
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
            self.composite.record_rays(commands, &self.tiles);
        });
        if self.glints.count > 0 {
            time.time(commands, "glints", || {
                barrier(
                    &[Use::ComputeWrite],
                    &[Use::ComputeWrite, Use::ComputeRead, Use::Indirect],
                );
                self.composite.record_glints(commands, &self.tiles);
            });
        }
        time.time(commands, "composite", || {
            barrier(&[Use::ComputeWrite], &[Use::ComputeWrite, Use::ComputeRead]);
            self.composite.record(device, commands, &self.tiles);
        });
    }

    /// Makes the radiance ready for the display pass.
    pub fn record_display(&self, device: &Device, commands: vk::CommandBuffer) {
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ShaderRead]);
    }
}
