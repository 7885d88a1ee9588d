//! A bucket of an S3-compatible service as a second store: the same names in it as in a store's folder.
//!
//! The endpoint, the region and the credentials come from the usual `AWS_*` environment variables. The program itself has
//! no threads that wait: the client gets one of its own with the first request.
use crate::{Digest, StoreError};
use futures_util::TryStreamExt;
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path;
use object_store::{BackoffConfig, ClientOptions, ObjectStore, ObjectStoreExt, RetryConfig};
use std::sync::OnceLock;
use std::time::Duration;
use tokio::runtime::Runtime;

/// A service that doesn't answer for so long is not there.
const CONNECT: Duration = Duration::from_secs(3);
/// The longest that one result may be under way, and how long a failing request is tried again.
const TRANSFER: Duration = Duration::from_secs(600);
const RETRY: Duration = Duration::from_secs(10);

/// `s3://BUCKET/PREFIX`.
pub struct Bucket {
    url: String,
    prefix: String,
    client: OnceLock<Result<Client, String>>,
}

struct Client {
    service: AmazonS3,
    runtime: Runtime,
}

impl Bucket {
    /// The bucket that `url` names; asks nobody yet.
    pub fn new(url: &str) -> Bucket {
        let path = url.strip_prefix("s3://").unwrap_or(url);
        let prefix = path.split_once('/').map_or("", |(_, prefix)| prefix.trim_matches('/'));
        Bucket { url: url.trim_end_matches('/').into(), prefix: prefix.into(), client: OnceLock::new() }
    }

    /// `s3://BUCKET/PREFIX`.
    pub fn url(&self) -> &str {
        &self.url
    }

    fn client(&self) -> Result<&Client, StoreError> {
        self.client.get_or_init(|| connect(&self.url)).as_ref().map_err(|why| self.failed(why))
    }

    fn failed(&self, why: impl std::fmt::Display) -> StoreError {
        let why = why.to_string();
        // Errors of the client repeat themselves over many lines; the first one says it.
        let line = why.lines().next().unwrap_or_default().chars().take(300).collect();
        StoreError::Bucket { url: self.url.clone(), why: line }
    }

    fn path(&self, shelf: &str, d: Digest) -> Path {
        let hex = d.hex();
        let (first, rest) = hex.as_str().split_at(2);
        Path::from(format!("{}/{shelf}/{first}/{rest}", self.prefix))
    }

    /// The bytes of `shelf` under this name, or none.
    ///
    /// # Errors
    /// [`StoreError::Bucket`] where the service doesn't answer, or refuses.
    pub fn read(&self, shelf: &str, d: Digest) -> Result<Option<Vec<u8>>, StoreError> {
        let Client { service, runtime } = self.client()?;
        let path = self.path(shelf, d);
        let read = runtime.block_on(async { service.get(&path).await?.bytes().await });
        match read {
            Ok(bytes) => Ok(Some(bytes.to_vec())),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(e) => Err(self.failed(e)),
        }
    }

    /// Puts bytes there.
    ///
    /// # Errors
    /// As [`Bucket::read`].
    pub fn write(&self, shelf: &str, d: Digest, bytes: Vec<u8>) -> Result<(), StoreError> {
        let Client { service, runtime } = self.client()?;
        let path = self.path(shelf, d);
        runtime.block_on(service.put(&path, bytes.into())).map(|_| ()).map_err(|e| self.failed(e))
    }

    /// Keys of all results on record there.
    ///
    /// # Errors
    /// As [`Bucket::read`].
    pub fn keys(&self) -> Result<Vec<Digest>, StoreError> {
        let Client { service, runtime } = self.client()?;
        let shelf = Path::from(format!("{}/results", self.prefix));
        let listed = service.list(Some(&shelf)).try_filter_map(async |found| Ok(key_of(&found.location)));
        runtime.block_on(listed.try_collect()).map_err(|e| self.failed(e))
    }
}

/// The digest that the last two parts of a name spell.
fn key_of(path: &Path) -> Option<Digest> {
    let parts: Vec<_> = path.parts().collect();
    let [.., first, rest] = &parts[..] else { return None };
    format!("{}{}", first.as_ref(), rest.as_ref()).parse().ok()
}

fn connect(url: &str) -> Result<Client, String> {
    let builder = AmazonS3Builder::from_env().with_url(url);
    // A service on the team's own machines often has no certificate, and its address says so.
    let endpoint = builder.get_config_value(&AmazonS3ConfigKey::Endpoint);
    let plain = endpoint.is_some_and(|at| at.starts_with("http://"));
    let options = ClientOptions::new().with_connect_timeout(CONNECT).with_timeout(TRANSFER).with_allow_http(plain);
    let backoff = BackoffConfig::default();
    let retry = RetryConfig { max_retries: 3, retry_timeout: RETRY, backoff };
    let service = builder.with_client_options(options).with_retry(retry).build().map_err(|e| e.to_string())?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build();
    Ok(Client { service, runtime: runtime.map_err(|e| e.to_string())? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_a_folder() {
        let key = Digest::of(b"x");
        let hex = key.to_string();
        for (url, begin) in [("s3://b/team/hvi/", "team/hvi/"), ("s3://b", ""), ("s3://b/", "")] {
            let path = Bucket::new(url).path("results", key);
            assert_eq!(path.as_ref(), format!("{begin}results/{}/{}", &hex[..2], &hex[2..]));
            assert_eq!(key_of(&path), Some(key));
        }
        assert_eq!(key_of(&Path::from("results/format")), None);
    }
}
