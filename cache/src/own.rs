//! A store's own files: regular ones, in folders of its own. A store may come from someone else; no symbolic link leads a reader or
//! a writer out of it, and no pipe or device is read without end.
use rustix::fs::OFlags;
use std::fs::{File, OpenOptions, symlink_metadata};
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Folders at the top of a store.
pub(crate) const SHELVES: [&str; 8] = ["recipes", "results", "objects", "tmp", "locks", "partial", "damaged", "slurm"];

/// Options for opening a file that is a store's own.
pub(crate) fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
    options
}

/// Opens a regular file to be read.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let file = options().read(true).open(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::Error::other("not a regular file")) }
}

/// The bytes of a regular file.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open(path)?;
    let mut bytes = Vec::with_capacity(usize::try_from(file.metadata()?.len()).unwrap_or_default() + 1);
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether a symbolic link is there.
pub(crate) fn is_link(path: &Path) -> bool {
    symlink_metadata(path).is_ok_and(|there| there.file_type().is_symlink())
}
