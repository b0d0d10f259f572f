//! Files that appear whole or not at all: written beside their place, then renamed.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::{Error, Result};

/// Held while a file is on its way.
static WRITING: Mutex<()> = Mutex::new(());

/// Waits for the file that is being written, if one is. Whoever ends the program at once holds this,
/// so that nothing is left beside a file's place.
pub(crate) fn between_files() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes `bytes` beside `path` and renames them into place: on any failure, a full disk among them,
/// what was there before is there still, and nothing else. A pipe or a device (`/dev/stdout`,
/// `/dev/null`) is written to, never replaced.
///
/// # Errors
/// [`Error::File`], naming `path`.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |error: io::Error| Error::write(path, error);
    let _writing = between_files();
    if path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        let opened = OpenOptions::new().write(true).open(path);
        return opened.and_then(|mut file| file.write_all(bytes)).map_err(failed);
    }
    // A link stays, and leads to the new file.
    let place = path.canonicalize().unwrap_or_else(|_| path.into());
    let folder = match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    // It may go away at any moment from here on: then a call below finds nothing.
    let failed = |error: io::Error| match folder.is_dir() {
        true => failed(error),
        false => Error::write(path, format!("there is no folder {}", folder.display())),
    };
    // The wrapper's errors name the temporary file, of which the user knows nothing.
    let mut aside =
        tempfile::NamedTempFile::new_in(folder).map_err(|error| failed(error.kind().into()))?;
    match fill(aside.as_file_mut(), bytes) {
        Ok(()) => aside.persist(&place).map(drop).map_err(|error| (error.error, error.file)),
        Err(error) => Err((error, aside)),
    }
    .map_err(|(error, aside)| {
        remove_where_it_is(aside.as_file());
        failed(error)
    })
}

fn fill(file: &mut File, bytes: &[u8]) -> io::Result<()> {
    file.write_all(bytes)?;
    make_readable(file);
    // Quotas and network file systems may say only now that there is no room; and a machine that
    // stops must not leave an empty file under the name of a finished one.
    file.sync_all()
}

/// Removes a file by what its descriptor knows of its place: its folder may have been moved since it was
/// made, and then its name leads nowhere. Where no system tells, it stays in that folder.
fn remove_where_it_is(file: &File) {
    #[cfg(target_os = "linux")]
    {
        use std::os::fd::AsRawFd;
        let place = std::fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd()));
        // Best effort: the error that led here is the one to tell.
        let _ = place.and_then(std::fs::remove_file);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = file;
}

/// A temporary file is private to its owner; a result is not.
fn make_readable(file: &File) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Best effort: a file system without modes keeps what it has.
        let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
    }
    #[cfg(not(unix))]
    let _ = file;
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_file_whose_folder_was_moved_is_removed() {
        let outer = tempfile::tempdir().expect("a folder");
        let (folder, away) = (outer.path().join("folder"), outer.path().join("away"));
        std::fs::create_dir(&folder).expect("a folder");
        let aside = tempfile::NamedTempFile::new_in(&folder).expect("a file");
        std::fs::rename(&folder, &away).expect("it is moved away");
        assert_eq!(away.read_dir().expect("a folder").count(), 1);
        remove_where_it_is(aside.as_file());
        assert_eq!(away.read_dir().expect("a folder").count(), 0);
    }
}
