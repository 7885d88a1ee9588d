//! What may go wrong around a run: hands and clocks on its files, moves, kills. Never a wrong hit, never a wrong byte.
use super::project::{MANY, Project, SLOW, assert_counts, objects, said};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// Three stages, each the cheapest of its kind: an equation of state, an impact with it, a film of the impact.
const CHAIN: &str = r#"
[step.metal]
use = "eos.handbook"
set = "copper-royce"
[step.hit]
use = "impact"
projectile = { shape = "sphere", diameter = "1 mm", material = "copper" }
plate = { material = "copper", thickness = "0.5 mm", width = "2 mm", eos = "@metal" }
cells = 2
end = "0.1 us"
velocity = "2 km/s"
[step.film]
use = "radiograph"
run = "@hit"
width = 32
"#;

/// A study that reads a file.
const FILE: &str = r#"
[step.metal]
use = "eos.handbook"
set = "copper-royce"
[step.check]
use = "validate.isotherm"
eos = "@metal"
data = "measured.csv"
"#;

fn measured() -> String {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/data/cu_isotherm_dewaele2004.csv");
    std::fs::read_to_string(shipped).unwrap()
}

fn with_file() -> Project {
    let project = Project::new(FILE);
    project.write("measured.csv", &measured());
    project
}

/// Results for people, but for the page, which tells hits from computed results, and the notes that save work.
fn tables(project: &Project) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = project.files("out");
    let is_note = |path: &Path| path.file_name().unwrap().to_string_lossy().starts_with('.');
    all.retain(|(path, _)| !path.ends_with("report.html") && !is_note(path));
    assert!(!all.is_empty());
    all
}

// --- The six cases that a content cache must get right ---

#[test]
fn a_first_stage_that_makes_the_same_again_stops_there() {
    let project = Project::new(CHAIN);
    assert_counts(&project.run(), 0, 3);
    let key = first_key(&project, "eos.handbook");
    for shelf in ["results", "recipes"] {
        std::fs::remove_file(project.path(&format!("store/{shelf}/{}/{}", &key[..2], &key[2..]))).unwrap();
    }
    std::fs::remove_file(project.path("store/index")).unwrap();
    assert_counts(&project.run(), 2, 1);
}

/// Key of the only recipe of `stage`.
fn first_key(project: &Project, stage: &str) -> String {
    let recipes = project.files("store/recipes").into_iter();
    let mut of_stage = recipes.filter(|(_, bytes)| String::from_utf8_lossy(bytes).contains(&format!("\"{stage}\"")));
    let path = of_stage.next().unwrap().0;
    let parts: Vec<_> = path.iter().rev().take(2).map(|part| part.to_string_lossy().into_owned()).collect();
    format!("{}{}", parts[1], parts[0])
}

#[test]
fn an_input_that_goes_back_to_an_older_value_needs_no_work() {
    let project = with_file();
    assert_counts(&project.run(), 0, 2);
    let before = tables(&project);
    project.write("measured.csv", &format!("{}# one more line\n", measured()));
    assert_counts(&project.run(), 1, 1);
    project.write("measured.csv", &measured());
    assert_counts(&project.run(), 2, 0);
    assert!(tables(&project) == before);
}

#[test]
fn outputs_edited_by_hand_are_put_back_and_never_used() {
    let project = Project::new(CHAIN);
    project.run();
    let before = tables(&project);
    for step in ["film", "hit", "metal"] {
        std::fs::write(project.path(&format!("out/study/{step}.csv")), "edited by hand").unwrap();
        assert_counts(&project.run(), 3, 0);
        assert!(tables(&project) == before, "{step}");
    }
}

/// Damage that shows in no size and no time: found when the bytes are used, and made good in the same run.
#[test]
fn bytes_that_rot_in_the_store_are_made_again_when_they_are_needed() {
    let project = Project::new(CHAIN);
    project.run();
    let whole = objects(&project);
    rot(&project, b"eos/");
    project.write("study.toml", &CHAIN.replace("2 km/s", "3 km/s"));
    let again = project.run();
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(again.err.contains("0 from the store, 3 computed") && again.err.contains("damaged"), "{}", again.err);
    project.write("study.toml", CHAIN);
    assert_counts(&project.run(), 3, 0);
    let now = objects(&project);
    assert!(whole.iter().all(|(name, bytes)| now.get(name) == Some(bytes)));
    // No stage needs it, but the results for people do.
    let before = tables(&project);
    rot(&project, b"eos/");
    std::fs::remove_dir_all(project.path("out")).unwrap();
    assert_counts(&project.run(), 2, 1);
    assert!(tables(&project) == before && objects(&project) == now);
}

/// Changes a bit in each object that begins with `kind`, and no size and no time.
fn rot(project: &Project, kind: &[u8]) {
    for (path, mut bytes) in project.files("store/objects") {
        if bytes.starts_with(kind) {
            let time = std::fs::metadata(&path).unwrap().modified().unwrap();
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            std::fs::write(&path, bytes).unwrap();
            set_time(&path, time);
        }
    }
}

