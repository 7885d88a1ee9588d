//! The cores and the memory that nodes are packed into, and the queue of those that wait for room.
use crate::plan::NodeId;
use std::collections::{BTreeMap, BinaryHeap};

/// Cores and memory: what is free of them, and all the memory there is to hand out.
pub struct Machine {
    memory: u64,
    free_threads: usize,
    free_memory: u64,
}

/// What a node at work holds of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Threads.
    pub threads: usize,
    /// Memory [B].
    pub memory: u64,
}

impl Machine {
    /// A machine of `threads` cores and `memory` bytes, all free.
    pub fn new(threads: usize, memory: u64) -> Machine {
        Machine { memory, free_threads: threads.max(1), free_memory: memory }
    }

    /// Memory that a node is taken to need: one that asks for more than there is runs when all of it is free, so alone
    /// among those that need any. Rounded up by a sixteenth at most, so that a sweep has few different ones.
    pub fn asked(&self, memory: u64) -> u64 {
        let step = (memory.checked_ilog2().map_or(1, |n| 1 << n) / 16).max(1);
        memory.checked_next_multiple_of(step).unwrap_or(memory).min(self.memory)
    }

    /// Takes a share for a node that can use `threads`, while `others` that fit wait too.
    ///
    /// Many short queues are faster than one long: while others wait each gets one core, and the last ones share what
    /// is left over.
    pub fn take(&mut self, threads: usize, memory: u64, others: usize) -> Share {
        let fair = self.free_threads / (others + 1);
        let share = Share { threads: threads.min(fair).max(1), memory };
        self.free_threads -= share.threads;
        self.free_memory -= share.memory;
        share
    }

    /// Gives a share back.
    pub fn release(&mut self, share: Share) {
        self.free_threads += share.threads;
        self.free_memory += share.memory;
    }

    /// Whether a core is free.
    pub fn has_core(&self) -> bool {
        self.free_threads > 0
    }
}

