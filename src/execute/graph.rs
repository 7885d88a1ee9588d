//! Who needs whom, and how many needs of each node are still open.
use crate::plan::{NodeId, Plan};

/// The needs of a plan's nodes, turned round.
pub struct Graph {
    /// Number of different needs that are not settled yet, by node.
    open: Vec<u32>,
    /// Where a node's dependents begin in `dependents`; one entry more than nodes.
    first: Vec<u32>,
    /// Nodes that need a node, node after node.
    dependents: Vec<u32>,
}

impl Graph {
    /// The graph of `plan`; a node that names a need twice counts once.
    pub fn of(plan: &Plan) -> Graph {
        let n = plan.nodes.len();
        let (mut open, mut first) = (vec![0; n], vec![0; n + 1]);
        each_edge(plan, |need, node| {
            open[node] += 1;
            first[need + 1] += 1;
        });
        for id in 0..n {
            first[id + 1] += first[id];
        }
        let mut next = first.clone();
        let mut dependents = vec![0; first[n] as usize];
        each_edge(plan, |need, node| {
            dependents[next[need] as usize] = node as u32;
            next[need] += 1;
        });
        Graph { open, first, dependents }
    }

    /// Nodes without needs, in the plan's order.
    pub fn roots(&self) -> Vec<NodeId> {
        (0..self.open.len()).filter(|&id| self.open[id] == 0).collect()
    }

    /// Nodes that need `id`.
    pub fn dependents(&self, id: NodeId) -> impl Iterator<Item = NodeId> {
        let range = self.first[id] as usize..self.first[id + 1] as usize;
        self.dependents[range].iter().map(|&d| d as NodeId)
    }

    /// Counts `id` as settled; calls `free` with each node that has no open need left.
    pub fn settle(&mut self, id: NodeId, mut free: impl FnMut(NodeId)) {
        for i in self.first[id] as usize..self.first[id + 1] as usize {
            let node = self.dependents[i] as NodeId;
            self.open[node] -= 1;
            if self.open[node] == 0 {
                free(node);
            }
        }
    }

    /// By node, the sum of `weight` along the heaviest way from it to an end of the graph, its own included.
    pub fn longest_ways(&self, weight: &[f64]) -> Vec<f64> {
        let mut way = weight.to_vec();
        for id in (0..way.len()).rev() {
            way[id] += self.dependents(id).map(|next| way[next]).fold(0.0, f64::max);
        }
        way
    }
}

fn each_edge(plan: &Plan, mut edge: impl FnMut(NodeId, NodeId)) {
    let mut last_seen_by = vec![usize::MAX; plan.nodes.len()];
    for node in 0..plan.nodes.len() {
        for need in plan.needs(node) {
            if std::mem::replace(&mut last_seen_by[need], node) != node {
                edge(need, node);
            }
        }
    }
}

#[cfg(test)]
impl Graph {
    /// 0 -> 1 -> 3, 0 -> 2 -> 3, and 4 alone.
    pub fn diamond() -> Graph {
        Graph { open: vec![0, 1, 1, 2, 0], first: vec![0, 2, 3, 4, 4, 4], dependents: vec![1, 2, 3, 3] }
    }

    /// `n` nodes that need nothing.
    pub fn alone(n: usize) -> Graph {
        Graph { open: vec![0; n], first: vec![0; n + 1], dependents: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_free_when_its_last_need_is_settled() {
        let mut graph = Graph::diamond();
        assert_eq!(graph.roots(), [0, 4]);
        let mut freed = Vec::new();
        for id in [0, 1, 2] {
            graph.settle(id, |node| freed.push((id, node)));
        }
        assert_eq!(freed, [(0, 1), (0, 2), (2, 3)]);
    }

    #[test]
    fn ways_follow_the_heaviest_branch() {
        assert_eq!(Graph::diamond().longest_ways(&[1.0, 10.0, 2.0, 3.0, 7.0]), [14.0, 13.0, 5.0, 3.0, 7.0]);
    }
}
