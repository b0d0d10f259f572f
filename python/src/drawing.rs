//! One picture to be drawn: its scene, what is behind and around the drops, and what it is asked for.

use std::sync::{Arc, Mutex};

use half::f16;
use numpy::{PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raindrops::Error;
use raindrops::device::{Device, user_folder};
use raindrops::environment::Environment;
use raindrops::environment::guess::is_guessed;
use raindrops::measure;
use raindrops::measure::costs::costs;
use raindrops::picture::Picture;
use raindrops::picture::layers::Layers;
use raindrops::picture::masks::Masks;
use raindrops::picture::plate::Plate;
use raindrops::plan::{Choice, FramePlan, Output, plan_by};
use raindrops::reference::{Tracer, Truth};
use raindrops::remark::Remark;
use raindrops::renderer::parts::Parts;
use raindrops::renderer::{FrameReport, RainField, lost_light};
use raindrops::scene::Scene as Parsed;
use raindrops::scene::background::{Background, DepthKind};
use raindrops::scene::film::Film;
use raindrops::scene::model::Preset;

use crate::arrays::{Pixels, linear, plane, volume};
use crate::interrupt::{listening, stop};
use crate::process::{Session, enter, lock, tell_said};
use crate::raise::{Raise as _, exception, tell};
use crate::scene::Scene;

/// A picture that is drawn when it is asked for.
#[pyclass(frozen, module = "raindrops._native")]
pub struct Drawing {
    /// The scene that was given, which the reference traces.
    scene: Parsed,
    /// The frame of its film, and where that frame's motion ends.
    frame: Parsed,
    until: Parsed,
    plate: Option<Plate>,
    environment: Arc<Environment>,
    session: Py<Session>,
    /// What preset `auto` took.
    choice: Mutex<Option<Option<Choice>>>,
}

/// What was drawn, and what is worth saying of it.
type Drawn<T> = (T, Vec<Remark>);

#[pymethods]
impl Drawing {
    /// Reads and checks what it is of; opens no device.
    #[new]
    #[pyo3(signature = (session, scene, color=None, depth=None, depth_kind="planar", depth_invalid=None, environment=None, frame=0))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        py: Python<'_>,
        session: Py<Session>,
        scene: &Scene,
        color: Option<Pixels<'_>>,
        depth: Option<PyReadonlyArray2<'_, f64>>,
        depth_kind: &str,
        depth_invalid: Option<f64>,
        environment: Option<Pixels<'_>>,
        frame: u32,
    ) -> PyResult<Self> {
        enter()?;
        let (mut scene, fps) = (scene.scene.clone(), scene.fps);
        let depth_kind = match depth_kind {
            "planar" => DepthKind::Planar,
            "radial" => DepthKind::Radial,
            other => {
                let problem = format!("depth_kind is '{other}': 'planar' or 'radial'");
                return Err(exception(py, "SceneError", &problem));
            }
        };
        let color = color.map(|color| color.picture()).transpose()?;
        let depth = depth.map(|depth| depth.as_slice().map(<[f64]>::to_vec)).transpose()?;
        let around = environment.map(|pixels| pixels.picture()).transpose()?;
        let made = py.detach(|| -> raindrops::Result<_> {
            let mut plate = None;
            if color.is_some() || depth.is_some() {
                let size = (scene.image.width, scene.image.height);
                let background = Background { depth_kind, depth_invalid, ..Background::default() };
                plate = Some(Plate::from_pixels(size, color, depth, &background)?);
                scene.background = Background::default();
            }
            scene.read_shelter()?;
            let mut shown = scene.film.frame(&scene, frame);
            shown.read_particles()?;
            let until = match fps {
                Some(fps) => {
                    // The next picture of a video is so much later, whatever the pace of a film.
                    let film = Film { fps, ..Film::default() };
                    Parsed { film, ..shown.clone() }.motion_end(&shown, 0)
                }
                None => scene.motion_end(&shown, frame),
            };
            let held = session.get();
            let (environment, remarks) = surroundings(held, &scene, plate.as_ref(), around)?;
            let environment = held.known(environment);
            Ok((Self::of(scene, (shown, until), plate, environment, session), remarks))
        });
        let (drawing, remarks) = made.raise(py)?;
        tell(py, "", &remarks)?;
        Ok(drawing)
    }

    /// H x W x 3 float32, linear.
    fn radiance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let picture = self.draw(py, |device| self.radiance_of(device, &self.frame))?;
        linear(py, &picture)
    }

    /// H x W x 3 uint8, tone mapped by the scene's operator.
    fn display<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let (bytes, size) = self.draw(py, |device| {
            let draw = |parts: &mut Parts<'_>| parts.display(&self.frame);
            let (bytes, remarks) = self.drawn(device, &self.frame, Output::Display, draw)?;
            Ok(((bytes, self.frame.picture_size()), remarks))
        })?;
        volume(py, &bytes, size)
    }

    /// Every layer, H x W, as a dict; `color` is H x W x 4 and `motion` H x W x 2, halves as their bits; `pane.A` with a
    /// pane alone.
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let layers = self.draw(py, |device| self.layers_of(device, &self.frame, true))?;
        let size = (layers.width, layers.height);
        let bits = |halves: &[f16]| halves.iter().map(|half| half.to_bits()).collect::<Vec<u16>>();
        let all = PyDict::new(py);
        all.set_item("color", volume(py, &bits(layers.color.as_flattened()), size)?)?;
        all.set_item("motion", volume(py, &bits(layers.motion.as_flattened()), size)?)?;
        all.set_item("Z", plane(py, layers.depth, size)?)?;
        all.set_item("count", plane(py, layers.count, size)?)?;
        all.set_item("id", plane(py, layers.id, size)?)?;
        if !layers.glass.is_empty() {
            all.set_item("pane.A", plane(py, bits(&layers.glass), size)?)?;
        }
        Ok(all)
    }

    /// Opacity and contrast of single drops, H x W float32 each.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn masks<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>)> {
        let masks = self.draw(py, |device| {
            let (layers, mut remarks) = self.layers_of(device, &self.frame, false)?;
            let (medium, more) = self.layers_of(device, &self.frame.as_medium(), false)?;
            remarks.extend(more);
            let behind = Parsed { pane: None, ..self.frame.without_rain() };
            let (behind, more) = self.radiance_of(device, &behind)?;
            remarks.extend(more);
            Ok((Masks::of(&layers, &medium, &behind), remarks))
        })?;
        let size = (masks.width, masks.height);
        Ok((plane(py, masks.opacity, size)?, plane(py, masks.contrast, size)?))
    }

    /// By the float64 ray tracer: H x W x 3 radiance, and H x W coverage and opacity, float32.
    #[pyo3(signature = (samples, seed=0, rain_to=None))]
    #[allow(clippy::type_complexity, reason = "three arrays")]
    fn reference<'py>(
        &self,
        py: Python<'py>,
        samples: u32,
        seed: u64,
        rain_to: Option<f64>,
    ) -> PyResult<(Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>)>
    {
        enter()?;
        let truth = Truth { samples, seed, rain_to, ..Truth::default() };
        let traced = listening(py, || -> raindrops::Result<_> {
            let mut scene = self.scene.clone();
            scene.read_particles()?;
            scene.read_shelter()?;
            let plate = match &self.plate {
                Some(plate) => plate.clone(),
                None => Plate::of(&scene)?,
            };
            let tracer = Tracer::new_until(&scene, &self.environment, truth, stop).before(plate);
            Ok(tracer.trace(&|_| ()))
        })?;
        let traced = traced.raise(py)?;
        let size = (traced.picture.width, traced.picture.height);
        let picture = linear(py, &traced.picture)?;
        Ok((picture, plane(py, traced.coverage, size)?, plane(py, traced.opacity, size)?))
    }
}

