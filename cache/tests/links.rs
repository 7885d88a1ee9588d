//! A store that came from somebody else, with links, pipes and devices in it: nothing outside is read, written, moved or removed.
use hvi_cache::{Digest, Found, Limits, Recipe, Record, Second, Store, StoreError};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn recipe() -> Recipe {
    let (code, params) = (Digest::of(b"code"), serde_json::json!({}));
    Recipe { format: Recipe::FORMAT, stage: "test".into(), code, params, engine: None, inputs: Default::default() }
}

/// A store in `folder` with one result; its digest.
fn store_result(folder: &Path) -> Digest {
    let store = Store::open(folder).unwrap();
    let output = store.put(b"result").unwrap();
    let came = serde_json::json!({
        "output": output, "kind": "test/1", "bytes": 6, "wall_s": 1.0, "cpu_s": 1.0, "host": "here",
    });
    store.record(&recipe(), &serde_json::from_value::<Record>(came).unwrap()).unwrap();
    output
}

fn on_shelf(folder: &Path, shelf: &str, d: Digest) -> PathBuf {
    let hex = d.to_string();
    folder.join(shelf).join(&hex[..2]).join(&hex[2..])
}

/// A store, and a folder outside it with a file that must stay as it is.
fn store_and_outside() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (root, outside) = (folder.path().join("store"), folder.path().join("outside"));
    store_result(&root);
    fs::create_dir(&outside).unwrap();
    fs::write(outside.join("letter"), "mine").unwrap();
    (folder, root, outside)
}

#[track_caller]
fn untouched(outside: &Path) {
    let names: Vec<_> = fs::read_dir(outside).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["letter"]);
    assert_eq!(fs::read(outside.join("letter")).unwrap(), b"mine");
}

/// Does everything that moves or removes files.
fn tidy(store: &Store) {
    store.verify();
    let _ = store.repair();
    let _ = store.gc(&Limits { max_bytes: Some(0), older_than: Some(Duration::ZERO), ..Limits::default() });
}

#[test]
fn a_shelf_that_is_a_link_is_refused() {
    for shelf in ["recipes", "results", "objects", "tmp", "locks", "partial", "damaged"] {
        let (_folder, root, outside) = store_and_outside();
        let _ = fs::remove_dir_all(root.join(shelf));
        symlink(&outside, root.join(shelf)).unwrap();
        let refused = Store::open(&root);
        assert!(matches!(refused, Err(StoreError::Link { path }) if path == root.join(shelf)), "{shelf}");
        untouched(&outside);
    }
}

#[test]
fn the_store_as_a_whole_may_be_linked() {
    let (folder, root, _) = store_and_outside();
    symlink(&root, folder.path().join("link")).unwrap();
    let store = Store::open(folder.path().join("link")).unwrap();
    assert!(matches!(store.find(recipe().key()), Found::Whole(_)));
}

#[test]
fn folders_and_files_that_are_links_lead_nowhere() {
    let (_folder, root, outside) = store_and_outside();
    let output = Digest::of(b"result");
    for shelf in ["objects", "results", "recipes"] {
        let name = if shelf == "objects" { output } else { recipe().key() };
        let within = on_shelf(&root, shelf, name).parent().unwrap().to_path_buf();
        fs::remove_dir_all(&within).unwrap();
        symlink(&outside, &within).unwrap();
    }
    let store = Store::open(&root).unwrap();
    assert!(!matches!(store.find(recipe().key()), Found::Whole(_)));
    assert!(matches!(store.put(b"result"), Err(StoreError::Link { .. })));
    tidy(&store);
    untouched(&outside);
    // What led out is gone, and the store serves again.
    store_result(&root);
    assert!(matches!(Store::open(&root).unwrap().find(recipe().key()), Found::Whole(_)));
}

#[test]
fn files_that_are_links_are_not_written_through() {
    let (_folder, root, outside) = store_and_outside();
    let letter = outside.join("letter");
    fs::write(&letter, "mine").unwrap();
    let key = recipe().key();
    let own = [
        root.join("index"),
        root.join("format"),
        on_shelf(&root, "objects", Digest::of(b"result")),
        on_shelf(&root, "results", key),
        root.join("partial").join(key.to_string()),
        root.join("locks").join(key.to_string()),
    ];
    for path in own {
        let _ = fs::remove_file(&path);
        symlink(&letter, &path).unwrap();
    }
    let store = Store::open(&root).unwrap();
    store.find(key);
    store.partial(key);
    let _ = store.claim(key);
    store.keep_partial(key, b"half").unwrap();
    store_result(&root);
    tidy(&store);
    untouched(&outside);
}

/// A device is read without end, a pipe waited for without end: here and in a second store.
#[test]
fn pipes_and_devices_are_no_results() {
    let start = Instant::now();
    let (folder, root, _) = store_and_outside();
    let object = on_shelf(&root, "objects", Digest::of(b"result"));
    fs::remove_file(&object).unwrap();
    symlink("/dev/zero", &object).unwrap();
    let record = on_shelf(&root, "results", recipe().key());
    let fresh = || Store::open(folder.path().join("fresh")).unwrap();
    let second = || Second::open(&root).unwrap();
    assert_eq!(fresh().pull(&second()).unwrap().damaged, 1);
    assert!(matches!(Store::open(&root).unwrap().find(recipe().key()), Found::Damaged(_)));
    fs::remove_file(&record).unwrap();
    fs::remove_file(root.join("index")).unwrap();
    let made = std::process::Command::new("mkfifo").args([&record, &root.join("index")]).status();
    assert!(made.expect("this test needs mkfifo: apt-get install coreutils").success());
    assert_eq!(fresh().with_second(second()).find(recipe().key()), Found::Nothing);
    let store = Store::open(&root).unwrap();
    assert_eq!(store.find(recipe().key()), Found::Nothing);
    tidy(&store);
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}
