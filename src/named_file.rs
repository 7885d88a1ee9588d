//! A file that the user names. Only regular files are read: a pipe would wait for ever, a device never ends.
use std::io;
use std::path::Path;

/// The bytes of the file at `path`, which may be a link to it.
///
/// # Errors
/// Where it can't be read, or is a folder, a pipe, a socket or a device.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let meta = std::fs::metadata(path)?;
    if !meta.is_file() {
        let what = if meta.is_dir() { "it is a folder" } else { "not a regular file: a pipe, a socket or a device" };
        return Err(io::Error::other(what));
    }
    std::fs::read(path)
}

/// The text of the file at `path`.
///
/// # Errors
/// As [`read`], and where it isn't UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?).map_err(|e| io::Error::other(format!("it is no UTF-8 text: {e}")))
}