impl Drawing {
    fn of(
        scene: Parsed,
        (frame, until): (Parsed, Parsed),
        plate: Option<Plate>,
        environment: Arc<Environment>,
        session: Py<Session>,
    ) -> Self {
        let choice = Mutex::new(None);
        Self { scene, frame, until, plate, environment, session, choice }
    }

    /// Draws without the interpreter's lock, and tells what is worth saying.
    fn draw<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Arc<Device>) -> raindrops::Result<Drawn<T>> + Send,
    ) -> PyResult<T> {
        enter()?;
        let made = py.detach(|| self.session.get().on_device(work));
        tell_said(py)?;
        let (made, remarks) = made.raise(py)?;
        tell(py, "", &remarks)?;
        Ok(made)
    }

    fn radiance_of(
        &self,
        device: &Arc<Device>,
        scene: &Parsed,
    ) -> raindrops::Result<Drawn<Picture>> {
        self.drawn(device, scene, Output::Radiance, |parts| parts.radiance(scene))
    }

    /// `is_read`: whether the user gets all of them, so that what the plan leaves out is worth saying.
    fn layers_of(
        &self,
        device: &Arc<Device>,
        scene: &Parsed,
        is_read: bool,
    ) -> raindrops::Result<Drawn<Layers>> {
        let plan = self.plan(device, scene, Output::Layers)?;
        let drawn = self.drawn_by(device, scene, &plan, |parts| parts.layers(scene))?;
        let (layers, mut remarks) = drawn;
        remarks.extend(is_read.then(|| plan.remarks()).into_iter().flatten());
        Ok((layers, remarks))
    }

    /// What `draw` makes of the parts of `scene`.
    fn drawn<T>(
        &self,
        device: &Arc<Device>,
        scene: &Parsed,
        output: Output,
        draw: impl FnOnce(&mut Parts<'_>) -> raindrops::Result<(T, FrameReport)>,
    ) -> raindrops::Result<Drawn<T>> {
        let plan = self.plan(device, scene, output)?;
        let (made, mut remarks) = self.drawn_by(device, scene, &plan, draw)?;
        remarks.extend(plan.remarks());
        Ok((made, remarks))
    }

    /// Draws by a plan, whose own remarks are left out.
    fn drawn_by<T>(
        &self,
        device: &Arc<Device>,
        scene: &Parsed,
        plan: &FramePlan,
        draw: impl FnOnce(&mut Parts<'_>) -> raindrops::Result<(T, FrameReport)>,
    ) -> raindrops::Result<Drawn<T>> {
        let lighting = self.session.get().lighting(device, &self.environment)?;
        let rain = Arc::new(RainField::new(device, scene));
        let mut parts = Parts::new(device, &self.environment, plan).showing(&lighting, &rain);
        if let Some(plate) = &self.plate {
            parts = parts.before(plate);
        }
        if plan.layers {
            let until = Parsed { time: self.until.time, ..scene.clone() };
            let camera =
                raindrops::scene::camera::Camera { near: scene.camera.near, ..self.until.camera };
            parts.move_until(Parsed { camera, ..until });
        }
        let (made, report) = draw(&mut parts)?;
        let mut remarks = report.counts.remarks(report.room);
        if let (Some(most), true) = (parts.clips_background(), !plan.layers) {
            remarks.push(Remark::warning(format!(
                "the background is brighter than {most}, which is clipped: it is stored as the environment is"
            )));
        }
        Ok((made, remarks))
    }

    fn plan(
        &self,
        device: &Arc<Device>,
        scene: &Parsed,
        output: Output,
    ) -> raindrops::Result<FramePlan> {
        if scene.model.preset != Preset::Auto {
            return plan_by(scene, &self.environment, None, output);
        }
        let mut choice = lock(&self.choice);
        if choice.is_none() {
            let costs = costs(device, user_folder().as_deref(), crate::process::say)?;
            *choice =
                Some(measure::resolve(device, &self.frame.whole(), &self.environment, &costs)?);
        }
        plan_by(scene, &self.environment, choice.as_ref().and_then(Option::as_ref), output)
    }
}

/// A problem of an environment that is in no file.
fn of_array(error: Error) -> Error {
    match error {
        Error::Environment { path, problem } => {
            Error::Scene { place: format!("environment {}", path.display()), problem }
        }
        other => other,
    }
}

/// What is around the drops, and what is worth saying of it and of the background: as the command `render` has it.
fn surroundings(
    session: &Session,
    scene: &Parsed,
    plate: Option<&Plate>,
    around: Option<Picture>,
) -> raindrops::Result<Drawn<Environment>> {
    let mut remarks = Vec::new();
    let chosen = &scene.environment;
    let color = plate.and_then(Plate::color);
    let is_plain = chosen.file.is_none() && chosen.radiance.is_none();
    let guessed = |from: &str| {
        Remark::note(format!(
            "no environment is given: what the drops show is guessed from {from}, continued around the camera; a sun or \
             lamp that is not in it is missing (environment= gives a panorama)"
        ))
    };
    let environment = match (around, color) {
        (Some(Picture { width, height, pixels }), _) => {
            Environment::from_texels("array", width, height, pixels).map_err(of_array)?
        }
        (None, Some(color)) if is_plain => {
            remarks.push(guessed("the picture"));
            session.guess(scene).around(color).map_err(of_array)?
        }
        _ => {
            if is_guessed(scene) {
                remarks.push(guessed("the background"));
            }
            Environment::of(scene)?
        }
    };
    let name = format!("environment {}", environment.name());
    let of = |name: &str, remark: &Remark| Remark {
        severity: remark.severity,
        text: format!("{name}: {}", remark.text),
    };
    remarks.extend(environment.remarks().iter().map(|remark| of(&name, remark)));
    if !environment.mended().is_nothing() {
        remarks.push(Remark::warning(format!("{name}: {}", environment.mended())));
    }
    let lost = lost_light(&environment);
    if lost > 0.0 {
        remarks.push(Remark::warning(format!(
            "{name}: texels over 10⁹ times the mean of the others are stored as that much; the sky loses {:.3} % of its light",
            100.0 * lost
        )));
    }
    let read;
    let background = match plate {
        Some(plate) => plate,
        None => {
            read = Plate::of(scene)?;
            &read
        }
    };
    let named = background.remarks().iter();
    remarks
        .extend(named.map(|(file, remark)| of(&format!("background {}", file.display()), remark)));
    if background.depth().is_some() && background.color().is_none() {
        remarks.push(Remark::warning(
            "a depth without a background: drops are hidden behind things that the picture does not show",
        ));
    }
    Ok((environment, remarks))
}
