//! Locks that save double work: kernel file locks, which die with the process that holds them.
//!
//! Correctness never rests on them: publishing is atomic and idempotent.
use crate::own;
use std::fs::{File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A key that this process computes, until it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    _file: File,
}

impl Drop for Claim {
    fn drop(&mut self) {
        // Before the lock is let go: whoever waits for it finds that its file is gone, and takes a new one.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The lock at `path`, or none where another process (or thread) has it.
pub(crate) fn claim(path: &Path) -> io::Result<Option<Claim>> {
    loop {
        let file = own::options().write(true).create(true).truncate(false).open(path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(e)) => return Err(e),
        }
        let mine = file.metadata()?;
        match std::fs::symlink_metadata(path) {
            Ok(there) if (there.dev(), there.ino()) == (mine.dev(), mine.ino()) => {
                return Ok(Some(Claim { path: path.into(), _file: file }));
            }
            // Its last holder removed it between our opening and locking it.
            Ok(_) => {}
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(e),
        }
    }
}

/// Whether somebody holds the lock at `path`; changes nothing.
pub(crate) fn is_held(path: &Path) -> bool {
    own::open(path).is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// A store in use: nothing in it is removed until this is dropped.
#[derive(Debug)]
pub struct InUse {
    _file: File,
}

/// Shared, for runs; exclusive, for what removes. None where somebody else's use forbids it.
pub(crate) fn hold(path: &Path, exclusive: bool) -> io::Result<Option<InUse>> {
    let file = own::options().write(true).create(true).truncate(false).open(path)?;
    match if exclusive { file.try_lock() } else { file.try_lock_shared() } {
        Ok(()) => Ok(Some(InUse { _file: file })),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(e)) => Err(e),
    }
}
