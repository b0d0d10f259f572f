//! An environment prepared on the device, and what drops show of it: made once, shared by every view of it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::Result;
use crate::environment::Environment;
use crate::environment::bright::Bright;
use crate::gpu::{Commands, Device, Recorder, Use, memory_barrier};
use crate::passes::appearance::{Appearance, FarDrop};
use crate::passes::drops::Table;
use crate::passes::environment::{EnvironmentMap, stored_scale};
use crate::passes::flat_light::FlatLight;
use crate::passes::frame::{Frame, FrameBuffer};
use crate::passes::glints::{Glints, MOST_SOURCES, bright_parts, shows_apart};
use crate::passes::renewal::{HostEnvironment, LiveInfo, Renewal};
use crate::plan::{FramePlan, Light};
use crate::scene::model::{Fresnel, Optics};

/// The environment on the device, and the tables of a drop's light that pictures have asked for so far.
pub struct Lighting {
    pub(super) environment: Arc<EnvironmentMap>,
    /// Milliseconds that its levels took.
    pub(super) environment_ms: f64,
    /// Mean luminance without bright parts, of which one may outshine all the rest.
    pub(super) mean_luminance: f64,
    /// Share of a ray's light under which it is followed no further.
    pub(super) least_rest: f32,
    bright: Option<Bright>,
    /// What renews it in a host's frames.
    pub(super) renewal: Option<Renewal>,
    /// What the tables are computed with: of the constants only the environment's.
    frame: FrameBuffer,
    constants: Frame,
    made: Mutex<Made>,
    /// The environment without what [`Glints`] show of it; none where that is all, or nothing asked for it. Locked while a far drop or
    /// a table is made, so that each is made once; frames that are recorded meanwhile do not wait for that.
    rest: Mutex<Option<Arc<EnvironmentMap>>>,
    device: Arc<Device>,
}

/// Most that may be left of a ray's light where it is followed no further, and least, which eight orders leave of most rays.
const MOST_REST: f32 = 1e-4;
const LEAST_REST: f32 = 1e-7;
/// What may be left where the environment is not known before it is drawn.
const UNKNOWN_REST: f32 = 1e-5;

/// What may be left of a ray's light: if all of it came from the brightest direction, it would be a hundredth of the median.
fn least_rest(environment: &Environment) -> f32 {
    let brightest = environment.max_radiance().max(f32::MIN_POSITIVE);
    (0.01 * environment.median_luminance() / brightest).clamp(LEAST_REST, MOST_REST)
}

/// What a far drop is made for: the light, and the three choices of `Lighting::far_drop`.
type FarDropKey = (Light, bool, bool, bool);

/// What was asked for so far.
#[derive(Default)]
struct Made {
    far_drops: Vec<(FarDropKey, Arc<FarDrop>)>,
    tables: Vec<(TableOf, Arc<Table>)>,
}

/// What a table of a drop's light depends on, the environment apart.
#[derive(Clone, Copy, PartialEq)]
enum TableOf {
    Mask(Optics, u32, Light),
    Radial(Fresnel),
}

