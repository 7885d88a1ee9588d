//! On the grid: velocities from momenta, and the end-of-step velocities from forces; mirror planes.
use crate::grid::{Grid, Node};

/// Velocities `v_i = p_i / m_i`; nodes lighter than `cut` [kg] stand still.
pub fn velocities<const D: usize>(grid: &mut Grid<D>, cut: f64) {
    fold(grid, |node| &mut node.velocity, true);
    for node in &mut grid.nodes {
        let per_mass = if node.mass > cut { 1.0 / node.mass } else { 0.0 };
        node.velocity.iter_mut().for_each(|v| *v *= per_mass);
    }
}

/// Means `next_i / m_i` of what particles gave; nodes lighter than `cut` [kg] keep none.
pub fn means<const D: usize>(grid: &mut Grid<D>, cut: f64) {
    fold(grid, |node| &mut node.next, false);
    for node in &mut grid.nodes {
        let per_mass = if node.mass > cut { 1.0 / node.mass } else { 0.0 };
        node.next.iter_mut().for_each(|v| *v *= per_mass);
    }
}

/// End-of-step velocities `v_i + dt f_i / m_i`; nodes lighter than `cut` [kg] stand still.
pub fn accelerate<const D: usize>(grid: &mut Grid<D>, cut: f64, dt: f64) {
    fold(grid, |node| &mut node.next, false);
    for node in &mut grid.nodes {
        let factor = if node.mass > cut { dt / node.mass } else { 0.0 };
        for d in 0..D {
            node.next[d] = node.velocity[d] + factor * node.next[d];
        }
    }
}

/// Adds what the mirrored half of the scene gives the nodes near each mirror plane, and copies the sum behind it with the
/// normal component turned round. `with_mass` treats the mass alike.
fn fold<const D: usize>(grid: &mut Grid<D>, field: impl Fn(&mut Node<D>) -> &mut [f64; D], with_mass: bool) {
    for d in 0..D {
        for &n in &grid.on_plane[d] {
            let node = &mut grid.nodes[n as usize];
            if with_mass {
                node.mass *= 2.0;
            }
            let v = field(node);
            v.iter_mut().for_each(|x| *x *= 2.0);
            v[d] = 0.0;
        }
        for &(front, behind) in &grid.images[d] {
            let (mass, image) = {
                let node = &mut grid.nodes[behind as usize];
                (node.mass, *field(node))
            };
            let node = &mut grid.nodes[front as usize];
            if with_mass {
                node.mass += mass;
            }
            let v = field(node);
            for c in 0..D {
                v[c] += if c == d { -image[c] } else { image[c] };
            }
        }
    }
    for d in 0..D {
        for &(front, behind) in &grid.images[d] {
            let (mass, mut v) = {
                let node = &mut grid.nodes[front as usize];
                (node.mass, *field(node))
            };
            v[d] = -v[d];
            let node = &mut grid.nodes[behind as usize];
            if with_mass {
                node.mass = mass;
            }
            *field(node) = v;
        }
    }
}

/// Copies a field behind each mirror plane, the normal component turned round.
pub fn reflect<const D: usize>(grid: &mut Grid<D>, field: impl Fn(&mut Node<D>) -> &mut [f64; D]) {
    for d in 0..D {
        for &(front, behind) in &grid.images[d] {
            let mut v = *field(&mut grid.nodes[front as usize]);
            v[d] = -v[d];
            *field(&mut grid.nodes[behind as usize]) = v;
        }
    }
}
