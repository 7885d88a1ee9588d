//! What reads bytes of others, one function each: whatever the bytes, it comes to an end without a panic. For libFuzzer, and for
//! the tests, which read the corpus.
#![allow(dead_code, reason = "each target uses one of them")]
use hvi_cache::{Digest, Limits, Recipe, Second, Store};
use hvi_eos::definition::Definition;
use hvi_eos::model::sesame;
use hvi_eos::{Eos, Tabulated};
use hvi_impact::mesh::Mesh;
use hvi_md::potential::file::{Format, Tabulated as Potential};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

type Reader = fn(&[u8]);

/// All of them, by the names of their corpora.
pub const ALL: [(&str, Reader); 7] = [
    ("pipeline", pipeline),
    ("potential", potential),
    ("eos", eos),
    ("sesame", sesame),
    ("stl", stl),
    ("store", store),
    ("artifact", artifact),
];

/// A folder of this process: in the tests' own place, or in that for temporary files, which is the fuzzer's to tidy up.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let place = option_env!("CARGO_TARGET_TMPDIR").map_or_else(std::env::temp_dir, PathBuf::from);
        let folder = place.join(format!("readers-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let data = [here.join("pipelines/data"), here.join("../pipelines/data")].into_iter().find(|path| path.exists());
        let _ = std::os::unix::fs::symlink(data.unwrap(), folder.join("data"));
        folder
    })
}

/// Removes what the readers have written.
pub fn tidy() {
    fs::remove_dir_all(folder()).unwrap();
}

/// A pipeline file, read and planned.
pub fn pipeline(bytes: &[u8]) {
    let path = folder().join("study.toml");
    fs::write(&path, bytes).unwrap();
    let planned = hvi_flow::pipeline::read(&path, &[]).and_then(|pipeline| hvi_flow::plan::plan(&pipeline, &[]));
    if let Err(mistake) = planned {
        assert!(mistake.to_string().len() > 10);
    }
}

/// A file of an embedded-atom potential: the first byte says which format.
pub fn potential(bytes: &[u8]) {
    let Some((&first, text)) = bytes.split_first() else { return };
    let format = match first {
        b'f' => Format::Funcfl,
        b's' => Format::Setfl,
        _ => Format::FinnisSinclair,
    };
    let Ok(potential) = Potential::read(&String::from_utf8_lossy(text), format, None) else { return };
    for share in [0.0, 0.3, 0.999, 1.0, 1.5] {
        potential.pair(share * potential.cutoff);
        potential.density(share * potential.cutoff);
        potential.embedding.at(share * potential.embedding.end());
    }
}

/// A few states of an equation of state: no panic; whether they are sound is what the stages check.
fn ask(eos: &Eos) {
    let v0 = eos.reference_volume();
    for compression in [0.4, 0.9, 1.0, 1.3, 50.0] {
        for t in [1.0, 300.0, 5000.0] {
            let energy = eos.energy_at(compression * v0, t);
            eos.point(compression * v0, energy);
        }
    }
}

/// A file that describes an equation of state: JSON where it begins with a brace, else TOML.
pub fn eos(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let read = if text.starts_with('{') {
        serde_json::from_str::<Definition>(&text).ok()
    } else {
        toml::from_str::<Definition>(&text).ok()
    };
    let Some(definition) = read else { return };
    match definition.make() {
        Ok(made) => ask(&made.eos),
        Err(why) => assert!(!why.key.is_empty() && why.why.len() > 5, "{why:?}"),
    }
}

/// A table like SESAME's.
pub fn sesame(bytes: &[u8]) {
    let Ok(table) = sesame::read(&String::from_utf8_lossy(bytes), 300.0) else { return };
    if let Ok(table) = Tabulated::new(table) {
        ask(&Eos::Table(table));
    }
}

/// A closed surface.
pub fn stl(bytes: &[u8]) {
    let Ok(mesh) = Mesh::read(bytes) else { return };
    let (low, high) = mesh.bounds();
    for share in [0.0, 0.31, 0.5, 1.0] {
        mesh.holds(std::array::from_fn(|d| low[d] + share * (high[d] - low[d])));
    }
}

