//! Why the store could not serve, with the command that helps.
use crate::Digest;
use std::io;
use std::path::{Path, PathBuf};

/// The format that this program reads and writes.
pub(crate) const FORMAT: &str = "hvi-store/1";

/// Why the store could not serve.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum StoreError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error(
        "{path}: the store can't be written ({source}): stored results are still served; for new ones give another folder with --store"
    )]
    ReadOnly { path: PathBuf, source: io::Error },
    #[error(
        "{path}: {source}: what is stored is still whole; make room with `hvi-flow cache gc`, or give another folder with --store"
    )]
    Full { path: PathBuf, source: io::Error },
    #[error("{path}: a store is a folder, and this leads through a file: give another one with --store")]
    NoFolder { path: PathBuf },
    #[error(
        "{path}: a symbolic link, where a store has a folder of its own: link the store as a whole, or give another one with --store"
    )]
    Link { path: PathBuf },
    #[error("{url}: {why}")]
    Bucket { url: String, why: String },
    #[error("this hvi-flow was built without S3: build it with `cargo build --release --features s3`")]
    NoS3,
    #[error("object {0} was damaged: it was moved aside to `damaged/`; run again to recompute it")]
    Damaged(Digest),
    #[error(
        "{path}: this store has format {found}, this program reads {FORMAT}: use another folder with --store, or the hvi-flow that wrote it (`hvi-flow --version` there)"
    )]
    Format { path: PathBuf, found: String },
    #[error("{path}: another run uses this store: try again when it is done")]
    Busy { path: PathBuf },
}

impl StoreError {
    /// An error of reading.
    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> StoreError {
        let path = path.to_path_buf();
        move |source| StoreError::Io { path, source }
    }

    /// An error of writing: a store that can't be written at all and a full disk have words of their own.
    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> StoreError {
        let path = path.to_path_buf();
        move |source| match source.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                StoreError::ReadOnly { path, source }
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => StoreError::Full { path, source },
            _ => StoreError::Io { path, source },
        }
    }
}
