//! Trajectories as extended XYZ, which ASE and OVITO open: a count, a line of `key=value`, a line an atom; frame after frame.
use hvi_kit::view::Trajectory;
use std::fmt::Write;

/// The file of `trajectory`: positions in angstrom, velocities in angstrom/ps, time in ps; the shortest digits that read back as
/// the same numbers.
pub fn encode(trajectory: &Trajectory) -> String {
    let mut text = String::new();
    for frame in &trajectory.frames {
        let [x, y, z] = frame.edges;
        let _ = writeln!(
            text,
            "{}\nLattice=\"{x} 0 0 0 {y} 0 0 0 {z}\" Properties=species:S:1:pos:R:3:velo:R:3 pbc=\"T T T\" Time={}",
            frame.positions.len(),
            frame.time
        );
        for (p, v) in frame.positions.iter().zip(&frame.velocities) {
            let _ = writeln!(text, "{} {} {} {} {} {} {}", trajectory.element, p[0], p[1], p[2], v[0], v[1], v[2]);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::view::Frame;

    #[test]
    fn frames_follow_each_other() {
        let frame = |time: f64| Frame {
            time,
            edges: [7.23, 7.23, 14.46],
            positions: vec![[0.0, 0.5, -1.25], [1e-7, 2.0, 3.0]],
            velocities: vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.25]],
        };
        let of = Trajectory { title: "t".into(), element: "Cu".into(), frames: vec![frame(0.0), frame(0.5)] };
        let expected = "2\n\
            Lattice=\"7.23 0 0 0 7.23 0 0 0 14.46\" Properties=species:S:1:pos:R:3:velo:R:3 pbc=\"T T T\" Time=0\n\
            Cu 0 0.5 -1.25 1 0 0\n\
            Cu 0.0000001 2 3 -1 0 0.25\n";
        assert_eq!(encode(&of), format!("{expected}{}", expected.replace("Time=0", "Time=0.5")));
    }
}