/// A store of someone else: parts between zero bytes, the first byte of each says which file of the store it is. Records get the seal
/// that fits and objects the name, which anyone can make.
pub fn store(bytes: &[u8]) {
    let root = folder().join("store");
    let _ = fs::remove_dir_all(&root);
    let parts = || bytes.split(|&b| b == 0).filter_map(|part| part.split_first());
    let recipe =
        parts().find(|(kind, _)| **kind == b'q').and_then(|(_, body)| serde_json::from_slice::<Recipe>(body).ok());
    let key = recipe.as_ref().map_or(Digest::of(b"a key"), Recipe::key);
    let put = |shelf: &str, name: Digest, body: &[u8]| {
        let hex = name.hex();
        let folder = root.join(shelf).join(&hex.as_str()[..2]);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join(&hex.as_str()[2..]), body).unwrap();
    };
    fs::create_dir_all(root.join("partial")).unwrap();
    for (kind, body) in parts() {
        match kind {
            b'q' => put("recipes", key, body),
            b'o' => put("objects", Digest::of(body), body),
            b'r' => put("results", key, &[seal(key, body).as_bytes(), b"\n", body].concat()),
            b'p' => fs::write(root.join("partial").join(key.hex().as_str()), body).unwrap(),
            b'f' => fs::write(root.join("format"), body).unwrap(),
            _ => fs::write(root.join("index"), index(key, body)).unwrap(),
        }
    }
    use_it(&root, key);
}

fn seal(key: Digest, body: &[u8]) -> String {
    Digest::of_all(&[key.hex().as_str().as_bytes(), b"\n", body]).hex().as_str().into()
}

/// An index: its head, and entries of the bytes, of which the first one is of `key` and proves itself.
fn index(key: Digest, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 128];
    bytes[..11].copy_from_slice(b"hvi-index/1");
    let mut entry = [0; 120];
    for (to, from) in entry.iter_mut().skip(32).zip(body) {
        *to = *from;
    }
    entry[..32].copy_from_slice(key.bytes());
    bytes.extend(entry);
    bytes.extend(&Digest::of(&entry).bytes()[..8]);
    bytes.extend(body.get(88..).unwrap_or_default());
    bytes
}

/// Everything that is done with a store.
fn use_it(root: &Path, key: Digest) {
    let Ok(store) = Store::open(root) else { return };
    store.find(key);
    store.lookup(key);
    store.recipe(key).map(|recipe| recipe.changes_since(&recipe));
    store.partial(key);
    store.latest("eos/1", 10);
    store.records();
    let other = folder().join("other");
    let _ = fs::remove_dir_all(&other);
    let (Ok(other), Ok(from)) = (Store::open(other), Second::open(root)) else { return };
    other.pull(&from).unwrap();
    assert!(other.verify().problems.is_empty(), "what was pulled is whole");
    store.verify();
    store.repair().unwrap();
    store.gc(&Limits { max_bytes: Some(0), ..Limits::default() }).unwrap();
}

/// A result of someone else, shown to people: that of any stage. What makes no sense to the stage is caught: memory, time and
/// AddressSanitizer's findings remain.
pub fn artifact(bytes: &[u8]) {
    static STORE: OnceLock<Store> = OnceLock::new();
    let store = STORE.get_or_init(|| {
        // libFuzzer's own hook ends the process where a panic is caught, too.
        std::panic::set_hook(Box::new(|_| {}));
        Store::open(folder().join("results")).unwrap()
    });
    for stage in hvi_flow::registry::STAGES.iter().filter(|stage| bytes.starts_with(stage.output.as_bytes())) {
        let d = store.put(bytes).unwrap();
        let _ = hvi_flow::registry::show(stage, d, store);
        let hex = d.hex();
        fs::remove_file(store.folder().join("objects").join(&hex.as_str()[..2]).join(&hex.as_str()[2..])).unwrap();
    }
}
