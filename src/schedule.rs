//! How a plan would pack onto more cores than there are here: a simulated schedule, from the core-seconds foretold.
//!
//! List scheduling by the longest way (Graham, SIAM J. Appl. Math. 17 (1969) 416): whenever there is room, the node that is
//! ready, fits a machine and has the longest way to the end begins there. A node keeps the cores that it asks a cluster for,
//! which share its work evenly. Any such schedule takes at most twice as long as the best one while memory is no limit.
use crate::execute::Graph;
use crate::plan::{NodeId, Plan};
use hvi_kit::view::{Axis, Figure, Series, Style};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Machines of a cluster, all alike.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// Cores of all machines together; the last one has what is left over.
    pub cores: usize,
    /// Cores of one machine.
    pub machine: usize,
    /// Memory of one machine [B].
    pub memory: u64,
}

/// What a node asks for, and how long it takes on that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Cores.
    pub cores: usize,
    /// Memory [B].
    pub memory: u64,
    /// Time on these cores [s]; 0 where the result is in the store.
    pub seconds: f64,
}

/// A simulated run.
pub struct Schedule {
    /// The cores it was packed onto.
    pub cores: usize,
    /// When the last node ends [s].
    pub makespan: f64,
    /// Core-seconds of all nodes.
    pub work: f64,
    /// The longest way through the graph [s]: no number of cores is quicker.
    pub longest_way: f64,
    /// By node, when it begins and ends [s].
    pub times: Vec<(f64, f64)>,
}

impl Schedule {
    /// The part of the cores' time that is used: 0 to 1.
    pub fn utilisation(&self) -> f64 {
        if self.makespan > 0.0 { self.work / (self.cores as f64 * self.makespan) } else { 0.0 }
    }
}

/// What each node of a plan asks of `cluster`, from the core-seconds foretold.
pub fn tasks(plan: &Plan, foretold: &[f64], most_cores: usize, cluster: Cluster) -> Vec<Task> {
    let task = |(node, seconds): (&crate::plan::Node, &f64)| {
        let needs = (node.stage.needs)(&node.params);
        let cores = needs.threads.clamp(1, most_cores.min(cluster.machine).min(cluster.cores).max(1));
        Task { cores, memory: needs.memory.min(cluster.memory), seconds: seconds / cores as f64 }
    };
    plan.nodes.iter().zip(foretold).map(task).collect()
}

/// Packs tasks onto a cluster.
pub fn simulate(mut graph: Graph, tasks: &[Task], cluster: Cluster) -> Schedule {
    let seconds: Vec<f64> = tasks.iter().map(|t| t.seconds).collect();
    let ways = graph.longest_ways(&seconds);
    let mut machines = Machines::of(cluster);
    let mut ready = Ready::default();
    graph.roots().into_iter().for_each(|id| ready.push(id, ways[id], &tasks[id]));
    let (mut now, mut times) = (0.0, vec![(0.0, 0.0); tasks.len()]);
    // By end: seconds are positive, so their bits are in their order.
    let mut running: BinaryHeap<Reverse<(u64, NodeId, usize)>> = BinaryHeap::new();
    loop {
        while let Some((id, machine)) = ready.pop(&mut machines) {
            times[id] = (now, now + tasks[id].seconds);
            running.push(Reverse((times[id].1.to_bits(), id, machine)));
        }
        let Some(&Reverse((next_end, ..))) = running.peek() else { break };
        now = f64::from_bits(next_end);
        // All that end at once make room before anything begins in it.
        while let Some(&Reverse((end, id, machine))) = running.peek()
            && end == next_end
        {
            running.pop();
            machines.free[machine].0 += tasks[id].cores;
            machines.free[machine].1 += tasks[id].memory;
            graph.settle(id, |next| ready.push(next, ways[next], &tasks[next]));
        }
    }
    let work = tasks.iter().map(|t| t.seconds * t.cores as f64).sum();
    let longest_way = ways.iter().copied().fold(0.0, f64::max);
    Schedule { cores: cluster.cores, makespan: now, work, longest_way, times }
}

/// Free cores and memory of each machine.
struct Machines {
    free: Vec<(usize, u64)>,
}

impl Machines {
    fn of(cluster: Cluster) -> Machines {
        let (whole, rest) = (cluster.cores / cluster.machine, cluster.cores % cluster.machine);
        let cores = std::iter::repeat_n(cluster.machine, whole).chain((rest > 0).then_some(rest));
        Machines { free: cores.map(|cores| (cores, cluster.memory)).collect() }
    }

    fn room(&self, cores: usize, memory: u64) -> Option<usize> {
        self.free.iter().position(|free| free.0 >= cores && free.1 >= memory)
    }
}

/// Nodes that could begin, by what they ask for: of each kind the one with the longest way first.
#[derive(Default)]
struct Ready {
    kinds: BTreeMap<(usize, u64), Ranked>,
}

/// Ways are positive, so their bits are in their order.
type Ranked = BinaryHeap<(u64, Reverse<NodeId>)>;

impl Ready {
    fn push(&mut self, id: NodeId, way: f64, task: &Task) {
        self.kinds.entry((task.cores, task.memory)).or_default().push((way.to_bits(), Reverse(id)));
    }

