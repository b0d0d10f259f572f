//! What is kept from one run to the next, in files for each device and version of its driver: compiled
//! pipelines, and figures that were measured on it.
//!
//! A driver trusts what it is given, so a file is given to it only if the checksum over every byte
//! agrees and the data names this device and driver. Otherwise pipelines are compiled anew, and the
//! file is written anew. Figures are checked likewise, and measured anew. It is a cache.

use std::fmt::Display;
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::pipeline_cache::HEADER;
use crate::files::write_whole;
use crate::gpu::{Device, DeviceReport, Instance, PipelineKey};
use crate::remark::Remark;
use crate::{Error, Result};

/// What a file begins with, before a CRC-32 and the data.
const MAGIC: &[u8; 8] = b"drops-1\n";
const HEAD: usize = MAGIC.len() + 4;

/// A file over this is begun anew: each image size adds pipelines, and nothing takes any away.
const MAX_BYTES: u64 = 64 << 20;

/// The folder of the user's cache, by the rules of the system; none where it has no home.
pub fn user_folder() -> Option<PathBuf> {
    dirs::cache_dir().map(|folder| folder.join("raindrops"))
}

/// One device's pipelines on disk.
#[derive(Clone, Debug)]
pub struct PipelineFile {
    path: PathBuf,
    key: PipelineKey,
    data: Vec<u8>,
}

impl PipelineFile {
    /// The file for `key` in `folder`, read if it is there; and what is wrong with it, if anything.
    pub fn read(folder: &Path, key: &PipelineKey) -> (Self, Option<Remark>) {
        let path = path_of(folder, "pipelines", key);
        let file = |data| Self { path: path.clone(), key: *key, data };
        let anew = |reason: &str| {
            Error::read(&path, format!("{reason}; pipelines are compiled anew")).to_string()
        };
        match read(&path, key) {
            Ok(data) if key.heads(&data) => (file(data), None),
            // An earlier version of the program kept these, and the driver gives no others.
            Ok(data) if data.len() < HEADER => {
                let what = anew("it has less than the header of compiled pipelines");
                (file(Vec::new()), Some(Remark::detail(what)))
            }
            Ok(_) => {
                let what = anew("it is of another device or driver");
                (file(Vec::new()), Some(Remark::note(what)))
            }
            Err(problem) => {
                let problem = problem.map(|reason| Remark::note(anew(&reason)));
                (file(Vec::new()), problem)
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was read: sound, of this device and driver; empty if there was no such thing.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// Writes `data` in place of what was read, if there is anything new in it. Some drivers give data that do not begin as
    /// Vulkan has it, and that would be refused by the next run: then no file is kept, and the answer is `false`.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, data: &[u8]) -> Result<bool> {
        if !self.key.heads(data) {
            return match std::fs::remove_file(&self.path) {
                Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
                removed => removed.map(|()| false).map_err(|error| Error::write(&self.path, error)),
            };
        }
        // SwiftShader puts a header before what it was opened with: that is nothing new either, and
        // would grow by one from run to run.
        if self.data.is_empty() || !data.ends_with(&self.data) {
            write(&self.path, &self.key, data)?;
        }
        Ok(true)
    }
}

fn write(path: &Path, key: &PipelineKey, data: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| Error::write(path, error))?;
    }
    write_whole(path, &[&head_of(key, data)[..], data].concat())
}

/// What stands before `data`: the checksum is over the driver's version too.
fn head_of(key: &PipelineKey, data: &[u8]) -> [u8; HEAD] {
    let mut sum = crc32fast::Hasher::new();
    sum.update(&key.driver_version.to_le_bytes());
    sum.update(data);
    let mut head = [0; HEAD];
    head[..MAGIC.len()].copy_from_slice(MAGIC);
    head[MAGIC.len()..].copy_from_slice(&sum.finalize().to_le_bytes());
    head
}

/// The file of this kind for `key`.
fn path_of(folder: &Path, kind: &str, key: &PipelineKey) -> PathBuf {
    let PipelineKey { vendor, device, driver_version, uuid } = key;
    let uuid = u128::from_be_bytes(*uuid);
    folder.join(format!("{kind}-{vendor:04x}-{device:04x}-{driver_version:08x}-{uuid:032x}"))
}

