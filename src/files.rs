//! Files that appear whole or not at all: written beside their place, then renamed. And text as other programs write it.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Write as _};
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

/// Most bytes of a text; a longer file is none that this program reads.
const MOST_TEXT: u64 = 256 << 20;

/// The text of a file, whichever program wrote it: UTF-8, with or without a byte-order mark, or UTF-16 with one, as
/// `>` of Windows PowerShell writes it. The mark is no part of the text.
///
/// # Errors
/// [`Error::File`], naming `path`: it cannot be read, is a folder, is over 256 MiB, or is no such text.
pub fn read_text(path: &Path) -> Result<String> {
    let failed = |error: io::Error| Error::read(path, error);
    // Asked before it is opened: opening a pipe waits for its other end.
    if path.metadata().map_err(failed)?.is_dir() {
        return Err(Error::read(path, "it is a folder, not a file"));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(MOST_TEXT + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MOST_TEXT {
        return Err(Error::read(path, "it is over 256 MiB: no text that this program reads"));
    }
    text_of(bytes).map_err(|problem| Error::read(path, problem))
}

/// Like [`read_text`]; `None` if there is no such file.
///
/// # Errors
/// See [`read_text`], but for a file that is not there.
pub fn read_text_if_there(path: &Path) -> Result<Option<String>> {
    match path.metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        _ => read_text(path).map(Some),
    }
}

/// Bytes as text, by their byte-order mark; without one they are UTF-8.
fn text_of(bytes: Vec<u8>) -> std::result::Result<String, String> {
    let text = match bytes[..] {
        [0xff, 0xfe, ref rest @ ..] => utf16(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, ref rest @ ..] => utf16(rest, u16::from_be_bytes)?,
        [0xef, 0xbb, 0xbf, ..] => utf8(bytes[3..].to_vec())?,
        _ => utf8(bytes)?,
    };
    // UTF-16 without a mark is full of these, and UTF-32 with one.
    match text.find('\0') {
        None => Ok(text),
        Some(_) => Err(no_text("it has characters of number 0")),
    }
}

fn utf8(bytes: Vec<u8>) -> std::result::Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let place = error.utf8_error().valid_up_to() + 1;
        no_text(&format!("byte {place} is no UTF-8"))
    })
}

fn utf16(bytes: &[u8], unit: impl Fn([u8; 2]) -> u16) -> std::result::Result<String, String> {
    let (pairs, rest) = bytes.as_chunks();
    if !rest.is_empty() {
        return Err(no_text("it is UTF-16 and ends in the middle of a character"));
    }
    let characters = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    characters.collect::<std::result::Result<_, _>>().map_err(|error| no_text(&error.to_string()))
}

fn no_text(why: &str) -> String {
    format!("it is neither UTF-8 nor UTF-16 with a byte-order mark ({why}); save it as UTF-8")
}

/// The whole path of what is there: as [`Path::canonicalize`], but on Windows without its prefix `\\?\`, which is for no reader
/// and which few programs take.
#[cfg(feature = "cli")]
pub(crate) fn whole_path(path: &Path) -> io::Result<std::path::PathBuf> {
    if cfg!(windows) {
        path.metadata().and_then(|_| std::path::absolute(path))
    } else {
        path.canonicalize()
    }
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
    fn text_of_every_encoding_is_the_same() {
        let text = "a = \"µ 雨 🌧\"\r\n";
        let le = || text.encode_utf16().flat_map(u16::to_le_bytes);
        let be = || text.encode_utf16().flat_map(u16::to_be_bytes);
        for bytes in [
            text.as_bytes().to_vec(),
            [&[0xef, 0xbb, 0xbf], text.as_bytes()].concat(),
            [0xff, 0xfe].into_iter().chain(le()).collect(),
            [0xfe, 0xff].into_iter().chain(be()).collect(),
        ] {
            assert_eq!(text_of(bytes).as_deref(), Ok(text));
        }
        for nothing in [&b""[..], &[0xef, 0xbb, 0xbf], &[0xff, 0xfe], &[0xfe, 0xff]] {
            assert_eq!(text_of(nothing.to_vec()).as_deref(), Ok(""));
        }
        let marked = |bytes: &[u8]| [&[0xff, 0xfe], bytes].concat();
        for (bytes, why) in [
            (b"a\xe9b".to_vec(), "byte 2 is no UTF-8"),
            (marked(b"a\0b"), "ends in the middle"),
            (marked(b"a\0\x00\xd8"), "unpaired surrogate"),
            // UTF-32, and UTF-16 without a mark.
            (marked(b"\0\0a\0\0\0"), "of number 0"),
            (b"a\0b\0".to_vec(), "of number 0"),
        ] {
            let problem = text_of(bytes).expect_err(why);
            assert!(problem.contains(why) && problem.contains("save it as UTF-8"), "{problem}");
            assert!(!problem.contains('\n'), "{problem}");
        }
    }

    #[test]
    fn what_is_no_file_is_told_in_a_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let told = read_text(folder.path()).expect_err("a folder").to_string();
        assert!(told.contains("it is a folder"), "{told}");
        let path = folder.path().join("none.toml");
        assert_eq!(read_text_if_there(&path).expect("no error"), None);
        let told = read_text(&path).expect_err("nothing").to_string();
        assert!(told.contains("none.toml: No such file"), "{told}");
        let told = read_text(Path::new("/dev/zero")).expect_err("endless").to_string();
        assert!(told.contains("/dev/zero: it is over 256 MiB"), "{told}");
    }

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
