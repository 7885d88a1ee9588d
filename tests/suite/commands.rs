//! Every command beside `run`: what it says, and what it says of bad input.
use super::project::Project;
use std::path::Path;

/// A chain of two cheap, real stages.
fn chain() -> Project {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/data");
    Project::new(&format!(
        "# A chain.\n[step.metal]\nuse = \"eos.handbook\"\nset = \"copper-royce\"\n\
         [step.shock]\nuse = \"validate.hugoniot\"\neos = \"@metal\"\nmarsh = '{0}/cu_hugoniot_marsh1980.csv'\n\
         database = '{0}/cu_hugoniot_shockwave_database.csv'\n",
        data.display()
    ))
}

/// Three points of one cheap stage.
fn sweep() -> Project {
    Project::new(
        "[step.metal]\nuse = \"eos.handbook\"\nsweep = { set = [\"copper-royce\", \"copper-paper-md\", \"aluminium-paper\"] }\n",
    )
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e} in {text}"))
}

#[test]
fn explain_names_each_field_old_and_new_and_what_waits_for_it() {
    let project = chain();
    assert_eq!(project.run().code, 0);
    let said = project.hvi(&["explain", "study.toml"]);
    assert!(said.out.contains("all 2 results are in the store"), "{}", said.out);
    let said = project.hvi(&["explain", "study.toml", "--set", "metal.set=copper-paper-md"]);
    assert!(said.out.contains("metal, by eos.handbook: to run, it differs from its last run"), "{}", said.out);
    assert!(said.out.contains("params.set: copper-royce -> copper-paper-md"), "{}", said.out);
    assert!(said.out.contains("shock, by validate.hugoniot: unknown until metal has a result"), "{}", said.out);
    assert!(said.out.contains("nothing else differs"), "{}", said.out);
    let both = ["explain", "study.toml", "shock", "--set", "metal.set=copper-paper-md", "--set", "shock.up_to=300 GPa"];
    let said = project.hvi(&both);
    assert!(said.out.contains("differs from its last run already"), "{}", said.out);
    assert!(said.out.contains("params.up_to: 400000000000.0 Pa -> 300000000000.0 Pa"), "{}", said.out);
    assert!(said.out.contains("what it waits for:\n  metal (1): to run: params.set: copper-royce"), "{}", said.out);
    assert!(said.out.contains("inputs.eos = unknown until metal"), "{}", said.out);
}

#[test]
fn explain_follows_a_changed_input_to_its_cause() {
    let project = chain();
    project.run();
    project.hvi(&["run", "study.toml", "--only", "metal", "--set", "metal.set=copper-paper-md"]);
    let said = project.hvi(&["explain", "study.toml", "shock", "--set", "metal.set=copper-paper-md"]);
    assert!(said.out.contains("inputs.eos: the result of metal changed"), "{}", said.out);
    assert!(said.out.contains("because of metal: params.set: copper-royce -> copper-paper-md"), "{}", said.out);
}

/// Back to an earlier value, which computes nothing, then on to a third: the reason names the value in between.
#[test]
fn explain_compares_with_the_last_run_even_if_that_computed_nothing() {
    let project = chain();
    for set in ["copper-royce", "copper-paper-md", "copper-royce"] {
        assert_eq!(project.hvi(&["run", "study.toml", "--set", &format!("metal.set={set}")]).code, 0);
    }
    let said = project.hvi(&["explain", "study.toml", "metal", "--set", "metal.set=aluminium-paper"]);
    assert!(said.out.contains("params.set: copper-royce -> aluminium-paper"), "{}", said.out);
}

#[test]
fn explain_shows_what_counts_in_a_key() {
    let project = chain();
    project.run();
    let said = project.hvi(&["explain", "study.toml", "shock"]);
    for part in [
        "in the store, computed 20",
        "its key",
        "stage = validate.hugoniot",
        "code = ",
        "params.up_to = ",
        "(the result of metal)",
        "(the file's content)",
    ] {
        assert!(said.out.contains(part), "{part} in {}", said.out);
    }
    let parsed = json(&project.hvi(&["explain", "study.toml", "shock", "--json"]).out);
    assert_eq!((parsed["state"].as_str(), parsed["node"].as_str()), (Some("known"), Some("shock")));
}

#[test]
fn what_explain_is_asked_for_must_exist() {
    let project = sweep();
    for (of, part) in [
        ("metall", "did you mean `metal`?"),
        ("metal[sett=copper-royce]", "did you mean `set`?"),
        ("metal[set=lead]", "it has: set=copper-royce | set=copper-paper-md"),
        ("metal[set", "`[` is not closed"),
    ] {
        let said = project.hvi(&["explain", "study.toml", of]);
        assert_eq!(said.code, 2, "{of}");
        assert!(said.err.contains(part), "{of}: {}", said.err);
    }
    let said = project.hvi(&["explain", "study.toml", "metal[set=copper-royce]"]);
    assert!(
        said.out.contains("metal[set=copper-royce], by eos.handbook: to run, it has no result yet"),
        "{}",
        said.out
    );
}

#[test]
fn plan_tells_machines_the_same() {
    let project = chain();
    let parsed = json(&project.hvi(&["plan", "study.toml", "--json"]).out);
    assert_eq!((parsed["run"].as_u64(), parsed["unknown"].as_u64()), (Some(1), Some(1)));
    assert_eq!(parsed["nodes"][1]["until"], "metal");
    project.run();
    let parsed = json(&project.hvi(&["plan", "study.toml", "--json", "--set", "metal.set=copper-paper-md"]).out);
    let change = &parsed["nodes"][0]["changes"][0];
    assert_eq!((change["field"].as_str(), change["old"].as_str()), (Some("params.set"), Some("copper-royce")));
}

/// A run that finds all in the store leaves no entry; a damaged entry is passed over.
#[test]
fn history_grows_with_what_is_new() {
    let project = chain();
    let entries = || project.files("store/runs/study").len();
    project.run();
    project.run();
    assert_eq!(entries(), 1);
    project.hvi(&["run", "study.toml", "--set", "metal.set=copper-paper-md"]);
    assert_eq!(entries(), 2);
    let (newest, _) = project.files("store/runs/study").pop().unwrap();
    std::fs::write(newest, "{").unwrap();
    let said = project.hvi(&["explain", "study.toml", "metal", "--set", "metal.set=aluminium-paper"]);
    assert!(said.out.contains("params.set: copper-royce -> aluminium-paper"), "{}", said.out);
}