/// The data of a sound file, whatever they are, or what is wrong: nothing, if it is not there.
fn read(path: &Path, key: &PipelineKey) -> Result<Vec<u8>, Option<String>> {
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => None,
        _ => Some(error.to_string()),
    };
    let wrong = |what: &str| Err(Some(what.into()));
    // Asked before it is opened: opening a pipe waits for its other end.
    if !path.metadata().map_err(failed)?.is_file() {
        return wrong("it is not a regular file");
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return wrong("it is over 64 MiB");
    }
    let (head, data) = bytes.split_at(bytes.len().min(HEAD));
    if head != head_of(key, data) {
        return wrong("it is damaged, or of another version");
    }
    Ok(data.to_vec())
}

/// Figures that were measured on a device, as text, kept beside its pipelines.
#[derive(Clone, Debug)]
pub struct FiguresFile {
    path: PathBuf,
    key: PipelineKey,
}

impl FiguresFile {
    /// The file for `key` in `folder`.
    pub fn new(folder: &Path, key: &PipelineKey) -> Self {
        Self { path: path_of(folder, "figures", key), key: *key }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it holds, if it is there and sound.
    ///
    /// # Errors
    /// [`Error::File`] for what is there and is not sound.
    pub fn read(&self) -> Result<Option<String>> {
        let problem =
            |reason| Error::read(&self.path, format!("{reason}; the device is measured anew"));
        match read(&self.path, &self.key) {
            Ok(data) => {
                String::from_utf8(data).map(Some).map_err(|error| problem(error.to_string()))
            }
            Err(reason) => reason.map_or(Ok(None), |reason| Err(problem(reason))),
        }
    }

    /// Writes `text` in its place.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, text: &str) -> Result<()> {
        write(&self.path, &self.key, text.as_bytes())
    }
}

/// A device whose compiled pipelines are read when it is opened and written when this is dropped.
pub struct KeptDevice {
    device: Arc<Device>,
    file: Option<PipelineFile>,
    say: fn(&Remark),
}

impl KeptDevice {
    /// Opens the device that `report` describes, with its pipelines in `folder`. Where there is none,
    /// or something goes wrong with it, `say` is told in a line, and all else goes on.
    ///
    /// # Errors
    /// See [`Device::open`].
    pub fn open(
        instance: &Arc<Instance>,
        report: DeviceReport,
        folder: Option<PathBuf>,
        say: fn(&Remark),
    ) -> Result<Self> {
        let file = folder.map(|folder| PipelineFile::read(&folder, &report.pipeline_key));
        let (file, problem) = match file {
            Some((file, problem)) => (Some(file), problem),
            None => {
                let what = "compiled pipelines are not kept: there is no home folder";
                (None, Some(Remark::note(what)))
            }
        };
        if let Some(problem) = problem {
            say(&problem);
        }
        let data = file.as_ref().map_or(&[][..], PipelineFile::data);
        // SAFETY: they are of this device and driver by their head, and as they were written by their sum.
        let device = unsafe { Device::open_with_pipelines(instance, report, data)? };
        Ok(Self { device, file, say })
    }

    /// Bytes of compiled pipelines that the device was opened with.
    pub fn bytes_found(&self) -> usize {
        self.file.as_ref().map_or(0, |file| file.data().len())
    }
}

impl Deref for KeptDevice {
    type Target = Arc<Device>;

    fn deref(&self) -> &Arc<Device> {
        &self.device
    }
}

impl Drop for KeptDevice {
    fn drop(&mut self) {
        let Some(file) = &self.file else { return };
        let not_kept = |why: &dyn Display| format!("compiled pipelines are not kept: {why}");
        match self.device.pipelines().and_then(|data| file.write(&data)) {
            Ok(true) => {}
            Ok(false) => {
                let why = "the driver's do not begin with the header that Vulkan defines";
                (self.say)(&Remark::detail(not_kept(&why)));
            }
            Err(problem) => (self.say)(&Remark::warning(not_kept(&problem))),
        }
    }
}
