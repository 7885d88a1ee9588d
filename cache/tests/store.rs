//! The store as its users meet it: damage, two writers, a folder that can't be written, other formats, upkeep.
use hvi_cache::{Digest, Found, Limits, Recipe, Record, Second, Store, StoreError};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

fn recipe(n: usize) -> Recipe {
    Recipe {
        format: Recipe::FORMAT,
        stage: "test".into(),
        code: Digest::of(b"code"),
        params: serde_json::json!({ "n": n }),
        engine: None,
        inputs: Default::default(),
    }
}

fn record(output: Digest, bytes: usize) -> Record {
    Record {
        output,
        kind: "test/1".into(),
        bytes: bytes as u64,
        wall_s: 1.5,
        cpu_s: 1.25,
        host: "here".into(),
        program: "0.1.0".into(),
        compiler: "rustc".into(),
        threads: 2,
        cores: 4,
        finished: 1_700_000_000,
        foretold_s: 1.0,
    }
}

/// Stores the result of recipe `n`; returns its key and its digest.
fn store_result(store: &Store, n: usize) -> (Digest, Digest) {
    let bytes = format!("result {n}").into_bytes();
    let output = store.put(&bytes).unwrap();
    store.record(&recipe(n), &record(output, bytes.len())).unwrap();
    (recipe(n).key(), output)
}

fn object(folder: &Path, d: Digest) -> PathBuf {
    on_shelf(folder, "objects", d)
}

fn on_shelf(folder: &Path, shelf: &str, d: Digest) -> PathBuf {
    let hex = d.to_string();
    folder.join(shelf).join(&hex[..2]).join(&hex[2..])
}

fn whole(store: &Store, key: Digest) -> bool {
    matches!(store.find(key), Found::Whole(_))
}

/// Results stand until one of them is edited, written anew or removed, or somebody adds to the store or tidies it up.
#[test]
fn results_stand_until_something_changes() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let (keys, outputs): (Vec<Digest>, Vec<Digest>) = (0..3).map(|n| store_result(&store, n)).unzip();
    let standing = || Store::open(folder.path()).unwrap().standing(keys.iter().copied()).unwrap();
    let stands = |before| Store::open(folder.path()).unwrap().stands(before);
    let before = standing();
    assert!(stands(&before) && standing() == before);
    let path = object(folder.path(), outputs[1]);
    let (good, time) = (fs::read(&path).unwrap(), fs::metadata(&path).unwrap().modified().unwrap());
    let set_time = |time| fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
    fs::write(&path, b"other 1!").unwrap();
    set_time(time + Duration::from_nanos(1));
    assert!(!stands(&before), "edited");
    fs::write(&path, b"shorter").unwrap();
    set_time(time);
    assert!(!stands(&before), "another size");
    fs::remove_file(&path).unwrap();
    assert!(!stands(&before), "gone");
    fs::write(&path, good).unwrap();
    set_time(time);
    assert!(stands(&before));
    store_result(&store, 3);
    assert!(!stands(&before), "something was added");
    let later = standing();
    store.repair().unwrap();
    assert!(!stands(&later), "the index was written anew");
    assert_eq!(store.standing([recipe(9).key()].into_iter()), None);
}

#[test]
fn the_latest_results_of_a_kind_come_first() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let keys: Vec<Digest> = (1..=3).map(|n| store_result(&store, n).0).collect();
    for store in [&store, &Store::open(folder.path()).unwrap()] {
        assert_eq!(store.latest("test/1", 2), [keys[2], keys[1]]);
        assert!(store.latest("other/1", 2).is_empty());
    }
}

#[test]
fn what_was_recorded_is_found_with_and_without_the_index() {
    let folder = tempfile::tempdir().unwrap();
    let (key, output) = store_result(&Store::open(folder.path()).unwrap(), 1);
    for index in [true, false, true] {
        if !index {
            fs::remove_file(folder.path().join("index")).unwrap();
        }
        let store = Store::open(folder.path()).unwrap();
        let Found::Whole(entry) = store.find(key) else { panic!("{:?}", store.find(key)) };
        assert_eq!((entry.output, entry.kind(), entry.bytes), (output, "test/1", 8));
        assert_eq!((entry.wall_s, entry.cpu_s), (1.5, 1.25));
        assert_eq!(store.lookup(key), Some(record(output, 8)));
        assert_eq!(store.recipe(key), Some(recipe(1)));
        assert_eq!(store.find(recipe(2).key()), Found::Nothing);
        assert!(store.notices().is_empty());
    }
}

