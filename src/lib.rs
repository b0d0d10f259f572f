//! Raindrops rendered as raindrops, at real-time rates, with the error known.
//!
//! # A frame
//!
//! Data flows one way. A [`scene::Scene`] says what to show, an [`environment::Environment`] what is
//! around it; [`plan::plan`] turns the scene into a [`plan::FramePlan`], the passes and models that it
//! requires, each with its reason; a [`renderer::Renderer`] draws by that plan.
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
//! - The physics of one drop, in float64, without approximation: [`optics`]. What the models of it
//!   leave out, by name: [`scene::model`]; by formula, picture and error: `docs/method.md`.
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
//! `cli` (the command `raindrops`, tables and plots) and `view` (the window) are on by default. Whoever
//! embeds the renderer sets `default-features = false` and has neither their code nor their dependencies.
//!
//! Rain in somebody else's frame: [`renderer::View`], on a device of theirs, [`device::HostDevice`]; `docs/embedding.md` is
//! the page to begin with, `examples/host_ash` and `examples/host_wgpu` run. So do `examples/one_frame.rs` and
//! `examples/your_frame.rs`, on devices of ours.

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
#[doc(hidden)]
pub mod passes;
pub mod picture;
pub mod plan;
pub mod rain;
pub mod reference;
pub mod renderer;
pub mod scene;
#[cfg(feature = "view")]
pub mod view;

pub use error::{Error, Result};
// Types of theirs stand in the interface for hosts.
pub use {ash, gpu_allocator};
