//! CPU time of nodes that run side by side in one process, whatever threads and programs they start.
//!
//! The kernel counts a thread's time, and the time of the whole process with the programs it has waited for. A node on one
//! thread took what its thread took. Nodes that may start threads or programs of their own share what the process took
//! beyond that, by the threads they were given: with one such node at work, which is the rule, all of it is the node's.
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Who is at work, and what each has taken so far.
#[derive(Default)]
pub struct Clock {
    ledger: Mutex<Ledger>,
}

#[derive(Default)]
struct Ledger {
    /// Time of the process when it was last shared out [s].
    shared_at: f64,
    /// Nodes on one thread, by the thread's number: its time when it was last looked at [s].
    narrow: BTreeMap<u64, f64>,
    /// The others, by the number of the thread that began them.
    wide: BTreeMap<u64, Wide>,
}

struct Wide {
    threads: f64,
    /// What it took so far [s].
    took: f64,
}

/// A node at work, on the thread that began it, until this is dropped.
pub struct Watch<'a> {
    clock: &'a Clock,
    thread: u64,
    began: f64,
    is_wide: bool,
}

impl Clock {
    /// Begins a node on this thread, which may use `threads`, or a program outside.
    pub fn begin(&self, threads: usize, program: bool) -> Watch<'_> {
        let (thread, began, is_wide) = (this_thread(), thread_seconds("thread-self"), threads > 1 || program);
        let mut ledger = self.ledger();
        if is_wide {
            ledger.share_out();
            ledger.wide.insert(thread, Wide { threads: threads as f64, took: 0.0 });
        } else {
            ledger.narrow.insert(thread, began);
        }
        Watch { clock: self, thread, began, is_wide }
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger> {
        self.ledger.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Ledger {
    /// Shares out what the process took since the last time among the nodes that may have several threads.
    fn share_out(&mut self) {
        let now = process_seconds();
        // Nothing is shared out where no such node was at work: the time begins to count now.
        let mut took = now - std::mem::replace(&mut self.shared_at, now);
        for (thread, seen) in &mut self.narrow {
            let now = thread_seconds(&format!("self/task/{thread}")).max(*seen);
            took -= now - std::mem::replace(seen, now);
        }
        let threads: f64 = self.wide.values().map(|w| w.threads).sum();
        self.wide.values_mut().for_each(|w| w.took += took.max(0.0) * w.threads / threads);
    }
}

impl Watch<'_> {
    /// CPU time the node took so far [s].
    pub fn seconds(&self) -> f64 {
        if !self.is_wide {
            return thread_seconds("thread-self") - self.began;
        }
        let mut ledger = self.clock.ledger();
        ledger.share_out();
        ledger.wide.get(&self.thread).map_or(0.0, |w| w.took)
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        let mut ledger = self.clock.ledger();
        if !ledger.wide.is_empty() {
            // Before this thread's time can no longer be asked for.
            ledger.share_out();
        }
        ledger.narrow.remove(&self.thread);
        ledger.wide.remove(&self.thread);
    }
}

/// The kernel's number of this thread; 0 where it doesn't say.
fn this_thread() -> u64 {
    let link = std::fs::read_link("/proc/thread-self").unwrap_or_default();
    link.file_name().and_then(|name| name.to_str()?.parse().ok()).unwrap_or(0)
}

/// CPU time of a thread [s]; 0 where the kernel doesn't say.
fn thread_seconds(thread: &str) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{thread}/schedstat")).unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(0.0, |ns| ns * 1e-9)
}

/// CPU time of this process and of the programs it has waited for [s], in steps of 10 ms.
fn process_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field is a name in brackets, which may hold spaces: utime is the 12th after it.
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(4);
    fields.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() * 0.01
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Until this thread has taken so many seconds.
    fn work(seconds: f64) {
        let begin = thread_seconds("thread-self");
        let mut x = 1_u64;
        while thread_seconds("thread-self") - begin < seconds {
            (0..100_000).for_each(|_| x = std::hint::black_box(x.wrapping_mul(3)));
        }
    }

    #[test]
    fn threads_that_a_node_starts_count() {
        let clock = Clock::default();
        let wide = clock.begin(2, false);
        std::thread::scope(|scope| {
            let narrow = scope.spawn(|| {
                let watch = clock.begin(1, false);
                work(0.1);
                watch.seconds()
            });
            scope.spawn(|| work(0.2));
            work(0.2);
            // The kernel brings a thread's time up to date at each tick, of 10 ms at most.
            assert!((0.09..0.15).contains(&narrow.join().unwrap()));
        });
        // Other tests in this process count too, so there is no upper bound; ticks and their rounding: 10 ms each.
        assert!(wide.seconds() > 0.36, "{}", wide.seconds());
        drop(wide);
        assert!(clock.ledger().wide.is_empty() && clock.ledger().narrow.is_empty());
    }

    #[test]
    fn programs_that_a_node_waited_for_count() {
        let clock = Clock::default();
        let watch = clock.begin(1, true);
        let spin = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        assert!(std::process::Command::new("sh").args(["-c", spin]).status().unwrap().success());
        assert!(watch.seconds() > 0.02, "{}", watch.seconds());
    }
}