/// Records written before there was provenance.
#[test]
fn a_record_without_provenance_reads() {
    let old = r#"{"output":"af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262","kind":"eos/1","bytes":0,"wall_s":0.5,"cpu_s":0.5,"host":"there"}"#;
    let record: Record = serde_json::from_str(old).unwrap();
    assert_eq!((record.host.as_str(), record.threads, record.finished), ("there", 0, 0));
}

#[test]
fn opening_and_asking_make_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("absent");
    let store = Store::open(&root).unwrap();
    let key = recipe(1).key();
    assert_eq!(store.find(key), Found::Nothing);
    assert!(store.recipe(key).is_none() && store.partial(key).is_none() && !store.holds(key));
    assert_eq!(store.stats().bytes(), 0);
    assert!(store.verify().problems.is_empty());
    drop(store);
    assert!(!root.exists());
}

#[test]
fn another_format_is_refused_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("format"), "hvi-store/99\n").unwrap();
    let Err(e) = Store::open(folder.path()) else { panic!("opened") };
    assert!(matches!(e, StoreError::Format { .. }));
    let text = e.to_string();
    assert!(text.contains("hvi-store/99") && text.contains("hvi-store/1") && text.contains("--store"), "{text}");
}

/// What lies in the store proves itself, so a damaged note of its format hides nothing.
#[test]
fn a_damaged_note_of_the_format_is_written_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (key, _) = store_result(&Store::open(folder.path()).unwrap(), 1);
    let path = folder.path().join("format");
    let right = fs::read(&path).unwrap();
    for bad in 0..right.len() {
        let mut bytes = right.clone();
        bytes[bad] ^= 2;
        fs::write(&path, bytes).unwrap();
        let store = Store::open(folder.path()).unwrap();
        assert!(whole(&store, key), "byte {bad}");
        store_result(&store, 2 + bad);
        assert_eq!(fs::read(&path).unwrap(), right);
    }
}

#[test]
fn damaged_objects_are_noticed_and_moved_aside() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let (key, output) = store_result(&store, 1);
    let path = object(folder.path(), output);
    for bad in ["rusult 1", "result", ""] {
        // Another time than the one it was stored at, whatever the resolution of the file system's clock.
        fs::write(&path, bad).unwrap();
        let file = fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(SystemTime::now() + Duration::from_secs(5)).unwrap();
        assert_eq!(store.find(key), Found::Damaged(output), "{bad:?}");
        assert!(matches!(store.get(output), Err(StoreError::Damaged(d)) if d == output));
        assert_eq!(fs::read_to_string(folder.path().join("damaged").join(output.to_string())).unwrap(), bad);
        assert_eq!(store.find(key), Found::Damaged(output), "it is gone");
        store_result(&store, 1);
        assert!(whole(&store, key));
    }
}

/// Bits that rot change no time: they are found when they are used, and never served.
#[test]
fn damage_that_changes_no_time_is_never_served() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let (_, output) = store_result(&store, 1);
    let path = object(folder.path(), output);
    let time = fs::metadata(&path).unwrap().modified().unwrap();
    fs::write(&path, "rusult 1").unwrap();
    fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
    assert!(matches!(store.get(output), Err(StoreError::Damaged(_))));
    fs::write(&path, "rusult 1").unwrap();
    assert_eq!(store.verify().problems.len(), 2, "the object, and its record without it");
}

/// A store that was copied has other times: what is whole is found whole, and its time is known from then on.
#[test]
fn other_times_cost_one_look_at_the_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (key, output) = store_result(&Store::open(folder.path()).unwrap(), 1);
    let file = fs::File::options().write(true).open(object(folder.path(), output)).unwrap();
    file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(1)).unwrap();
    let index = || fs::metadata(folder.path().join("index")).unwrap().len();
    let before = index();
    assert!(whole(&Store::open(folder.path()).unwrap(), key));
    assert_eq!(index(), before + 128, "one entry more");
    assert!(whole(&Store::open(folder.path()).unwrap(), key));
    assert_eq!(index(), before + 128, "and no other");
}

