//! What a running stage may know of the world outside.
use serde::{Serialize, de::DeserializeOwned};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set once, by Ctrl-C; polled by stages.
#[derive(Default)]
pub struct Cancel(AtomicBool);
impl Cancel {
    /// Asks every running stage to stop at its next tick.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
    /// Whether a stop was asked for.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The stage was asked to stop.
#[derive(Debug, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Whoever runs a stage: hears how far it has come, and keeps what it needs to go on after a stop.
pub trait Host: Sync {
    /// `done` of `of` parts of the work are done (any unit, `of > 0`); `doing` says what comes now.
    fn advance(&self, _done: f64, _of: f64, _doing: &str) {}
    /// Whether it is time to keep something: by the host's clock, so that keeping costs little.
    fn due(&self) -> bool {
        false
    }
    /// Keeps `bytes` until the stage has its result, in place of what was kept before. A failure costs only time.
    fn keep(&self, _bytes: &[u8]) {}
    /// What an earlier attempt at the very same computation kept last, if it is whole.
    fn kept(&self) -> Option<Vec<u8>> {
        None
    }
}
impl Host for () {}

/// No clock, no file system, no environment, no global random numbers: seeds are parameters.
pub struct Ctx<'a> {
    /// Who runs the stage.
    pub host: &'a dyn Host,
    /// Whether to stop.
    pub cancel: &'a Cancel,
    /// Threads the stage may use; the answer has the same bits for any number.
    pub threads: usize,
}

static NEVER: Cancel = Cancel(AtomicBool::new(false));

impl Ctx<'static> {
    /// No listener, never cancelled, one thread: for tests and one-off calls.
    pub fn quiet() -> Ctx<'static> {
        Ctx { host: &(), cancel: &NEVER, threads: 1 }
    }
}

impl Ctx<'_> {
    /// Call once per step: reports progress, and stops the stage when asked to.
    ///
    /// # Errors
    /// [`Cancelled`], to be passed on.
    pub fn tick(&self, done: f64, of: f64, doing: &str) -> Result<(), Cancelled> {
        if self.cancel.is_set() {
            return Err(Cancelled);
        }
        self.host.advance(done, of, doing);
        Ok(())
    }

    /// Keeps what the stage needs to go on from here, when it is due or a stop was asked for. Call it before
    /// [`Ctx::tick`], at a place to which [`Ctx::resume`] can return with the same bits as a straight run.
    pub fn save<T: Serialize>(&self, state: impl FnOnce() -> T) {
        if (self.cancel.is_set() || self.host.due())
            && let Ok(bytes) = postcard::to_stdvec(&state())
        {
            self.host.keep(&bytes);
        }
    }

    /// What an earlier attempt at the same computation saved, if there was one.
    pub fn resume<T: DeserializeOwned>(&self) -> Option<T> {
        postcard::from_bytes(&self.host.kept()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    struct Shelf(Mutex<Option<Vec<u8>>>);
    impl Host for Shelf {
        fn due(&self) -> bool {
            true
        }
        fn keep(&self, bytes: &[u8]) {
            *self.0.lock().unwrap() = Some(bytes.to_vec());
        }
        fn kept(&self) -> Option<Vec<u8>> {
            self.0.lock().unwrap().clone()
        }
    }

    #[test]
    fn what_was_saved_comes_back() {
        let shelf = Shelf(Mutex::new(None));
        let ctx = Ctx { host: &shelf, ..Ctx::quiet() };
        assert_eq!(ctx.resume::<(u64, f64)>(), None);
        ctx.save(|| (3_u64, 0.1));
        assert_eq!(ctx.resume::<(u64, f64)>(), Some((3, 0.1)));
    }

    /// Without a host that asks for it, nothing is encoded.
    #[test]
    fn saving_costs_nothing_when_it_is_not_due() {
        Ctx::quiet().save(|| -> u64 { panic!("not due") });
    }
}