    /// Takes out the node to begin, and its room.
    fn pop(&mut self, machines: &mut Machines) -> Option<(NodeId, usize)> {
        let fitting = self.kinds.iter().filter_map(|(kind, queue)| Some((queue.peek()?, *kind)));
        let mut fitting: Vec<_> = fitting.collect();
        fitting.sort_unstable_by(|a, b| b.cmp(a));
        let found = fitting.into_iter().find_map(|(_, kind)| Some((kind, machines.room(kind.0, kind.1)?)));
        let (kind, machine) = found?;
        let queue = self.kinds.get_mut(&kind)?;
        let (_, Reverse(id)) = queue.pop()?;
        if queue.is_empty() {
            self.kinds.remove(&kind);
        }
        machines.free[machine].0 -= kind.0;
        machines.free[machine].1 -= kind.1;
        Some((id, machine))
    }
}

/// Slices of time in the figure.
const SLICES: usize = 400;

/// Cores at work over time, by stage, each slice of time with its mean.
pub fn figure(plan: &Plan, tasks: &[Task], schedule: &Schedule) -> Figure {
    let width = schedule.makespan / SLICES as f64;
    let mut by_stage: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (node, (task, &(from, to))) in plan.nodes.iter().zip(tasks.iter().zip(&schedule.times)) {
        let busy = by_stage.entry(node.stage.name).or_insert_with(|| vec![0.0; SLICES]);
        let first = ((from / width) as usize).min(SLICES - 1);
        for (slice, busy) in busy.iter_mut().enumerate().skip(first) {
            let begin = slice as f64 * width;
            let shared = (begin + width).min(to) - begin.max(from);
            if shared <= 0.0 {
                break;
            }
            *busy += task.cores as f64 * shared / width;
        }
    }
    by_stage.retain(|_, busy| busy.iter().any(|cores| *cores > 0.0));
    let hours = |slice: usize| (slice as f64 + 0.5) * width / 3600.0;
    let line = |(stage, busy): (&&str, &Vec<f64>)| {
        Series::new(stage, Style::Line, busy.iter().enumerate().map(|(i, cores)| (hours(i), *cores)).collect())
    };
    let all = vec![(0.0, schedule.cores as f64), (schedule.makespan / 3600.0, schedule.cores as f64)];
    let series = by_stage.iter().map(line).chain([Series::new("all there are", Style::Dashed, all)]).collect();
    Figure {
        title: format!("Cores at work of {}", schedule.cores),
        x: Axis::linear("time", "h"),
        y: Axis::linear("cores at work", ""),
        series,
        note: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alike(n: usize, seconds: f64) -> Vec<Task> {
        vec![Task { cores: 1, memory: 1, seconds }; n]
    }

    fn cluster(cores: usize, machine: usize, memory: u64) -> Cluster {
        Cluster { cores, machine, memory }
    }

    #[test]
    fn equal_tasks_fill_the_cores_in_rounds() {
        for (n, cores, makespan) in [(10, 5, 20.0), (11, 5, 30.0), (3, 5, 10.0)] {
            let found = simulate(Graph::alone(n), &alike(n, 10.0), cluster(cores, 2, 100));
            assert_eq!((found.makespan, found.work, found.longest_way), (makespan, 10.0 * n as f64, 10.0));
            assert_eq!(found.utilisation(), 10.0 * n as f64 / (cores as f64 * makespan));
        }
    }

    /// Graham's own example of longest first: 2 cores, times 3, 3, 2, 2, 2 take 7; the best order would take 6.
    #[test]
    fn the_longest_begins_first() {
        let tasks: Vec<Task> = [2.0, 3.0, 2.0, 3.0, 2.0].map(|seconds| Task { cores: 1, memory: 1, seconds }).to_vec();
        let found = simulate(Graph::alone(5), &tasks, cluster(2, 2, 100));
        assert_eq!(found.makespan, 7.0);
        assert_eq!((found.times[1].0, found.times[3].0), (0.0, 0.0));
    }

    #[test]
    fn a_node_begins_after_what_it_needs_and_never_on_two_machines() {
        // 0 -> 1 -> 3, 0 -> 2 -> 3, and 4 alone, as in the graph's own tests.
        let mut tasks = alike(5, 1.0);
        tasks[2] = Task { cores: 2, memory: 1, seconds: 2.0 };
        let found = simulate(Graph::diamond(), &tasks, cluster(3, 2, 100));
        assert_eq!(found.longest_way, 4.0);
        assert_eq!(found.makespan, 4.0);
        assert!(found.times[1].0 >= found.times[0].1 && found.times[3].0 >= found.times[2].1);
        // Machines of one core: a task of two has no place there.
        let wide = vec![Task { cores: 2, memory: 1, seconds: 1.0 }; 2];
        assert_eq!(simulate(Graph::alone(2), &wide, cluster(3, 2, 100)).makespan, 2.0);
    }

    #[test]
    fn memory_is_a_limit_of_its_own() {
        let tasks = vec![Task { cores: 1, memory: 60, seconds: 1.0 }; 4];
        assert_eq!(simulate(Graph::alone(4), &tasks, cluster(8, 4, 100)).makespan, 2.0);
    }
}
