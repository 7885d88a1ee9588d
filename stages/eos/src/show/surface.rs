//! The surface of pressure over volume and energy, coloured by temperature, as Fig 4 of the paper draws it.
use crate::curves::Surface;
use hvi_kit::view::Picture;

const WIDTH: usize = 760;
const HEIGHT: usize = 560;
/// Highest temperature of the colours [K].
const HOTTEST: f64 = 9000.0;
/// Colours from cold to hot, evenly spaced.
const COLOURS: [[f64; 3]; 5] =
    [[30.0, 60.0, 150.0], [40.0, 160.0, 200.0], [120.0, 200.0, 90.0], [245.0, 200.0, 60.0], [190.0, 30.0, 30.0]];

/// Seen obliquely from above: volume runs to the right and forwards, energy to the right and backwards, pressure up. Patches are
/// painted from the back to the front; dark lines are the isochores and every twelfth line of equal energy.
pub(super) fn picture(s: &Surface, source: &str) -> Picture {
    let mut rgb = vec![255u8; 3 * WIDTH * HEIGHT];
    let all = s.values.iter().flatten().map(|x| x[0]);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let (n, m) = (s.volumes.len() - 1, s.energies.len() - 1);
    let place = |i: usize, j: usize| {
        let (x, y) = (i as f64 / n as f64, j as f64 / m as f64);
        let up = (s.values[j][i][0] - low) / (high - low);
        let across = 0.06 + 0.44 * x + 0.44 * y;
        let down = 0.93 - 0.2 * (1.0 - x) - 0.2 * y - 0.5 * up;
        [across * WIDTH as f64, down * HEIGHT as f64]
    };
    // The back is where volume is small and energy large. Below the cold curve there is no matter.
    let mut patches: Vec<(usize, usize)> = (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).collect();
    patches.retain(|&(i, j)| s.values[j][i][1] > 0.0);
    patches.sort_by_key(|&(i, j)| std::cmp::Reverse(n - i + j));
    for (i, j) in patches {
        let corners = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
        let shade = if i % 12 == 0 || j % 12 == 0 { 0.75 } else { 1.0 };
        fill(&mut rgb, &corners, colour(s.values[j][i][1]).map(|c| (c * shade) as u8));
    }
    let [v0, v1] = [s.volumes[0], s.volumes[n]].map(|v| v * 1e3);
    let [e0, e1] = [s.energies[0], s.energies[m]].map(|e| e / 1e6);
    let legend = (0..5).map(|k| (COLOURS[k].map(|c| c as u8), format!("{:.0} K", HOTTEST * k as f64 / 4.0))).collect();
    Picture {
        title: "Pressure over volume and energy".into(),
        width: WIDTH as u32,
        height: HEIGHT as u32,
        rgb,
        legend,
        note: format!(
            "Fig 4 of the paper. Height: pressure, {:.0} to {:.0} GPa; to the right and forwards: volume from {v0:.4} to {v1:.4} cm3/g; \
             to the right and backwards: energy from {e0:.2} to {e1:.2} MJ/kg. {source}.",
            low / 1e9,
            high / 1e9
        ),
    }
}

fn colour(t: f64) -> [f64; 3] {
    let x = (t / HOTTEST).clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let k = (x as usize).min(COLOURS.len() - 2);
    std::array::from_fn(|c| COLOURS[k][c] + (x - k as f64) * (COLOURS[k + 1][c] - COLOURS[k][c]))
}

/// Fills a convex quadrilateral, row by row of pixels.
fn fill(rgb: &mut [u8], corners: &[[f64; 2]; 4], colour: [u8; 3]) {
    let rows = corners.iter().map(|c| c[1]);
    let (top, bottom) = (rows.clone().fold(f64::INFINITY, f64::min), rows.fold(f64::NEG_INFINITY, f64::max));
    for row in top.floor().max(0.0) as usize..=(bottom.ceil().max(0.0) as usize).min(HEIGHT - 1) {
        let y = (row as f64 + 0.5).clamp(top, bottom);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            if (a[1] - y) * (b[1] - y) <= 0.0 {
                let x = if a[1] == b[1] { a[0] } else { a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) };
                (left, right) = (left.min(x), right.max(x));
            }
        }
        if left <= right {
            for column in left.floor().max(0.0) as usize..=(right.ceil().max(0.0) as usize).min(WIDTH - 1) {
                rgb[3 * (row * WIDTH + column)..][..3].copy_from_slice(&colour);
            }
        }
    }
}