/// What is in a lock, also where a thread that held it has panicked: nothing is left half done in these.
fn locked<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Lighting {
    /// Prefilters and uploads.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if an edge is over the device's limit for images; [`crate::Error::Memory`]
    /// if the device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, environment: &Environment) -> Result<Self> {
        let before = Instant::now();
        let bright = bright_parts(environment);
        let mean_luminance = environment.ordinary_luminance();
        let least_rest = least_rest(bright.as_ref().map_or(environment, |bright| &bright.rest));
        let scale = stored_scale(environment);
        let environment = Arc::new(EnvironmentMap::new(device, environment, scale)?);
        let environment_ms = before.elapsed().as_secs_f64() * 1e3;
        let unmade = Self::unmade(device, environment, mean_luminance, least_rest)?;
        Ok(Self { environment_ms, bright, ..unmade })
    }

    /// An environment that a host renews in its frames ([`super::FrameInput::around`]); black until it does.
    ///
    /// # Errors
    /// See [`Renewal::new`].
    pub fn live(device: &Arc<Device>, info: LiveInfo) -> Result<Self> {
        let renewal = Renewal::new(device, info)?;
        let environment = renewal.whole.clone();
        let scale = f64::from(info.radiance_scale);
        let unmade = Self::unmade(device, environment, scale, UNKNOWN_REST)?;
        Ok(Self { renewal: Some(renewal), ..unmade })
    }

    /// What an environment on the device lights, before bright parts and tables are made.
    fn unmade(
        device: &Arc<Device>,
        environment: Arc<EnvironmentMap>,
        mean_luminance: f64,
        least_rest: f32,
    ) -> Result<Self> {
        let of_frame = [environment.texel_angle, environment.radiance_scale, least_rest, 0.0];
        Ok(Self {
            environment,
            environment_ms: 0.0,
            mean_luminance,
            least_rest,
            bright: None,
            renewal: None,
            frame: FrameBuffer::new(device)?,
            constants: Frame { environment: of_frame, ..Frame::default() },
            made: Mutex::default(),
            rest: Mutex::default(),
            device: device.clone(),
        })
    }

    /// Records the environment from a host's image, in a descriptor set of [`Renewal::set_image`]. Nothing if it is not
    /// one that is renewed.
    pub(super) fn record(&self, commands: Recorder<'_>, set: usize, environment: &HostEnvironment) {
        if let Some(renewal) = &self.renewal {
            renewal.record(&self.device, commands, set, environment);
        }
    }

    /// Records that tables of a drop's light are of another environment, after [`Lighting::record`].
    pub(super) fn record_renewed(&self, commands: Recorder<'_>) {
        for (_, far) in locked(&self.made).far_drops.iter().filter(|((_, _, filled, _), _)| *filled)
        {
            far.record_renewed(&self.device, commands);
        }
    }

    /// The device that it is on.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Whether drops by this model of light show bright sources apart.
    pub(super) fn shows_sources(&self, light: &Light) -> bool {
        shows_apart(light) && (self.bright.is_some() || self.renewal.is_some())
    }

    /// A far drop by this model of light. `apart`: its bright sources are drawn as points of light, and it shows the
    /// rest. With `filled` frames fill it as far as they look around; without it is something to bind, and nothing reads it.
    /// `flat`: some drops are flattened.
    pub(super) fn far_drop(
        &self,
        light: &Light,
        apart: bool,
        filled: bool,
        flat: bool,
    ) -> Result<Arc<FarDrop>> {
        let bright = self.bright.as_ref().filter(|_| apart && shows_apart(light));
        let renewed = self.renewal.as_ref().filter(|_| apart && shows_apart(light));
        let of = (*light, bright.is_some() || renewed.is_some(), filled, flat);
        let mut rest = locked(&self.rest);
        if let Some((_, far)) = locked(&self.made).far_drops.iter().find(|(other, _)| *other == of)
        {
            return Ok(far.clone());
        }
        let (device, frame) = (&self.device, &self.frame);
        let scale = self.environment.radiance_scale;
        let seen = match (bright, &*rest, renewed) {
            (_, _, Some(renewed)) => renewed.rest.clone(),
            (None, _, None) => self.environment.clone(),
            (Some(_), Some(rest), _) => rest.clone(),
            (Some(bright), None, _) => {
                rest.insert(Arc::new(EnvironmentMap::new(device, &bright.rest, scale)?)).clone()
            }
        };
        let appearance = Appearance::new(device, frame, &seen, light)?;
        let glints = match renewed {
            Some(renewal) => {
                Glints::of(device, renewal.sources.clone(), MOST_SOURCES as u32, light)?
            }
            None => Glints::new(device, bright, scale, light)?,
        };
        let flat = flat.then(|| FlatLight::new(device, frame, &seen, light)).transpose()?;
        let far = Arc::new(FarDrop { seen, appearance, glints, flat });
        // Before it is filled: what a host renews meanwhile is then new for it as well.
        locked(&self.made).far_drops.push((of, far.clone()));
        if filled {
            device.count(|made| &mut made.tables);
            let is_filled = Commands::once(device, "far drop", |commands| {
                // Frames under way read the constants, and may renew it.
                let before = [Use::Uniform, Use::TransferWrite, Use::ComputeWrite];
                let after = [Use::TransferWrite, Use::ComputeWrite];
                memory_barrier(device, commands, &before, &after);
                frame.record(device, commands, &self.constants);
                far.record_renewed(device, commands);
            });
            if is_filled.is_err() {
                locked(&self.made).far_drops.retain(|(other, _)| *other != of);
            }
            is_filled?;
        }
        Ok(far)
    }

    /// Where the fragments of points and quads find a drop's light.
    pub(super) fn table(&self, plan: &FramePlan) -> Result<Arc<Table>> {
        let light = &plan.light;
        let of = match plan.optics {
            Optics::ClosedForm => return Ok(Arc::new(Table::None)),
            Optics::Far | Optics::Appearance => {
                return Ok(Arc::new(Table::Pictures(self.far_drop(light, false, true, false)?)));
            }
            Optics::Radial => TableOf::Radial(light.fresnel),
            _ => TableOf::Mask(plan.optics, plan.mask_size, *light),
        };
        let _others_wait = locked(&self.rest);
        if let Some((_, table)) = locked(&self.made).tables.iter().find(|(other, _)| *other == of) {
            return Ok(table.clone());
        }
        let table = Arc::new(Table::new(&self.device, plan)?);
        locked(&self.made).tables.push((of, table.clone()));
        Ok(table)
    }
}