#[test]
fn a_damaged_record_is_unknown_reported_and_moved_aside() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let (key, _) = store_result(&store, 1);
    let (other, _) = store_result(&store, 2);
    fs::remove_file(folder.path().join("index")).unwrap();
    // One overwritten, one in another's place.
    fs::copy(on_shelf(folder.path(), "results", other), on_shelf(folder.path(), "results", key)).unwrap();
    fs::write(on_shelf(folder.path(), "results", other), "{").unwrap();
    let store = Store::open(folder.path()).unwrap();
    assert_eq!((store.find(key), store.find(other)), (Found::Nothing, Found::Nothing));
    assert_eq!(store.notices().len(), 2);
    assert_eq!(fs::read_dir(folder.path().join("damaged")).unwrap().count(), 2);
}

#[test]
fn a_damaged_index_is_reported_moved_aside_and_grows_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("index");
    let store = Store::open(folder.path()).unwrap();
    let keys: Vec<Digest> = (0..20).map(|n| store_result(&store, n).0).collect();
    let good = fs::read(&path).unwrap();
    assert_eq!(good.len(), 21 * 128);
    let mut bits = good.clone();
    bits[128 + 40] ^= 1; // the digest of a result
    let mut key = good.clone();
    key[2 * 128] ^= 1; // a key: nobody asks for it, and its own is looked up in `results/`
    for (bad, noticed) in [(bits, 1), (key, 0), (good[..300].to_vec(), 1), (b"junk".repeat(64), 1), (vec![], 0)] {
        fs::write(&path, &bad).unwrap();
        let store = Store::open(folder.path()).unwrap();
        assert!(keys.iter().all(|key| whole(&store, *key)));
        assert_eq!(store.notices().len(), noticed);
        let again = Store::open(folder.path()).unwrap();
        assert!(keys.iter().all(|key| whole(&again, *key)) && again.notices().is_empty());
    }
}

#[test]
fn what_another_process_records_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (Store::open(folder.path()).unwrap(), Store::open(folder.path()).unwrap());
    let key = store_result(&a, 1).0;
    assert!(whole(&b, key));
}

/// Eight writers of overlapping keys, each with a store of its own as if in a process of its own.
#[test]
fn writers_at_once_leave_a_whole_store() {
    let folder = tempfile::tempdir().unwrap();
    std::thread::scope(|scope| {
        for first in 0..8 {
            let folder = folder.path();
            scope.spawn(move || {
                let store = Store::open(folder).unwrap();
                (0..100).for_each(|n| {
                    assert!(store_result(&store, (7 * first + n) % 100).0 == recipe((7 * first + n) % 100).key())
                });
            });
        }
    });
    let store = Store::open(folder.path()).unwrap();
    assert!((0..100).all(|n| whole(&store, recipe(n).key())));
    let verified = store.verify();
    assert_eq!((verified.objects, verified.records, verified.problems), (100, 100, vec![]));
    assert_eq!(store.stats().tmp.count, 0);
}

#[test]
fn a_claim_keeps_others_out_until_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (Store::open(folder.path()).unwrap(), Store::open(folder.path()).unwrap());
    let (key, other) = (recipe(1).key(), recipe(2).key());
    let claim = a.claim(key).unwrap().unwrap();
    assert!(b.claim(key).unwrap().is_none());
    assert!(b.claim(other).unwrap().is_some());
    drop(claim);
    assert!(b.claim(key).unwrap().is_some());
    // What a killed process leaves is a file that nobody holds.
    fs::write(folder.path().join("locks").join(key.to_string()), "").unwrap();
    assert!(a.claim(key).unwrap().is_some());
}

/// Many threads want one key again and again: never two at once, though the lock's file comes and goes.
#[test]
fn a_claim_is_never_held_twice() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let folder = tempfile::tempdir().unwrap();
    let (inside, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let key = recipe(1).key();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let store = Store::open(folder.path()).unwrap();
                for _ in 0..2000 {
                    if let Some(claim) = store.claim(key).unwrap() {
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                        taken.fetch_add(1, Ordering::SeqCst);
                        inside.fetch_sub(1, Ordering::SeqCst);
                        drop(claim);
                    }
                }
            });
        }
    });
    assert!(taken.into_inner() > 0);
}

