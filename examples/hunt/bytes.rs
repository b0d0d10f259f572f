//! Whether other runs give the same bytes: by new renderers, part by part, and in processes whose driver has one thread and
//! two. A driver reads its number of threads when its device is opened, so each number has a process of its own.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, ensure};
use raindrops::picture::Picture;

use super::models::{Model, differing};
use super::row::Bytes;

/// lavapipe's number of threads; other drivers do not read it.
pub const THREADS: &str = "LP_NUM_THREADS";

/// How this program draws in another process.
#[derive(Clone, Debug)]
pub struct Child {
    pub program: PathBuf,
    /// Options that name the device.
    pub options: Vec<String>,
}

impl Child {
    /// The picture of a scene file by a preset, with so many threads of the driver.
    fn picture(
        &self,
        scene: &Path,
        photographs: &Path,
        preset: &str,
        threads: u32,
    ) -> anyhow::Result<Picture> {
        let aside = tempfile::tempdir()?;
        let file = aside.path().join("picture.exr");
        let mut command = Command::new(&self.program);
        command.arg("picture").arg(scene).arg("--preset").arg(preset).arg("-o").arg(&file);
        command.arg("--photographs").arg(photographs).args(&self.options);
        let output = command.env(THREADS, threads.to_string()).output();
        let output = output.with_context(|| self.program.display().to_string())?;
        let said = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "with {THREADS}={threads}: {}", said.trim());
        Ok(Picture::read(&file)?)
    }
}

/// In how many pixels other runs differ from the first.
pub fn bytes_of(
    model: &Model<'_>,
    first: &Picture,
    child: &Child,
    scene: &Path,
    photographs: &Path,
) -> anyhow::Result<Bytes> {
    let mut bytes = Bytes::default();
    for _ in 0..2 {
        bytes.again = bytes.again.max(differing(first, &model.draw(1)?.picture));
    }
    let preset = model.scene.model.preset.name();
    let by_threads = |threads| -> anyhow::Result<u32> {
        Ok(differing(first, &child.picture(scene, photographs, preset, threads)?))
    };
    (bytes.one_thread, bytes.two_threads) = (by_threads(1)?, by_threads(2)?);
    let by_parts = model.draw_by_parts()?;
    bytes.by_parts = by_parts.map(|picture| differing(first, &picture));
    Ok(bytes)
}
