//! Parsers under random edits, the same ones each time: whatever the text, there is a plan or a mistake with words, never a
//! panic, and never a long wait.
use super::project::Project;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// Edits a text that is refused takes no longer, nor one that is planned: these have a few nodes.
const LONGEST: Duration = Duration::from_secs(20);

/// Edits of each text: `HVI_EDITS` of them, 150 unless told.
fn edits() -> usize {
    std::env::var("HVI_EDITS").ok().and_then(|n| n.parse().ok()).unwrap_or(150)
}

/// Knuth's linear congruential generator (MMIX): the same edits each time.
struct Random(u64);
impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// What breaks parsers: ends of numbers, of texts and of tables, and what is neither.
const TOKENS: [&str; 24] = [
    "\"",
    "'",
    "[",
    "]",
    "{",
    "}",
    "=",
    "@",
    "[*]",
    "[a=",
    "#",
    "\n",
    "\0",
    "\u{7f}",
    "é",
    "nan",
    "-inf",
    "1e999",
    "-0",
    "99999999999999999999",
    "0x",
    "\"\"\"",
    "km/s",
    "..",
];

/// The bytes with one to four edits.
fn edited(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let to = (at + 1 + random.below(12)).min(bytes.len());
        match random.below(6) {
            _ if bytes.is_empty() => {}
            0 => bytes[at] ^= 1 << random.below(8),
            1 => drop(bytes.drain(at..to)),
            2 => drop(bytes.splice(at..at, TOKENS[random.below(TOKENS.len())].bytes())),
            3 => drop(bytes.splice(at..to, TOKENS[random.below(TOKENS.len())].bytes())),
            4 => {
                let copy = bytes[at..to].to_vec();
                drop(bytes.splice(at..at, copy));
            }
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Does `read` with edits of `seed`, which itself it takes; how many of them it took.
#[track_caller]
fn survives(what: &str, seed: &[u8], mut read: impl FnMut(&[u8]) -> Result<(), String>) -> usize {
    assert_eq!(read(seed), Ok(()), "{what} itself");
    let (mut random, mut taken) = (Random(seed.len() as u64), 0);
    for _ in 0..edits() {
        let text = edited(seed, &mut random);
        let start = Instant::now();
        let came = catch_unwind(AssertUnwindSafe(|| read(&text)));
        let shown = String::from_utf8_lossy(&text);
        match came {
            Ok(Ok(())) => taken += 1,
            Ok(Err(why)) => assert!(why.len() > 10, "{what}: {why:?} says nothing of\n{shown}"),
            Err(_) => panic!("{what}: it panicked at\n{shown}"),
        }
        assert!(start.elapsed() < LONGEST, "{what}: {:?} for\n{shown}", start.elapsed());
    }
    taken
}

fn plan(path: &Path) -> Result<(), String> {
    let pipeline = hvi_flow::pipeline::read(path, &[]).map_err(|m| m.to_string())?;
    hvi_flow::plan::plan(&pipeline, &[]).map(drop).map_err(|m| m.to_string())
}

#[test]
fn pipelines() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let project = Project::new("");
    std::os::unix::fs::symlink(shipped.join("data"), project.path("data")).unwrap();
    let own = [super::project::MANY.replace("in 40", "in 3"), super::project::SLOW.to_string()];
    let named = ["eos.toml", "taylor.toml", "debris.toml"].map(|n| std::fs::read_to_string(shipped.join(n)).unwrap());
    for (i, text) in own.iter().chain(&named).enumerate() {
        survives(&format!("pipeline {i}"), text.as_bytes(), |text| {
            std::fs::write(project.path("study.toml"), text).unwrap();
            plan(&project.path("study.toml"))
        });
    }
}

/// A pipeline that reads a file, and the file.
fn with_file(pipeline: &str, name: &str, seed: &[u8]) -> usize {
    let project = Project::new(pipeline);
    survives(name, seed, |bytes| {
        std::fs::write(project.path(name), bytes).unwrap();
        plan(&project.path("study.toml"))
    })
}

#[test]
fn potential_files() {
    // Twenty points a table: the values are read, not used.
    let row = |scale: f64| (0..20).map(|i| format!("{:.3} ", scale * f64::from(i))).collect::<String>();
    let tables = format!("{}\n{}\n", row(-0.1), row(0.3));
    let setfl = format!("a\nb\nc\n1 Cu\n20 0.1 20 0.28 5.5\n29 63.55 3.615 fcc\n{tables}{}\n", row(0.2));
    let funcfl = format!("copper\n29 63.55 3.615 fcc\n20 0.1 20 0.28 5.5\n{tables}{}\n", row(0.2));
    for (format, seed) in [("setfl", setfl), ("funcfl", funcfl)] {
        let study = format!(
            "[step.state]\nuse = \"md\"\npotential = {{ file = \"potential.eam\", format = \"{format}\" }}\natoms = 500\n\
             temperature = \"300 K\"\nvolume_ratio = 1.0\n"
        );
        let project = Project::new(&study);
        // Whether a potential of these values binds is not asked here.
        survives(format, seed.as_bytes(), |bytes| {
            std::fs::write(project.path("potential.eam"), bytes).unwrap();
            plan(&project.path("study.toml")).or_else(|why| if bytes == seed.as_bytes() { Ok(()) } else { Err(why) })
        });
    }
}

#[test]
fn surfaces() {
    let corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
    let mut stl = String::from("solid part\n");
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        stl += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in face.map(|i| corners[i]) {
            stl += &format!("vertex {x} {y} {z}\n");
        }
        stl += "endloop\nendfacet\n";
    }
    stl += "endsolid part\n";
    let mut binary = vec![0; 80];
    binary.extend(4_u32.to_le_bytes());
    for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        binary.extend([0; 12]);
        face.iter().flat_map(|&i: &usize| corners[i]).for_each(|x| binary.extend((x as f32).to_le_bytes()));
        binary.extend([0; 2]);
    }
    let study = "[step.hit]\nuse = \"impact\"\nspace = \"full\"\nvelocity = \"2 km/s\"\nend = \"0.1 us\"\ncells = 2\n\
        projectile = { shape = \"sphere\", diameter = \"1 mm\", material = \"copper\" }\n\
        plate = { material = \"copper\", thickness = \"0.5 mm\", width = \"3 mm\" }\n\
        meshes.part = { file = \"part.stl\", unit = \"1 mm\" }\n[step.hit.bodies.part]\nmaterial = \"copper\"\n\
        shape = { mesh = { name = \"part\", at = [\"10 mm\", \"0 mm\", \"0 mm\"] } }\n";
    with_file(study, "part.stl", stl.as_bytes());
    with_file(study, "part.stl", &binary);
}

