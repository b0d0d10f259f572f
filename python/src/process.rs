//! The devices of this process: opened with the first picture, kept until it ends, and never touched by a forked child.
//!
//! Threads, a driver's or those that trace and compare, do not go along into a forked child, so that a wait for one of them
//! would never end. Who computes first owns what is opened; another process that finds it in its memory is refused.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use raindrops::device::{Device, Instance, KeptDevice, Validation, choose_among, user_folder};
use raindrops::environment::Environment;
use raindrops::environment::guess::Guess;
use raindrops::measure::costs::ranked;
use raindrops::remark::Remark;
use raindrops::renderer::Lighting;
use raindrops::scene::Scene;

use crate::raise::{Raise as _, exception, tell};

/// The process that computed first; 0 before.
static OWNER: AtomicU32 = AtomicU32::new(0);
/// What was opened, by what was asked for.
static OPENED: Mutex<Vec<(Option<String>, KeptDevice)>> = Mutex::new(Vec::new());
/// What the library said of devices and was not told yet.
static SAID: Mutex<Vec<Remark>> = Mutex::new(Vec::new());

/// Called before anything is computed.
///
/// # Errors
/// `ForkError` in a child of a process that has computed.
pub fn enter() -> PyResult<()> {
    let own = std::process::id();
    match OWNER.compare_exchange(0, own, Ordering::AcqRel, Ordering::Acquire) {
        Err(owner) if owner != own => Err(Python::attach(|py| {
            let message = format!(
                "process {own} was forked from {owner} after raindrops had computed in that one, whose threads, a graphics \
                 driver's among them, such a child lacks; start workers by spawn or forkserver \
                 (multiprocessing.get_context(\"spawn\"), DataLoader(multiprocessing_context=\"spawn\")), or call nothing \
                 that computes before they are forked"
            );
            exception(py, "ForkError", &message)
        })),
        _ => Ok(()),
    }
}

/// Locks what a panic cannot leave half done.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub fn say(remark: &Remark) {
    lock(&SAID).push(remark.clone());
}

/// Gives what was said of devices as warnings.
pub fn tell_said(py: Python<'_>) -> PyResult<()> {
    let said = std::mem::take(&mut *lock(&SAID));
    tell(py, "", &said)
}

/// The device that `wanted` means, opened if it is not.
pub fn device(wanted: Option<&str>) -> raindrops::Result<Arc<Device>> {
    let mut opened = lock(&OPENED);
    if let Some((_, device)) = opened.iter().find(|(of, _)| of.as_deref() == wanted) {
        return Ok(Arc::clone(device));
    }
    let instance = Instance::new(Validation::Off)?;
    let reports: Vec<_> = ranked(&instance, user_folder().as_deref(), say)?
        .into_iter()
        .map(|ranked| ranked.report)
        .collect();
    let report = choose_among(&reports, wanted)?;
    let device = KeptDevice::open(&instance, report, user_folder(), say)?;
    let made = Arc::clone(&device);
    opened.push((wanted.map(Into::into), device));
    Ok(made)
}

/// What is on a device; left as it is where a forked child drops it.
struct Owned<T>(Option<T>);

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        if OWNER.load(Ordering::Acquire) != std::process::id() {
            std::mem::forget(self.0.take());
        }
    }
}

/// Devices' names by which pictures are drawn, and what was prepared last: where a guessed environment is in pictures,
/// and light on the device.
#[pyclass(frozen, module = "raindrops._native")]
pub struct Session {
    wanted: Option<String>,
    guess: Mutex<Option<Arc<Guess>>>,
    lit: Mutex<Owned<(Arc<Environment>, Arc<Lighting>)>>,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (device=None))]
    fn new(device: Option<String>) -> Self {
        Self { wanted: device, guess: Mutex::new(None), lit: Mutex::new(Owned(None)) }
    }
}

impl Session {
    /// What `work` makes on the device. One that is lost on the way is forgotten, so that the next picture opens another.
    pub fn on_device<T>(
        &self,
        work: impl FnOnce(&Arc<Device>) -> raindrops::Result<T>,
    ) -> raindrops::Result<T> {
        let device = device(self.wanted.as_deref())?;
        work(&device).inspect_err(|error| {
            if error.is_lost() {
                lock(&OPENED).retain(|(_, kept)| !Arc::ptr_eq(kept, &device));
                lock(&self.lit).0 = None;
            }
        })
    }

    /// The guess of what is around a picture behind a scene's drops.
    pub fn guess(&self, scene: &Scene) -> Arc<Guess> {
        let mut kept = lock(&self.guess);
        let found = kept.take().filter(|guess| guess.is_for(scene));
        kept.insert(found.unwrap_or_else(|| Arc::new(Guess::for_scene(scene)))).clone()
    }

    /// The environment that was prepared last, if it is this one.
    pub fn known(&self, environment: Environment) -> Arc<Environment> {
        match &lock(&self.lit).0 {
            Some((of, _)) if is_same(of, &environment) => of.clone(),
            _ => Arc::new(environment),
        }
    }

    /// The environment on the device.
    pub fn lighting(
        &self,
        device: &Arc<Device>,
        environment: &Arc<Environment>,
    ) -> raindrops::Result<Arc<Lighting>> {
        let mut lit = lock(&self.lit);
        let fits = |(of, lighting): &&(Arc<Environment>, Arc<Lighting>)| {
            is_same(of, environment) && Arc::ptr_eq(lighting.device(), device)
        };
        if let Some((_, lighting)) = lit.0.as_ref().filter(fits) {
            return Ok(lighting.clone());
        }
        let lighting = Arc::new(Lighting::new(device, environment)?);
        lit.0 = Some((environment.clone(), lighting.clone()));
        Ok(lighting)
    }
}

fn is_same(a: &Arc<Environment>, b: &Environment) -> bool {
    std::ptr::eq(&raw const **a, b) || (a.width() == b.width() && a.texels() == b.texels())
}

/// Every Vulkan device, in the order of the command `devices`, as dicts.
#[pyfunction]
pub fn devices(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    enter()?;
    let found = py.detach(|| {
        let instance = Instance::new(Validation::Off)?;
        ranked(&instance, user_folder().as_deref(), say)
    });
    tell_said(py)?;
    let each = found.raise(py)?.into_iter().map(|ranked| {
        let row = PyDict::new(py);
        let report = ranked.report;
        row.set_item("name", &report.name)?;
        row.set_item("driver", &report.driver)?;
        row.set_item("driver_info", &report.driver_info)?;
        row.set_item("api_version", &report.api_version)?;
        row.set_item("type", report.kind)?;
        row.set_item("missing", &report.missing)?;
        Ok(row)
    });
    each.collect()
}

/// Writes the compiled pipelines of this process's devices to the user's cache: at its end.
#[pyfunction]
pub fn close() {
    if OWNER.load(Ordering::Acquire) == std::process::id() {
        lock(&OPENED).clear();
    }
}
