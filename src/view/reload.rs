//! Shaders compiled anew while the window is open, for whoever works on them: feature `reload`, in a
//! folder that has `glsl/`. A shader that does not compile changes nothing, and is reported.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use crate::gpu::Device;
#[cfg(feature = "reload")]
use crate::gpu::{Glsl, shaders};

/// How often the sources are looked at.
const INTERVAL: Duration = Duration::from_millis(500);

const SOURCES: &str = "glsl";

/// The sources and when they were last changed.
#[derive(Debug)]
pub struct Reload {
    seen: Option<SystemTime>,
    looked: Instant,
}

impl Reload {
    /// Knows the sources as they are.
    pub fn new() -> Self {
        Self { seen: newest(), looked: Instant::now() }
    }

    /// Compiles the shaders anew if a source has changed: how many, or what is wrong.
    pub fn poll(&mut self, device: &Arc<Device>, now: Instant) -> Option<Result<usize, String>> {
        if !cfg!(feature = "reload") || now - self.looked < INTERVAL {
            return None;
        }
        self.looked = now;
        let newest = newest();
        if newest == self.seen {
            return None;
        }
        self.seen = newest;
        Some(self.now(device))
    }

    /// Compiles all shaders, and replaces the device's if every one compiles.
    #[cfg(feature = "reload")]
    pub fn now(&mut self, device: &Arc<Device>) -> Result<usize, String> {
        let compiler = Glsl::new(SOURCES.as_ref())?;
        let compile = |shader: &&crate::gpu::Shader| {
            let words = compiler.compile(shader.name, shader.define)?;
            Ok(((shader.name, shader.define), words.into()))
        };
        let compiled: crate::gpu::ReplacedShaders =
            shaders::ALL.iter().map(compile).collect::<Result<_, String>>().map_err(one_line)?;
        let count = compiled.len();
        // SAFETY: the compiler made them; that bindings and constants are what they were is for who edits them.
        unsafe { device.replace_shaders(compiled) };
        Ok(count)
    }

    /// Says how to get what this program was built without.
    #[cfg(not(feature = "reload"))]
    pub fn now(&mut self, _: &Arc<Device>) -> Result<usize, String> {
        Err("this program cannot compile them: cargo run --release --features reload -- view"
            .into())
    }
}

/// The first line of a compiler's message that is an error.
#[cfg(feature = "reload")]
fn one_line(message: String) -> String {
    let error = message.lines().find(|line| line.contains("error:"));
    error.or(message.lines().next()).unwrap_or_default().into()
}

/// When the youngest source was changed; none where there are no sources.
fn newest() -> Option<SystemTime> {
    [SOURCES.to_string(), format!("{SOURCES}/include")]
        .iter()
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flatten()
        .filter_map(|entry| entry.ok()?.metadata().ok()?.modified().ok())
        .max()
}