#[test]
fn partials_are_sealed() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let (key, other) = (recipe(1).key(), recipe(2).key());
    assert_eq!(store.partial(key), None);
    store.keep_partial(key, b"one").unwrap();
    store.keep_partial(key, b"two").unwrap();
    assert_eq!(store.partial(key).unwrap(), b"two");
    let path = folder.path().join("partial").join(key.to_string());
    let good = fs::read(&path).unwrap();
    fs::write(folder.path().join("partial").join(other.to_string()), &good).unwrap();
    assert_eq!(store.partial(other), None, "kept for another key");
    for at in [0, good.len() - 1] {
        let mut bad = good.clone();
        bad[at] ^= 1;
        fs::write(&path, bad).unwrap();
        assert_eq!(store.partial(key), None);
        assert!(!path.exists());
    }
    fs::write(&path, &good[..20]).unwrap();
    assert_eq!(store.partial(key), None, "cut short");
    store.keep_partial(key, b"").unwrap();
    assert_eq!(store.partial(key).unwrap(), b"");
    store.drop_partial(key);
    assert_eq!(store.partial(key), None);
}

/// As a user who may not write there: the owner of all files may always, so the thread gives that up.
#[test]
fn a_store_that_cannot_be_written_serves_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let (key, output) = store_result(&Store::open(folder.path()).unwrap(), 1);
    fs::remove_file(folder.path().join("index")).unwrap();
    let mut all = vec![folder.path().to_path_buf()];
    let mut next = 0;
    while next < all.len() {
        let entries = fs::read_dir(&all[next]).unwrap().map(|e| e.unwrap().path());
        all.extend(entries.filter(|p| p.is_dir()).collect::<Vec<_>>());
        next += 1;
    }
    let mode = |path: &PathBuf, mode| {
        fs::set_permissions(path, std::os::unix::fs::PermissionsExt::from_mode(mode)).unwrap();
    };
    all.iter().for_each(|path| mode(path, 0o555));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            if rustix::process::getuid().is_root() {
                // Of this thread only: the standard library's other threads keep theirs.
                rustix::thread::set_thread_uid(rustix::process::Uid::from_raw(65534)).unwrap();
            }
            let store = Store::open(folder.path()).unwrap();
            assert!(whole(&store, key));
            assert_eq!(store.get(output).unwrap(), b"result 1");
            assert_eq!(store.put(b"result 1").unwrap(), output, "what is there needs no writing");
            let refused = [
                store.put(b"new").unwrap_err(),
                store.record(&recipe(1), &record(output, 8)).unwrap_err(),
                store.keep_partial(key, b"x").unwrap_err(),
                store.claim(key).unwrap_err(),
                store.hold().unwrap_err(),
                store.repair().unwrap_err(),
            ];
            for e in refused {
                assert!(matches!(e, StoreError::ReadOnly { .. }) && e.to_string().contains("--store"), "{e}");
            }
        });
    });
    all.iter().for_each(|path| mode(path, 0o755));
}

#[test]
fn verify_reads_everything() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let made: Vec<(Digest, Digest)> = (0..6).map(|n| store_result(&store, n)).collect();
    assert_eq!((store.verify().objects, store.verify().records), (6, 6));
    let spoil = |path: PathBuf| {
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(path, bytes).unwrap();
    };
    spoil(object(folder.path(), made[0].1));
    spoil(on_shelf(folder.path(), "results", made[1].0));
    spoil(on_shelf(folder.path(), "recipes", made[2].0));
    store.keep_partial(made[3].0, b"partial").unwrap();
    spoil(folder.path().join("partial").join(made[3].0.to_string()));
    spoil(folder.path().join("index"));
    fs::write(folder.path().join("objects/stray"), "x").unwrap();
    let found = store.verify();
    // The six, and the record whose object is gone now.
    assert_eq!(found.problems.len(), 7, "{:#?}", found.problems);
    assert_eq!((found.objects, found.records), (5, 4));
    assert!(!object(folder.path(), made[0].1).exists());
    assert_eq!(store.verify().problems.len(), 1, "the record without object stays until repair");
    store.repair().unwrap();
    assert_eq!(store.verify().problems, []);
}

