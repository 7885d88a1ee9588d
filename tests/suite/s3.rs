//! A bucket as second store, on a real S3-compatible server that these tests start and which ends with them.
use super::project::{Project, Said, assert_counts, objects, said};
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

const STUDY: &str = "[step.metal]\nuse = \"eos.handbook\"\nsweep = { set = [\"copper-royce\", \"aluminium-paper\"] }\n\
    [step.curves]\nuse = \"eos.curves\"\neos = \"@metal[set=copper-royce]\"\n";

/// The environment that leads to the server; it watches this process and ends with it.
fn server() -> &'static [(String, String)] {
    static SERVER: OnceLock<Vec<(String, String)>> = OnceLock::new();
    SERVER.get_or_init(|| {
        let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/s3.sh");
        let folder = std::env::temp_dir().join(format!("hvi-s3-{}", std::process::id()));
        let mut command = Command::new("bash");
        let up = command.arg(script).arg("up").arg(folder).arg(std::process::id().to_string()).output();
        let up = up.expect("this test needs bash");
        assert!(up.status.success(), "no server: {}", String::from_utf8_lossy(&up.stderr));
        let text = String::from_utf8_lossy(&up.stdout).into_owned();
        let pairs = text.lines().filter_map(|line| line.strip_prefix("export ")?.split_once('='));
        pairs.map(|(name, value)| (name.to_string(), value.to_string())).collect()
    })
}

fn hvi(project: &Project, arguments: &[&str]) -> Said {
    let mut command = project.command(arguments);
    said(command.envs(server().iter().map(|(k, v)| (k, v))).output().unwrap())
}

/// What `curl` says of an object of the bucket; it signs requests too.
fn curl(path: &str, more: &[&str]) -> String {
    let value = |name: &str| &server().iter().find(|(k, _)| k == name).unwrap().1;
    let user = format!("{}:{}", value("AWS_ACCESS_KEY_ID"), value("AWS_SECRET_ACCESS_KEY"));
    let mut command = Command::new("curl");
    command.args(["-sf", "--aws-sigv4", "aws:amz:us-east-1:s3", "--user", &user]).args(more);
    let output = command.arg(format!("{}/team/{path}", value("AWS_ENDPOINT_URL"))).output().unwrap();
    assert!(output.status.success(), "this test needs curl: apt-get install curl");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// One machine pushes, another pulls, or reads through: nothing is computed twice, and bytes are the same.
#[test]
fn results_travel_by_a_bucket() {
    let (bucket, project) = ("s3://team/travel", Project::new(STUDY));
    project.run();
    let said = hvi(&project, &["cache", "push", bucket]);
    assert!(said.code == 0 && said.out.contains("3 results"), "{}{}", said.out, said.err);
    let said = hvi(&project, &["cache", "push", bucket]);
    assert!(said.out.contains("0 results") && said.out.contains("3 were there"), "{}{}", said.out, said.err);
    for pulled in [true, false] {
        let other = Project::new(STUDY);
        let said = if pulled {
            let said = hvi(&other, &["cache", "pull", bucket]);
            assert!(said.code == 0 && said.out.contains("3 results"), "{}{}", said.out, said.err);
            other.run()
        } else {
            hvi(&other, &["run", "study.toml", "--second-store", bucket])
        };
        assert_counts(&said, 3, 0);
        assert!(objects(&other) == objects(&project));
        assert_counts(&other.run(), 3, 0);
    }
}

/// What was changed in the bucket fits its digest no longer: it is computed, not believed.
#[test]
fn a_bucket_is_not_believed() {
    let (bucket, project) = ("s3://team/rot", Project::new(STUDY));
    project.run();
    hvi(&project, &["cache", "push", bucket]);
    project.write("rot", "rot");
    let rot = project.path("rot").to_str().unwrap().to_string();
    for (path, _) in project.files("store/objects") {
        let name = path.strip_prefix(project.path("store")).unwrap().to_str().unwrap().to_string();
        curl(&format!("rot/{name}"), &["-T", &rot]);
    }
    let other = Project::new(STUDY);
    assert_counts(&hvi(&other, &["run", "study.toml", "--second-store", bucket]), 0, 3);
    assert!(objects(&other) == objects(&project));
    let other = Project::new(STUDY);
    let said = hvi(&other, &["cache", "pull", bucket]);
    assert!(said.code == 1 && said.out.contains("3 are damaged"), "{}{}", said.out, said.err);
}

/// No service, no bucket, no rights: one line says which, and the run goes on without.
#[test]
fn a_bucket_that_is_out_of_reach_is_named_and_no_obstacle() {
    let none = [("AWS_ENDPOINT_URL", "http://127.0.0.1:1")];
    let wrong = [("AWS_SECRET_ACCESS_KEY", "wrong")];
    for (bucket, more, what) in [
        ("s3://team/x", &none[..], "s3://team/x: "),
        ("s3://team/x", &wrong[..], "s3://team/x: "),
        ("s3://absent/x", &[], "s3://absent/x: "),
    ] {
        let project = Project::new(STUDY);
        let command = |arguments: &[&str]| {
            let mut command = project.command(arguments);
            command.envs(server().iter().map(|(k, v)| (k, v))).envs(more.iter().copied());
            said(command.output().unwrap())
        };
        let run = command(&["run", "study.toml", "--second-store", bucket]);
        assert_counts(&run, 0, 3);
        let is_named = |line: &&str| line.starts_with(what) && line.contains("goes on without it");
        let named = run.err.lines().filter(is_named).count();
        // A bucket that isn't there has no results either, and a service may answer just that.
        assert!(named == 1 || (named == 0 && bucket.contains("absent")), "{}", run.err);
        let pushed = command(&["cache", "push", bucket]);
        assert!(pushed.code == 1 && pushed.err.contains(what), "{}{}", pushed.out, pushed.err);
    }
}