/// Tables of measurements are read when their stage runs, and equations of state by a command: the program does both.
#[test]
fn tables_and_equations_of_state() {
    let project = Project::new(
        "[step.metal]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n[step.check]\nuse = \"validate.isotherm\"\n\
         eos = \"@metal\"\ndata = \"measured.csv\"\n[step.grid]\nuse = \"eos.sesame\"\ntable = \"grid.ses\"\n",
    );
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/data/cu_isotherm_dewaele2004.csv");
    let csv = std::fs::read(data).unwrap();
    let asked = ["eos", "table", "copper-royce", "--density", "0.9", "1.2", "5", "--temperature", "200", "1000", "5"];
    let grid = project.hvi(&asked).out;
    let toml = project.hvi(&["eos", "show", "copper-royce"]).out;
    let done = |said: super::project::Said| match said.code {
        0 => Ok(()),
        1 | 2 if !said.err.contains("panicked") && !said.err.contains("broke down") => Err(said.err),
        code => panic!("code {code}: {}", said.err),
    };
    let most = (edits() / 4).max(1);
    let mut random = Random(7);
    for (name, seed, command) in [
        ("measured.csv", csv.as_slice(), &["run", "study.toml", "-q", "--keep-going"][..]),
        ("grid.ses", grid.as_bytes(), &["run", "study.toml", "-q", "--keep-going"]),
        ("grid.ses", grid.as_bytes(), &["eos", "curve", "grid.ses", "isotherm", "--up-to", "10 GPa"]),
        ("eos.toml", toml.as_bytes(), &["eos", "show", "eos.toml"]),
    ] {
        project.write("measured.csv", &String::from_utf8_lossy(&csv));
        project.write("grid.ses", &grid);
        for round in 0..most {
            let text = if round == 0 { seed.to_vec() } else { edited(seed, &mut random) };
            std::fs::write(project.path(name), &text).unwrap();
            let came = catch_unwind(AssertUnwindSafe(|| done(project.hvi(command))));
            let shown = String::from_utf8_lossy(&text);
            match came.unwrap_or_else(|_| panic!("{name} with {command:?}\n{shown}")) {
                Ok(()) => {}
                Err(why) => assert!(round > 0 && why.len() > 10, "{name}: {why:?}\n{shown}"),
            }
        }
    }
}