#[test]
fn repair_drops_what_leads_nowhere_and_what_killed_runs_left() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let made: Vec<(Digest, Digest)> = (0..4).map(|n| store_result(&store, n)).collect();
    fs::remove_file(object(folder.path(), made[0].1)).unwrap();
    fs::write(on_shelf(folder.path(), "results", made[1].0), "{").unwrap();
    fs::write(folder.path().join("locks").join(made[2].0.to_string()), "").unwrap();
    for (name, age) in [("1-0", 7200), ("1-1", 0)] {
        let path = folder.path().join("tmp").join(name);
        fs::write(&path, "x").unwrap();
        let file = fs::File::options().write(true).open(path).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(age)).unwrap();
    }
    let done = store.repair().unwrap();
    assert_eq!((done.indexed, done.records, done.leftovers), (2, 2, 2));
    assert!(folder.path().join("tmp/1-1").exists(), "a run may be writing it");
    assert_eq!(store.find(made[0].0), Found::Nothing);
    assert!(whole(&store, made[3].0) && whole(&Store::open(folder.path()).unwrap(), made[3].0));
    let _running = store.hold().unwrap();
    let other = Store::open(folder.path()).unwrap();
    assert!(matches!(other.repair(), Err(StoreError::Busy { .. })));
    assert!(matches!(other.gc(&Limits::default()), Err(StoreError::Busy { .. })));
}

fn aged(folder: &Path, key: Digest, days: u64) {
    let file = fs::File::options().write(true).open(on_shelf(folder, "results", key)).unwrap();
    file.set_modified(SystemTime::now() - Duration::from_secs(days * 86400)).unwrap();
}

#[test]
fn gc_removes_by_age_and_keeps_pins() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let made: Vec<(Digest, Digest)> = (0..6).map(|n| store_result(&store, n)).collect();
    made.iter().enumerate().for_each(|(n, (key, _))| aged(folder.path(), *key, n as u64 * 10 + 1));
    let orphan = store.put(b"nobody's").unwrap();
    let limits = Limits {
        older_than: Some(Duration::from_secs(25 * 86400)),
        pins: [made[4].0].into(),
        dry_run: true,
        ..Limits::default()
    };
    let before = store.stats();
    let would = store.gc(&limits).unwrap();
    assert_eq!((would.results, would.files), (2, 7), "two results of three files, and nobody's");
    assert_eq!(store.stats(), before);
    let done = store.gc(&Limits { dry_run: false, ..limits }).unwrap();
    assert_eq!(done, would);
    for store in [&store, &Store::open(folder.path()).unwrap()] {
        let there: Vec<bool> = made.iter().map(|(key, _)| whole(store, *key)).collect();
        assert_eq!(there, [true, true, true, false, true, false]);
    }
    assert!(!store.holds(orphan));
    assert_eq!(store.verify().problems, []);
}

#[test]
fn gc_removes_by_size_the_oldest_first_and_shared_results_last() {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(folder.path()).unwrap();
    let big = vec![7; 100_000];
    let shared = store.put(&big).unwrap();
    store.record(&recipe(0), &record(shared, big.len())).unwrap();
    store.record(&recipe(1), &record(shared, big.len())).unwrap();
    let made: Vec<Digest> = (2..6).map(|n| store_result(&store, n).0).collect();
    for (days, key) in [recipe(0).key(), recipe(1).key()].iter().chain(&made).enumerate() {
        aged(folder.path(), *key, days as u64);
    }
    let done = store.gc(&Limits { max_bytes: Some(102_000), ..Limits::default() }).unwrap();
    assert!(done.left <= 102_000 + 1000, "{done:?}");
    assert!(whole(&store, recipe(0).key()) && whole(&store, recipe(1).key()), "the object they share counts once");
    assert!(!whole(&store, made[3]), "the oldest went");
    let done = store.gc(&Limits { max_bytes: Some(0), ..Limits::default() }).unwrap();
    assert_eq!((store.stats().objects.count, store.stats().results.count), (0, 0), "{done:?}");
}

