//! Closed surfaces of triangles, read from STL files: whether they are closed, and what lies inside.
use std::collections::BTreeMap;

/// A closed surface of triangles, in the file's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    triangles: Vec<[[f64; 3]; 3]>,
    low: [f64; 3],
    high: [f64; 3],
    /// Triangles over each cell of a grid over y and z: `[row * side + column]`.
    bins: Vec<Vec<u32>>,
    side: usize,
}

impl Mesh {
    /// Reads an STL file, text or binary: it is binary where its length is that of the number of triangles it names.
    ///
    /// # Errors
    /// Why it is none: malformed (with the line or byte), without triangles, not finite, not closed (with the number of open
    /// edges), wound in more than one sense, or without volume.
    pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
        let triangles = if is_binary(bytes) { binary(bytes)? } else { text(bytes)? };
        if triangles.is_empty() {
            return Err("has no triangle".into());
        }
        if let Some(k) = triangles.iter().position(|t| t.iter().flatten().any(|x| !x.is_finite())) {
            return Err(format!("has a coordinate that is no number in triangle {}", k + 1));
        }
        closed(&triangles)?;
        let triangles: Vec<[[f64; 3]; 3]> = triangles.iter().map(|t| t.map(|p| p.map(f64::from))).collect();
        let mesh = Mesh::sorted(triangles);
        let volume = mesh.volume();
        if !(volume > 0.0) {
            return Err(format!("holds a volume of {volume:e} cubic units: its triangles must turn outwards"));
        }
        Ok(mesh)
    }

    fn sorted(triangles: Vec<[[f64; 3]; 3]>) -> Mesh {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in triangles.iter().flatten() {
            for d in 0..3 {
                (low[d], high[d]) = (low[d].min(p[d]), high[d].max(p[d]));
            }
        }
        let side = ((triangles.len() as f64).sqrt() as usize).clamp(1, 512);
        let mut mesh = Mesh { bins: vec![Vec::new(); side * side], triangles, low, high, side };
        let mut bins = std::mem::take(&mut mesh.bins);
        for (number, t) in mesh.triangles.iter().enumerate() {
            let span = |d: usize| {
                let (a, b) = (t[0][d].min(t[1][d]).min(t[2][d]), t[0][d].max(t[1][d]).max(t[2][d]));
                mesh.bin(d, a)..=mesh.bin(d, b)
            };
            for row in span(2) {
                for column in span(1) {
                    bins[row * side + column].push(number as u32);
                }
            }
        }
        mesh.bins = bins;
        mesh
    }

    /// Row or column of the bins at coordinate `x` along axis `d`.
    fn bin(&self, d: usize, x: f64) -> usize {
        let share = (x - self.low[d]) / (self.high[d] - self.low[d]);
        // A flat surface has no extent along d: the cast takes its NaN to 0.
        ((share * self.side as f64) as usize).min(self.side - 1)
    }

    /// Its box.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        (self.low, self.high)
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether it has no triangle, which none that was read has.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The volume inside, by the divergence theorem.
    pub fn volume(&self) -> f64 {
        let of = |[a, b, c]: &[[f64; 3]; 3]| {
            let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
        };
        self.triangles.iter().map(of).sum()
    }

    /// Whether `x` lies inside: the surface winds about it. The number of windings is that of the triangles that a ray along +x
    /// passes outwards less inwards; whether it passes one is decided edge by edge, for the two triangles at an edge alike, so
    /// that no ray slips through between them. Shells that overlap count as their union.
    pub fn holds(&self, x: [f64; 3]) -> bool {
        if (0..3).any(|d| x[d] < self.low[d] || x[d] > self.high[d]) {
            return false;
        }
        let over = &self.bins[self.bin(2, x[2]) * self.side + self.bin(1, x[1])];
        over.iter().map(|&t| winding(&self.triangles[t as usize], x)).sum::<i32>() != 0
    }
}

/// 1 where the ray from `x` along +x leaves through the triangle, -1 where it enters, 0 where it passes by.
fn winding(t: &[[f64; 3]; 3], x: [f64; 3]) -> i32 {
    let crossings = (0..3).filter(|&k| crosses(t[k], t[(k + 1) % 3], x)).count();
    if crossings % 2 == 0 {
        return 0;
    }
    // Normal by the right-hand rule; a triangle that is seen edge on is not crossed.
    let (a, b) = (minus(t[1], t[0]), minus(t[2], t[0]));
    let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if normal[0] == 0.0 {
        return 0;
    }
    let ahead = t[0][0] - x[0] - (normal[1] * (x[1] - t[0][1]) + normal[2] * (x[2] - t[0][2])) / normal[0];
    if ahead < 0.0 {
        0
    } else if normal[0] > 0.0 {
        1
    } else {
        -1
    }
}

