//! The fuzz targets' readers on their corpora, and on all parts of its files: no panic, no endless loop.
use std::path::Path;
use std::time::{Duration, Instant};

#[path = "../../fuzz/readers.rs"]
mod readers;

/// Beginnings of each file that are read too.
const CUTS: usize = 8;

#[test]
fn every_reader_survives_its_corpus() {
    let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for (name, read) in readers::ALL {
        let folder = corpora.join(name);
        let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(!files.is_empty(), "{} is empty", folder.display());
        for path in files {
            let bytes = std::fs::read(&path).unwrap();
            let start = Instant::now();
            for cut in 1..=CUTS {
                // A panic names the file that it is about, or nobody finds it.
                let part = &bytes[..bytes.len() * cut / CUTS];
                let done = std::panic::catch_unwind(|| read(part));
                assert!(done.is_ok(), "{}, its first {} bytes", path.display(), part.len());
            }
            assert!(start.elapsed() < Duration::from_secs(60), "{}: {:?}", path.display(), start.elapsed());
        }
    }
    readers::tidy();
}