#[test]
fn a_second_store_serves_what_the_first_one_lacks_and_only_what_is_whole() {
    let (own, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let second = Store::open(other.path()).unwrap();
    let results: Vec<_> = (0..4).map(|n| store_result(&second, n)).collect();
    fs::write(object(other.path(), results[1].1), "not what it should be").unwrap();
    fs::write(on_shelf(other.path(), "results", results[2].0), "no record").unwrap();
    fs::write(on_shelf(other.path(), "recipes", results[3].0), "no recipe").unwrap();
    let before = files_below(other.path());
    let store = Store::open(own.path()).unwrap().with_second(Second::open(other.path()).unwrap());
    assert!(whole(&store, results[0].0));
    assert!(results[1..].iter().all(|(key, _)| !whole(&store, *key)), "damage is not passed on");
    assert_eq!(files_below(other.path()), before, "it is only read");
    // What came is the first one's own now.
    let alone = Store::open(own.path()).unwrap();
    assert!(whole(&alone, results[0].0) && alone.get(results[0].1).unwrap() == b"result 0");
    assert_eq!(alone.recipe(results[0].0), Some(recipe(0)));
    // What is damaged here comes from there again.
    fs::write(object(own.path(), results[0].1), "rot").unwrap();
    assert!(whole(&store, results[0].0) && store.get(results[0].1).unwrap() == b"result 0");
    // No second store is no obstacle.
    let gone = Store::open(own.path()).unwrap().with_second(Second::open(&own.path().join("absent")).unwrap());
    assert!(whole(&gone, results[0].0) && !whole(&gone, results[1].0));
}

#[test]
fn a_whole_store_is_copied_once() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let from = Store::open(a.path()).unwrap();
    let second = Second::open(a.path()).unwrap();
    let results: Vec<_> = (0..5).map(|n| store_result(&from, n)).collect();
    fs::write(object(a.path(), results[4].1), "rot").unwrap();
    let to = Store::open(b.path()).unwrap();
    store_result(&to, 0);
    let done = to.pull(&second).unwrap();
    assert_eq!((done.results, done.known, done.damaged, done.bytes), (3, 1, 1, 24));
    let done = from.push(&Second::open(b.path()).unwrap()).unwrap();
    assert_eq!((done.results, done.known, done.damaged, done.bytes), (0, 4, 1, 0));
    let to = Store::open(b.path()).unwrap();
    assert!(results[..4].iter().all(|(key, _)| whole(&to, *key)));
    assert!(to.verify().problems.is_empty());
}

fn files_below(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut todo = vec![folder.to_path_buf()];
    while let Some(folder) = todo.pop() {
        for entry in fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() { todo.push(path) } else { all.push((path.clone(), fs::read(path).unwrap())) }
        }
    }
    all.sort();
    all
}

/// Records, recipes, the index and the format under random edits: what is served is right or not served, and nothing panics.
#[test]
fn random_edits_of_its_files_never_lead_to_another_result() {
    let mut state = 1_u64;
    let mut below = |n: usize| {
        // Knuth's linear congruential generator (MMIX): the same edits each time.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 33) as usize) % n.max(1)
    };
    let folder = tempfile::tempdir().unwrap();
    let results: Vec<_> = (0..3).map(|n| store_result(&Store::open(folder.path()).unwrap(), n)).collect();
    let whole_files = files_below(folder.path());
    for _ in 0..400 {
        for (path, bytes) in &whole_files {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        let (path, bytes) = &whole_files[below(whole_files.len())];
        let mut bytes = bytes.clone();
        for _ in 0..=below(3) {
            let at = below(bytes.len());
            match below(4) {
                _ if bytes.is_empty() => {}
                0 => bytes[at] ^= 1 << below(8),
                1 => bytes.truncate(at),
                2 => bytes.insert(at, [b'"', b'{', b'0', 0, 0xff, b'\n'][below(6)]),
                _ => drop(bytes.remove(at)),
            }
        }
        fs::write(path, bytes).unwrap();
        let store = match Store::open(folder.path()) {
            Ok(store) => store,
            // An edit that leaves a number of another format says so.
            Err(e) => {
                assert!(matches!(e, StoreError::Format { .. }), "{}: {e}", path.display());
                continue;
            }
        };
        for (n, (key, output)) in results.iter().enumerate() {
            if let Found::Whole(entry) = store.find(*key) {
                assert_eq!(entry.output, *output, "{}", path.display());
                assert!(store.get(*output).is_ok_and(|bytes| bytes == format!("result {n}").as_bytes()));
            }
            assert!(store.recipe(*key).is_none_or(|found| found == recipe(n)));
            assert!(store.lookup(*key).is_none_or(|found| found.output == *output));
        }
        store.latest("test/1", 9);
        store.verify();
        store.repair().unwrap();
    }
}