/// Kills at random times, `HVI_KILLS` of them (20 unless told): each run goes on where the last one was killed; whenever
/// one comes to its end, its results are compared with those of a run that nobody killed, and the next study begins.
#[test]
fn kills_at_random_times_cost_no_result_and_no_byte() {
    let kills: u32 = std::env::var("HVI_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(20);
    let study =
        format!("{MANY}{}", SLOW.replace("velocity = \"2 km/s\"", "sweep = { velocity = [\"2 km/s\", \"3 km/s\"] }"));
    let straight = Project::new(&study);
    assert_eq!(straight.run().code, 0);
    let (right, mut random) = (objects(&straight), 1_u64);
    let (mut finished, mut met, mut resumed, mut wrong, mut lost) = (0, 0, 0, 0, 0);
    let mut project = Project::new(&study);
    while met < kills {
        let run = ["run", "study.toml", "--json", "--checkpoint", "10ms"];
        let mut child = project.command(&run).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        std::thread::sleep(Duration::from_millis((random >> 33) % 700));
        let _ = child.kill();
        let output = child.wait_with_output().unwrap();
        let out = String::from_utf8_lossy(&output.stdout);
        resumed += out.matches("\"event\":\"resumed\"").count();
        lost += out.matches("\"event\":\"waiting\"").count();
        wrong += objects(&project).iter().filter(|(name, bytes)| right.get(*name) != Some(bytes)).count();
        if output.status.code() != Some(0) {
            met += 1;
            continue;
        }
        finished += 1;
        lost += usize::from(objects(&project) != right);
        project = Project::new(&study);
    }
    lost += usize::from(project.run().code != 0 || objects(&project) != right);
    assert_counts(&project.run(), 42, 0);
    println!(
        "{met} kills: {wrong} wrong objects, {lost} lost or locked, {resumed} nodes resumed, {finished} runs ended first"
    );
    assert_eq!((wrong, lost), (0, 0));
    assert!(resumed > 0, "no kill met a node with a checkpoint");
}

// --- Touched, moved, linked, older: what is no change of content ---

#[test]
fn times_and_places_of_files_are_no_part_of_a_key() {
    let project = with_file();
    assert_counts(&project.run(), 0, 2);
    let before = tables(&project);
    let day = Duration::from_secs(86400);
    for time in [SystemTime::now() + 1000 * day, SystemTime::UNIX_EPOCH + day] {
        for folder in ["store", "out"] {
            project.files(folder).iter().for_each(|(path, _)| set_time(path, time));
        }
        ["study.toml", "measured.csv"].iter().for_each(|name| set_time(&project.path(name), time));
        assert_counts(&project.run(), 2, 0);
    }
    // A clock that was set back: new content under an old time, at the same size.
    let time = std::fs::metadata(project.path("measured.csv")).unwrap().modified().unwrap();
    let changed = measured().replacen("# ", "#-", 1);
    assert!(changed != measured() && changed.len() == measured().len());
    project.write("measured.csv", &changed);
    set_time(&project.path("measured.csv"), time);
    assert_counts(&project.run(), 1, 1);
    project.write("measured.csv", &measured());
    set_time(&project.path("measured.csv"), time);
    assert_counts(&project.run(), 2, 0);
    assert!(tables(&project) == before);
}

fn set_time(path: &Path, time: SystemTime) {
    std::fs::File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
}

#[test]
fn a_moved_project_and_linked_inputs_hit() {
    let project = with_file();
    assert_counts(&project.run(), 0, 2);
    let folder = project.path("moved and renamed");
    std::fs::create_dir(&folder).unwrap();
    for name in ["study.toml", "measured.csv", "store", "out"] {
        std::fs::rename(project.path(name), folder.join(name)).unwrap();
    }
    let here = |arguments: &[&str]| {
        let mut command = project.command(arguments);
        said(command.current_dir(&folder).env("HVI_STORE", folder.join("store")).output().unwrap())
    };
    assert_counts(&here(&["run", "study.toml"]), 2, 0);
    std::fs::rename(folder.join("measured.csv"), folder.join("elsewhere.csv")).unwrap();
    std::os::unix::fs::symlink("elsewhere.csv", folder.join("measured.csv")).unwrap();
    std::os::unix::fs::symlink(folder.join("store"), project.path("store")).unwrap();
    std::os::unix::fs::symlink(&folder, project.path("linked")).unwrap();
    assert_counts(&here(&["run", "study.toml"]), 2, 0);
    assert_counts(&project.hvi(&["run", "linked/study.toml"]), 2, 0);
}

#[test]
fn paths_may_be_in_any_script() {
    let project = with_file();
    let folder = project.path("études/冲击 Überschall");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("κ=α².toml"), FILE.replace("measured.csv", "Kupfer – gemessen.csv")).unwrap();
    std::fs::write(folder.join("Kupfer – gemessen.csv"), measured()).unwrap();
    let here = || {
        let mut command = project.command(&["run", "κ=α².toml"]);
        said(command.current_dir(&folder).env("HVI_STORE", folder.join("магазин")).output().unwrap())
    };
    assert_counts(&here(), 0, 2);
    assert_counts(&here(), 2, 0);
    assert!(folder.join("out/κ=α²/report.html").exists());
}

/// The store travels as a file, as from one job of a CI to the next: in a fresh folder all is there.
#[test]
fn a_store_that_was_packed_and_unpacked_elsewhere_serves_everything() {
    let project = Project::new(&format!("{CHAIN}{}", MANY.replace("step.metal", "step.metals")));
    assert_counts(&project.run(), 0, 43);
    let fresh = Project::new(&std::fs::read_to_string(project.path("study.toml")).unwrap());
    let tar = |folder: &Path, arguments: &[&str]| {
        let status = Command::new("tar").current_dir(folder).args(arguments).status();
        assert!(status.expect("this test needs tar: apt-get install tar").success());
    };
    tar(project.folder.path(), &["-cf", "store.tar", "store"]);
    tar(fresh.folder.path(), &["-xf", project.path("store.tar").to_str().unwrap()]);
    assert_counts(&fresh.run(), 43, 0);
    for step in ["film", "hit", "metal", "metals"] {
        let table = format!("out/study/{step}.csv");
        assert_eq!(std::fs::read(fresh.path(&table)).unwrap(), std::fs::read(project.path(&table)).unwrap());
    }
}