/// Memory of this machine [B]: what the kernel has, or the smaller limit of the group of processes this one is in.
pub fn total_memory() -> u64 {
    let text = |path| std::fs::read_to_string(path).unwrap_or_default();
    let info = text("/proc/meminfo");
    let line = info.lines().find_map(|l| l.strip_prefix("MemTotal:"));
    let kib = line.and_then(|l| l.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    let limits = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let limit = limits.iter().filter_map(|path| text(path).trim().parse::<u64>().ok()).min();
    let most = kib.map_or(u64::MAX, |k| k << 10);
    limit.map_or(most, |l| l.min(most))
}

/// Nodes that wait for room: of those that fit, the one with the longest way to the end comes first.
#[derive(Default)]
pub struct Waiting {
    /// By memory asked for: it is rounded, so there are few keys.
    queues: BTreeMap<u64, BinaryHeap<Ranked>>,
    count: usize,
}

impl Waiting {
    /// Adds a node that asks for `memory`; `way` is its rank, `threads` the most it can use.
    pub fn push(&mut self, id: NodeId, way: f64, threads: usize, memory: u64) {
        self.queues.entry(memory).or_default().push(Ranked { way, id, threads });
        self.count += 1;
    }

    /// Takes out the node to run next, with its share of the machine, if one fits.
    pub fn pop(&mut self, machine: &mut Machine) -> Option<(NodeId, Share)> {
        if !machine.has_core() {
            return None;
        }
        let fitting = self.queues.range(..=machine.free_memory);
        let (memory, _) = fitting.filter_map(|(m, q)| Some((*m, q.peek()?))).max_by(|a, b| a.1.cmp(b.1))?;
        let others: usize = self.queues.range(..=machine.free_memory).map(|(_, q)| q.len()).sum::<usize>() - 1;
        let queue = self.queues.get_mut(&memory)?;
        let next = queue.pop()?;
        if queue.is_empty() {
            self.queues.remove(&memory);
        }
        self.count -= 1;
        Some((next.id, machine.take(next.threads, memory, others)))
    }

    /// Takes all out.
    pub fn drain(&mut self) -> Vec<NodeId> {
        self.count = 0;
        std::mem::take(&mut self.queues).into_values().flatten().map(|r| r.id).collect()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

struct Ranked {
    way: f64,
    id: NodeId,
    threads: usize,
}
impl PartialEq for Ranked {
    fn eq(&self, other: &Ranked) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ranked {}
impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Ranked) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ranked {
    /// Longest way first, then the plan's order.
    fn cmp(&self, other: &Ranked) -> std::cmp::Ordering {
        self.way.total_cmp(&other.way).then(other.id.cmp(&self.id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn queue(nodes: &[(NodeId, f64, usize, u64)]) -> Waiting {
        let mut waiting = Waiting::default();
        nodes.iter().for_each(|&(id, way, threads, memory)| waiting.push(id, way, threads, memory));
        waiting
    }

    #[test]
    fn the_longest_way_that_fits_comes_first() {
        let mut machine = Machine::new(3, 100);
        let mut waiting = queue(&[(0, 1.0, 1, 10), (1, 5.0, 1, 95), (2, 3.0, 1, 10), (3, 3.0, 1, 10)]);
        let order: Vec<_> = std::iter::from_fn(|| waiting.pop(&mut machine)).map(|(id, _)| id).collect();
        // 1 leaves no memory for the others.
        assert_eq!(order, [1]);
        machine.release(Share { threads: 1, memory: 95 });
        let order: Vec<_> = std::iter::from_fn(|| waiting.pop(&mut machine)).map(|(id, _)| id).collect();
        assert_eq!(order, [2, 3, 0]);
    }

    #[test]
    fn a_node_that_does_not_fit_is_passed_by() {
        let mut machine = Machine::new(2, 100);
        let mut waiting = queue(&[(0, 9.0, 1, 60), (1, 8.0, 1, 60), (2, 1.0, 1, 40)]);
        assert_eq!(waiting.pop(&mut machine).unwrap().0, 0);
        assert_eq!(waiting.pop(&mut machine).unwrap().0, 2, "a core is not idle while a node fits");
        assert!(waiting.pop(&mut machine).is_none());
        assert!(!waiting.is_empty());
    }

    #[test]
    fn threads_go_to_many_nodes_first_and_to_few_nodes_in_full() {
        let mut machine = Machine::new(4, 100);
        let mut waiting = queue(&[(0, 4.0, 4, 1), (1, 3.0, 4, 1), (2, 2.0, 4, 1)]);
        let threads: Vec<_> = std::iter::from_fn(|| waiting.pop(&mut machine)).map(|(_, s)| s.threads).collect();
        assert_eq!(threads, [1, 1, 2]);
        let mut machine = Machine::new(4, 100);
        assert_eq!(queue(&[(0, 4.0, 16, 1)]).pop(&mut machine).unwrap().1.threads, 4);
        let mut machine = Machine::new(4, 100);
        assert_eq!(queue(&[(0, 4.0, 1, 1)]).pop(&mut machine).unwrap().1.threads, 1);
    }

    #[test]
    fn memory_is_rounded_up_by_little() {
        let machine = Machine::new(1, u64::MAX);
        for memory in [0, 1, 15, 16, 33, 1000, 64 << 20, (64 << 20) + 1, u64::MAX] {
            let asked = machine.asked(memory);
            assert!(memory <= asked && asked - memory <= memory / 16, "{memory} {asked}");
        }
        let asked: std::collections::BTreeSet<u64> = (1_000_000..2_000_000).map(|m| machine.asked(m)).collect();
        assert!(asked.len() <= 33, "{}", asked.len());
        assert_eq!(Machine::new(1, 100).asked(1000), 100);
    }

    #[test]
    fn more_memory_than_there_is_means_alone() {
        let mut machine = Machine::new(2, 100);
        let asked = machine.asked(1000);
        let mut waiting = queue(&[(0, 4.0, 1, asked), (1, 3.0, 1, 1)]);
        assert_eq!(waiting.pop(&mut machine).unwrap().0, 0);
        assert!(waiting.pop(&mut machine).is_none());
    }

    #[test]
    fn this_machine_has_memory() {
        assert!((64 << 20..1 << 50).contains(&total_memory()), "{}", total_memory());
    }
}