/// Whether, seen along x, the edge between `a` and `b` passes the level z of `x` beyond its y; the same in both senses.
fn crosses(a: [f64; 3], b: [f64; 3], x: [f64; 3]) -> bool {
    if (a[2] > x[2]) == (b[2] > x[2]) {
        return false;
    }
    let (lower, upper) = if a[2] < b[2] { (a, b) } else { (b, a) };
    x[1] < lower[1] + (x[2] - lower[2]) / (upper[2] - lower[2]) * (upper[1] - lower[1])
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|d| a[d] - b[d])
}

/// Bytes before the first triangle of a binary file, and those of a triangle.
const HEAD: usize = 84;
const EACH: usize = 50;

fn is_binary(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|n| bytes.len() as u64 == HEAD as u64 + EACH as u64 * u64::from(n))
}

fn count(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?))
}

fn binary(bytes: &[u8]) -> Result<Vec<[[f32; 3]; 3]>, String> {
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let corner = |b: &[u8]| [number(b), number(&b[4..]), number(&b[8..])];
    // The first twelve bytes are the normal, which the corners' order says too.
    Ok(bytes[HEAD..].chunks_exact(EACH).map(|t| [corner(&t[12..]), corner(&t[24..]), corner(&t[36..])]).collect())
}

fn text(bytes: &[u8]) -> Result<Vec<[[f32; 3]; 3]>, String> {
    let neither = || match count(bytes) {
        Some(n) => format!(
            "is no STL file: it is no text that begins with `solid`, and as a binary file it names {n} triangles, which \
             take {} bytes, not {}",
            HEAD as u64 + EACH as u64 * u64::from(n),
            bytes.len()
        ),
        None => "is no STL file: it is no text that begins with `solid`, and too short for a binary one".into(),
    };
    let text = std::str::from_utf8(bytes).map_err(|_| neither())?;
    if !text.trim_start().starts_with("solid") {
        return Err(neither());
    }
    let (mut triangles, mut corners) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let wrong = |what: &str| format!("line {}: {what}", number + 1);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let xyz: Option<Vec<f32>> = words.map(|w| w.parse().ok()).collect();
                let xyz = xyz.and_then(|v| <[f32; 3]>::try_from(v).ok());
                corners.push(xyz.ok_or_else(|| wrong("expected `vertex` and three numbers"))?);
            }
            Some("endfacet") => {
                let corners = std::mem::take(&mut corners);
                let n = corners.len();
                let all = <[[f32; 3]; 3]>::try_from(corners);
                triangles.push(all.map_err(|_| wrong(&format!("a facet of {n} corners, expected 3")))?);
            }
            Some("solid" | "facet" | "outer" | "endloop" | "endsolid") | None => {}
            Some(word) => return Err(wrong(&format!("`{word}` is no word of an STL file"))),
        }
    }
    if corners.is_empty() { Ok(triangles) } else { Err("ends in the middle of a facet".into()) }
}

/// A corner by its bits, -0 as 0: corners are the same where their numbers are.
fn key(corner: [f32; 3]) -> [u32; 3] {
    corner.map(|x| (x + 0.0).to_bits())
}

