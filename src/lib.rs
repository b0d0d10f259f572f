//! Raindrops rendered as raindrops, at real-time rates, with the error known.
//!
//! This page is for programmers: rain in the frame of your own Vulkan renderer, then rain in a program without one, then
//! where to read on. `docs/embedding.md` explains each step of the first.
//!
//! # In your frame
//!
//! You lend a device, and a command buffer for each frame. Recording a frame submits nothing, waits for nothing and
//! allocates nothing. Set-up (`Lighting`, `View`, `View::grow`) submits to your queue and waits.
//!
//! ```no_run
//! use std::f64::consts::FRAC_PI_2;
//! use std::sync::Arc;
//! use raindrops::ash::vk;
//! use raindrops::glam::{DMat4, DVec2, DVec3};
//! use raindrops::device::{Device, Features, HostDevice, HostImage, ImageState, QueueLock, requirements};
//! use raindrops::environment::Environment;
//! use raindrops::plan::{Output, plan};
//! use raindrops::renderer::{
//!     Blend, DepthConvention, FrameInput, HostEnvironment, HostMotion, HostPaneDrops, HostParticles, HostShelter, Lighting,
//!     LiveInfo, PaneDropLayout, ParticleCount, ParticleLayout, RainField, View, ViewInfo,
//! };
//! use raindrops::scene::{ImageSize, RainSettings, Scene, Shelter};
//! use raindrops::scene::background::DepthKind;
//! use raindrops::scene::camera::Camera;
//! use raindrops::scene::matrices::ClipSpace;
//! use raindrops::scene::model::{FarRain, Preset};
//! use raindrops::scene::pane::PaneDrop;
//! use raindrops::scene::real_rain::RealRain;
//!
//! # fn rain(
//! #     (host, queue_mutex): (HostDevice, Arc<std::sync::Mutex<()>>),
//! #     [output, color, depth, cube, motion, nearest, above]: [HostImage; 7],
//! #     ([drops, counts, on_pane], bytes): ([vk::Buffer; 3], u64),
//! #     (camera_before, seconds_before): (Camera, f64),
//! #     (commands, slot, seconds): (vk::CommandBuffer, usize, f64),
//! #     (view_matrix, projection, size): (DMat4, DMat4, (u32, u32)),
//! #     (view_above, projection_above, my_drops): (DMat4, DMat4, Vec<PaneDrop>),
//! # ) -> raindrops::Result<()> {
//! # let (mut core, mut vulkan12, mut vulkan13) = Default::default();
//! # let (width, height) = size;
//! // Where other threads use your queue: their lock.
//! let mutex = queue_mutex.clone();
//! let lock: QueueLock = Arc::new(move |work: &mut dyn FnMut()| { let _guard = mutex.lock().expect("the lock"); work() });
//! let host = HostDevice { queue_lock: Some(lock), ..host };
//!
//! let required = requirements(Preset::Fast);
//! required.features.enable(&mut core, &mut vulkan12, &mut vulkan13); // the structures that you make your device with
//! let device = unsafe { Device::import(host, &required)? };          // `HostDevice`: what you lend
//!
//! // Once: the light, the drops, and a view of them for pictures of one size.
//! let mut scene = Scene::default();          // a unit is a metre; `scene.metres` makes it another length
//! scene.rain = Some(RainSettings::of(RealRain { rate: 25.0, ..RealRain::default() })); // millimetres an hour
//! scene.model.preset = Preset::Fast;         // as in `requirements`
//! scene.image = ImageSize { width, height }; // of your output; colour, depth, motion and nearest depth have it, too
//! let environment = Environment::bundled()?; // a sky; `load` reads a picture, `from_texels` takes yours
//! let frame_plan = plan(&scene, &environment, Output::Radiance)?;
//! let lighting = Arc::new(Lighting::new(&device, &environment)?);
//! let rain = Arc::new(RainField::new(&device, &scene));
//! let info = ViewInfo { has_color: true, has_depth: true, ..ViewInfo::default() };
//! let mut view = View::new(&lighting, &rain, &scene, &frame_plan, &info)?;
//!
//! // Each frame.
//! unsafe { view.retired(slot)? };        // after the slot's fence; returns the frame's counts and times, if the slot had one
//! let (camera, mapping) = Camera::from_matrices(view_matrix, projection, size, ClipSpace::YDown)?;
//! scene.camera = camera;                 // its shutter and aperture are 0
//! scene.time = seconds;
//! let input = FrameInput::new(&scene, output)
//!     .before(color, 1.0)                // what is behind the drops
//!     .hidden_by(depth, mapping.into()); // hides what is farther
//! unsafe { view.record(commands, slot, &input)? };
//!
//! // Where drops had no room: outside of recording.
//! # let Some(report) = (unsafe { view.retired(slot)? }) else { return Ok(()) };
//! if report.tiles.is_some_and(|tiles| tiles.lacks_room) { view.grow()?; }
//!
//! // What a temporal upscaler needs: asked for when the view is made, then named with each frame.
//! let info = ViewInfo { motion: Some(vk::Format::R16G16_SFLOAT), nearest_depth: Some(vk::Format::R32_SFLOAT), ..info };
//! let mut view = View::new(&lighting, &rain, &scene, &frame_plan, &info)?; // a view that is made for it
//! let input = input
//!     .moved(HostMotion::since(camera_before, seconds_before, motion)) // where the drop was, less where it is
//!     .nearest(nearest);                 // of its centre along the view axis, scene units
//!
//! // Drops of your own: how many there may be is said before `plan`, where they are with each frame.
//! scene.host_particles = 50_000;         // at most; before `plan` and `RainField::new`
//! let layout = ParticleLayout { stride: 32, position: 0, radius: 12, velocity: Some(16), id: Some(28) };
//! let count = ParticleCount::OnDevice(counts, 0);           // or `Number`
//! let within = [DVec3::splat(-4.0), DVec3::splat(4.0)];     // the box that holds them
//! let own = HostParticles::new((drops, bytes), layout, count, within, 0.02); // the largest radius
//! let input = FrameInput::new(&scene, output).before(color, 1.0).hidden_by(depth, mapping.into()).with_particles(own);
//!
//! // And on the scene's pane, beside other drops in the air.
//! scene.host_pane_drops = 4000;          // at most; before `plan`
//! let layout = PaneDropLayout { stride: 16, at: 0, radius: 8, contact_angle: Some(12) };
//! let within = [DVec2::new(-0.5, -0.3), DVec2::new(0.5, 0.3)]; // the box that holds their middles
//! let largest = (0.004, 80.0);           // radius and contact angle
//! let own = HostPaneDrops::new((on_pane, bytes), layout, ParticleCount::OnDevice(counts, 4), within, largest);
//! let input = FrameInput::new(&scene, output).before(color, 1.0).hidden_by(depth, mapping.into()).with_drops_on_pane(own);
//!
//! // No rain under your roofs: the depth that a camera sees from above, of as many texels as are said before `plan`.
//! scene.shelter = Some(Shelter::of_host(512, 512));         // columns along x, rows along z; before `plan`
//! let roofs = HostShelter::from_above(above, projection_above * view_above, ClipSpace::YDown)?;
//! let input = FrameInput::new(&scene, output).before(color, 1.0).hidden_by(depth, mapping.into()).under(roofs); // with each frame
//!
//! // Light that changes, in place of that above.
//! let lighting = Arc::new(Lighting::live(&device, LiveInfo::default())?); // a cube map
//! let input = input.around(HostEnvironment::new(cube));                   // in whichever frame you like
//!
//! // Drops on the scene's pane that seldom change: outside of recording.
//! scene.pane.as_mut().unwrap().drops = my_drops;            // at, radius, contact_angle; none may overlap
//! view.renew_pane(&scene)?;
//! # Ok(())
//! # }
//! ```
//!
//! The examples `host_ash` and `host_wgpu` are whole programs.
//!
//! # Without a renderer of your own
//!
//! Data flows one way. A [`scene::Scene`] says what to show, an [`environment::Environment`] what is
//! around it. [`plan::plan`] turns the scene into a [`plan::FramePlan`]: the passes and models that it
//! needs, each with its reason. A [`renderer::Renderer`] draws by that plan.
//!
//! ```no_run
//! use raindrops::environment::Environment;
//! use raindrops::device::{Device, Instance, Validation};
//! use raindrops::plan::{Output, plan};
//! use raindrops::renderer::Renderer;
//! use raindrops::scene::Scene;
//!
//! # fn main() -> raindrops::Result<()> {
//! let scene = Scene::default(); // the paper's: a million drops
//! let environment = Environment::bundled()?;
//! let instance = Instance::new(Validation::Off)?;
//! let device = Device::open(&instance, instance.choose(None)?)?;
//! let plan = plan(&scene, &environment, Output::Display)?;
//! let mut renderer = Renderer::new(&device, &scene, &environment, &plan)?;
//! renderer.submit(&scene)?;
//! println!("{} drops in view", renderer.finish()?.counts.visible);
//! let srgb = renderer.read_display()?; // or `display()`, the image on the device
//! # Ok(())
//! # }
//! ```
//!
//! # Where to read on
//!
//! - The physics of one drop, in float64, without approximation: [`optics`]. What the models
//!   leave out, by name: [`scene::model`]; with formula, picture and error: `docs/method.md`.
//! - Where a million drops are at any time, exactly, with nothing stored: [`rain`], and in clusters that
//!   fall with them: [`rain::clusters`]. Which of them are in view: [`rain::cull`].
//! - A frame from top to bottom, every barrier of it: [`renderer`]. Its passes, each beside its shader
//!   of the same name in `glsl/`: `src/passes`. Vulkan itself, one object a file, knowing nothing of
//!   rain: `src/gpu`. Both are for this package's own tests; what a user needs of them is in [`device`].
//! - How far a picture is from the truth: the ray tracer [`mod@reference`], the metrics
//!   [`picture::metrics`] and [`picture::flip`]. How fast it is: [`measure`].
//! - A window: `view`, with the feature of that name. A film: [`scene::film`].
//!
//! # Features
//!
//! `cli` (the command `raindrops`, tables and plots) and `view` (the window) are on by default. With
//! `default-features = false` neither their code nor their dependencies are in your program.
//!
//! The examples `one_frame` and `your_frame` draw on devices of their own. `your_frame` uses hidden modules and says what
//! to take instead.

#[doc(hidden)]
pub mod abi;
#[cfg(feature = "cli")]
pub mod cli;
pub mod device;
pub mod environment;
mod error;
pub mod files;
#[doc(hidden)]
pub mod gpu;
pub mod measure;
pub mod optics;
pub mod pane;
#[doc(hidden)]
pub mod passes;
pub mod picture;
pub mod plan;
pub mod rain;
pub mod reference;
pub mod remark;
pub mod renderer;
pub mod scene;
mod thousands;
#[cfg(feature = "view")]
pub mod view;

pub use error::{Error, Result};
// Types of theirs stand in the interface for hosts.
pub use {ash, glam, gpu_allocator};
