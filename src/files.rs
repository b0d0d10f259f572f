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
    aside.as_file_mut().write_all(bytes).map_err(failed)?;
    make_readable(aside.as_file());
    // Quotas and network file systems may say only now that there is no room; and a machine that
    // stops must not leave an empty file under the name of a finished one.
    aside.as_file().sync_all().map_err(failed)?;
    aside.persist(&place).map_err(|error| failed(error.error))?;
    Ok(())
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