/// Checks that each edge is used as often in one sense as in the other.
fn closed(triangles: &[[[f32; 3]; 3]]) -> Result<(), String> {
    let mut edges: BTreeMap<([u32; 3], [u32; 3]), [u32; 2]> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            if a < b {
                edges.entry((a, b)).or_default()[0] += 1;
            } else if b < a {
                edges.entry((b, a)).or_default()[1] += 1;
            }
        }
    }
    let open: Vec<_> = edges.iter().filter(|(_, n)| (n[0] + n[1]) % 2 == 1).collect();
    if let Some(((a, b), _)) = open.first() {
        let place = |c: &[u32; 3]| c.map(f32::from_bits);
        return Err(format!(
            "is not closed: {} of {} edges belong to one triangle only, the first from {:?} to {:?} (in the file's unit); close \
             the surface in the program that made it",
            open.len(),
            edges.len(),
            place(a),
            place(b)
        ));
    }
    let turned = edges.values().filter(|n| n[0] != n[1]).count();
    if turned > 0 {
        return Err(format!(
            "has {turned} of {} edges whose two triangles turn in opposite senses: make all of them turn outwards",
            edges.len()
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The faces of a box by its corners, outwards.
    fn faces(low: [f32; 3], high: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
        let corner = |k: usize| std::array::from_fn(|d| if k >> d & 1 == 1 { high[d] } else { low[d] });
        const QUADS: [[usize; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        QUADS.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)).collect()
    }

    fn as_text(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut text = String::from("solid part\n");
        for t in triangles {
            text += "facet normal 0 0 0\n outer loop\n";
            t.iter().for_each(|p| text += &format!("  vertex {:e} {:e} {:e}\n", p[0], p[1], p[2]));
            text += " endloop\nendfacet\n";
        }
        (text + "endsolid part\n").into_bytes()
    }

    fn as_binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        // A head that begins as a text would.
        let mut out = b"solid but binary".to_vec();
        out.resize(80, b' ');
        out.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            out.extend([0; 12]);
            t.iter().flatten().for_each(|x| out.extend(x.to_le_bytes()));
            out.extend([0; 2]);
        }
        out
    }

    #[test]
    fn text_and_binary_are_the_same() {
        let cube = faces([0.0; 3], [1.0, 2.0, 3.0]);
        let (a, b) = (Mesh::read(&as_text(&cube)).unwrap(), Mesh::read(&as_binary(&cube)).unwrap());
        assert_eq!(a, b);
        assert_eq!((a.len(), a.volume(), a.bounds()), (12, 6.0, ([0.0; 3], [1.0, 2.0, 3.0])));
    }

    /// Rays through corners, along edges and diagonals of faces: as many points of a raster that has all of them are inside as
    /// the box holds, each face counted once.
    #[test]
    fn no_ray_slips_through() {
        let mesh = Mesh::read(&as_binary(&faces([0.0; 3], [1.0; 3]))).unwrap();
        let n = 17;
        let mut inside = 0;
        for i in 0..n * n * n {
            let x = [i / (n * n), i / n % n, i % n].map(|k| (k as f64 - 4.0) / 8.0);
            let held = mesh.holds(x);
            inside += held as usize;
            let within = x.iter().all(|&x| x > 0.0 && x < 1.0);
            let outside = x.iter().any(|&x| !(0.0..=1.0).contains(&x));
            assert!((!within || held) && (!outside || !held), "{x:?}");
        }
        // 7^3 points lie within; on the surface those of one face of each pair at most.
        assert!((343..=9 * 8 * 8).contains(&inside), "{inside}");
    }

    /// Two boxes that overlap in one file are their union; a box turned inside out within another is a hole.
    #[test]
    fn windings() {
        let two = [faces([0.0; 3], [2.0; 3]), faces([1.0; 3], [3.0; 3])].concat();
        let mesh = Mesh::read(&as_text(&two)).unwrap();
        for (x, held) in [([0.5; 3], true), ([1.5; 3], true), ([2.5; 3], true), ([0.5, 0.5, 2.5], false)] {
            assert_eq!(mesh.holds(x), held, "{x:?}");
        }
        let hole = faces([1.0; 3], [2.0; 3]).into_iter().map(|[a, b, c]| [a, c, b]);
        let hollow: Vec<_> = faces([0.0; 3], [3.0; 3]).into_iter().chain(hole).collect();
        let mesh = Mesh::read(&as_binary(&hollow)).unwrap();
        assert!(!mesh.holds([1.5; 3]) && mesh.holds([0.5; 3]));
        assert!((mesh.volume() - 26.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_closed_surface_is_said() {
        let cube = faces([0.0; 3], [1.0; 3]);
        let reason = |bytes: &[u8]| Mesh::read(bytes).unwrap_err();
        assert!(reason(&as_text(&cube[1..])).contains("not closed: 3 of 18 edges"), "{}", reason(&as_text(&cube[1..])));
        let mut turned = cube.clone();
        turned[0].swap(0, 1);
        assert!(reason(&as_binary(&turned)).contains("3 of 18 edges whose two triangles turn"));
        let inward: Vec<_> = cube.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(reason(&as_binary(&inward)).contains("turn outwards"));
        assert!(reason(b"solid x\nfacet\nvertex 1 2\n").contains("line 3"));
        assert!(reason(b"solid x\nfacet\nvertex 1 2 3\nendfacet\n").contains("line 4: a facet of 1 corners"));
        assert!(reason(b"solid x\nwhat\n").contains("line 2: `what`"));
        assert!(reason(b"solid x\nendsolid x\n").contains("no triangle"));
        assert!(reason(&as_binary(&cube)[..600]).contains("names 12 triangles, which take 684 bytes, not 600"));
        assert!(reason(b"PK").contains("too short"));
        let mut nan = cube;
        nan[3][1][2] = f32::NAN;
        assert!(reason(&as_binary(&nan)).contains("triangle 4"));
    }
}
