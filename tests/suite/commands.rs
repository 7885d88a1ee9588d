//! Every command beside `run`: what it says, and what it says of bad input.
use super::project::{Project, SLOW};
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
/// What is foretold by stage adds up, and packs onto cores: more of them are quicker, none beats the longest way.
#[test]
fn plan_packs_onto_the_cores_of_a_cluster() {
    let project = chain();
    let asked = ["plan", "study.toml", "--cores", "1,4", "--machine-cores", "2", "--figures", "figures"];
    let said = project.hvi(&asked);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("packed onto machines of 2 cores"), "{}", said.out);
    assert!(project.path("figures/study-on-4-cores.svg").exists() && project.files("store").is_empty());
    let parsed = json(&project.hvi(&[&asked[..], &["--json"]].concat()).out);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let stages: f64 = parsed["stages"].as_array().unwrap().iter().map(|s| number(&s["core_s"])).sum();
    assert!((stages / number(&parsed["cost_s"]) - 1.0).abs() < 1e-9);
    let [one, four] = &parsed["packings"].as_array().unwrap()[..] else { panic!("{parsed}") };
    // One core is never idle: it takes as long as the work is.
    assert!((number(&one["makespan_s"]) / stages - 1.0).abs() < 1e-9 && number(&one["utilisation"]) > 0.999);
    assert!(number(&four["makespan_s"]) <= number(&one["makespan_s"]));
    assert!(number(&four["makespan_s"]) >= number(&four["longest_way_s"]) * (1.0 - 1e-9));
    project.run();
    let parsed = json(&project.hvi(&[&asked[..], &["--json"]].concat()).out);
    assert_eq!(parsed["packings"][0]["makespan_s"], 0.0, "what is in the store takes no time");
    assert_eq!(project.hvi(&["plan", "study.toml", "--cores", "0"]).code, 2);
}

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

#[test]
fn status_shows_what_is_there_what_ran_and_what_failed() {
    let project = sweep();
    let said = project.hvi(&["status", "study.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("no run is on record") && said.out.contains("nothing is being computed"), "{}", said.out);
    assert!(!said.out.contains("-0"), "what took no time took 0.0 s: {}", said.out);
    assert!(project.files("store").is_empty(), "looking makes nothing");
    project.run();
    let said = project.hvi(&["status", "study.toml"]);
    assert!(said.out.contains("0 from the store, 3 computed"), "{}", said.out);
    assert!(said.out.contains("metal  eos.handbook       3             3"), "{}", said.out);
    let chain = chain();
    chain.write("empty.csv", "# source: none; status: a test\nup,Us,P_calc,flag\n");
    let said = chain.hvi(&["run", "study.toml", "--set", "shock.database=empty.csv"]);
    if said.code == 1 {
        let said = chain.hvi(&["status", "study.toml"]);
        assert!(said.out.contains("1 failed") && said.out.contains("failed: shock: "), "{}", said.out);
    } else {
        assert_eq!(said.code, 2, "an input file that can't be used is found by then: {}", said.err);
    }
}

/// A key that another process has claimed is at work, as long as that process lives.
#[test]
fn status_sees_what_another_run_computes() {
    let project = sweep();
    project.run();
    let parsed = json(&project.hvi(&["plan", "study.toml", "--json"]).out);
    let key = parsed["nodes"][1]["key"].as_str().unwrap().parse().unwrap();
    let claim = hvi_cache::Store::open(project.path("store")).unwrap().claim(key).unwrap();
    let said = project.hvi(&["status", "study.toml"]);
    assert!(said.out.contains("at work: metal[set=copper-paper-md]"), "{}", said.out);
    drop(claim);
    assert!(project.hvi(&["status", "study.toml"]).out.contains("nothing is being computed"));
}

#[test]
fn graphs_have_a_box_a_step_or_a_point() {
    let project = chain();
    let dot = project.hvi(&["graph", "study.toml"]).out;
    assert!(dot.starts_with("digraph \"study\" {") && dot.trim_end().ends_with('}'), "{dot}");
    assert!(dot.contains("n0 [label=\"metal\\neos.handbook\"];") && dot.contains("n0 -> n1;"), "{dot}");
    let project = sweep();
    assert!(project.hvi(&["graph", "study.toml"]).out.contains("3 points"));
    let mermaid = project.hvi(&["graph", "study.toml", "--nodes", "--format", "mermaid"]).out;
    assert!(mermaid.starts_with("flowchart LR") && mermaid.contains("n2[\"metal[set=aluminium-paper]"), "{mermaid}");
    assert_eq!(project.hvi(&["graph", "study.toml", "--format", "png"]).code, 2);
}

#[test]
fn diff_shows_parameters_and_results_side_by_side() {
    let project = chain();
    project.run();
    project.hvi(&["run", "study.toml", "--set", "metal.set=copper-paper-md"]);
    let said = project.hvi(&["diff", "study~1", "study"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("0 the same, 2 differ, 0 only in A, 0 only in B"), "{}", said.out);
    let words = |line: &str| line.split_whitespace().map(str::to_string).collect::<Vec<_>>();
    let rows: Vec<Vec<String>> = said.out.lines().map(words).collect();
    assert!(rows.contains(&words("params.set copper-royce copper-paper-md")), "{}", said.out);
    assert!(rows.iter().any(|r| r.last().is_some_and(|d| d.parse::<f64>().is_ok_and(|d| d != 0.0))), "{}", said.out);
    let said = project.hvi(&["diff", "study.toml", "out/study"]);
    assert!(said.out.contains("2 differ"), "the file as it is now, and the last results: {}", said.out);
    for (run, part) in [("stuby", "did you mean `study`?"), ("study~7", "not so many runs"), ("study~x", "NAME~COUNT")]
    {
        let said = project.hvi(&["diff", run, "study"]);
        assert_eq!(said.code, 2, "{run}");
        assert!(said.err.contains(part), "{run}: {}", said.err);
    }
}

#[test]
fn compare_is_a_table_over_the_points() {
    let project = sweep();
    let said = project.hvi(&["compare", "study.toml", "metal"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("hvi-flow run study.toml --only metal"), "{}", said.err);
    project.run();
    let said = project.hvi(&["compare", "study.toml", "metal"]);
    assert_eq!(said.out.lines().count(), 4, "{}", said.out);
    assert!(said.out.starts_with("set ") && said.out.contains("aluminium-paper"), "{}", said.out);
    let csv = project.hvi(&["compare", "study.toml", "metal[set=copper-royce]", "--csv"]).out;
    assert!(csv.lines().filter(|l| !l.starts_with('#')).count() == 2 && csv.contains("copper-royce,"), "{csv}");
    project.hvi(&["compare", "study.toml", "metal", "--csv", "table.csv"]);
    assert_eq!(
        std::fs::read(project.path("table.csv")).unwrap(),
        std::fs::read(project.path("out/study/metal.csv")).unwrap()
    );
    assert_eq!(project.hvi(&["compare", "study.toml", "metals"]).code, 2);
}

/// An impact's own numbers name its velocity: where the sweep sets it, it has one column.
#[test]
fn what_a_sweep_sets_is_one_column() {
    let impact = SLOW.replace("cells = 8\nend = \"3 us\"", "cells = 2\nend = \"0.1 us\"");
    let swept = impact.replace("velocity = \"2 km/s\"", "sweep = { velocity = [\"2 km/s\", \"2500 m/s\"] }");
    let project = Project::new(&swept.replace("2500 m/s", "2.5 km/s"));
    project.run();
    let head = |project: &Project| {
        project.hvi(&["compare", "study.toml", "slow", "--csv"]).out.lines().next().unwrap().to_string()
    };
    assert_eq!(head(&project).matches("velocity").count(), 1, "{}", head(&project));
    // Written in other units it is another column.
    project.write("study.toml", &swept);
    project.run();
    assert_eq!(head(&project).matches("velocity").count(), 2, "{}", head(&project));
}

#[test]
fn cache_counts_verifies_and_repairs() {
    let project = sweep();
    project.run();
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words(&project.hvi(&["cache", "stats"]).out).contains("results 3"));
    let said = project.hvi(&["cache", "verify"]);
    assert!(said.code == 0 && said.out.contains("3 records are whole, 0 are not"), "{}", said.out);
    let (object, mut bytes) = project.files("store/objects").pop().unwrap();
    bytes[9] ^= 1;
    std::fs::write(object, bytes).unwrap();
    let said = project.hvi(&["cache", "verify"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("moved aside to `damaged/"), "{}", said.err);
    let said = project.hvi(&["cache", "repair"]);
    assert!(said.out.contains("2 results in the index; 1 records without a result"), "{}{}", said.out, said.err);
    assert!(project.run().err.contains("2 from the store, 1 computed"));
}

/// What the pipelines of a folder need stays: all that their plans lead to, and the last results where a plan can't tell.
#[test]
fn gc_keeps_what_pipelines_need() {
    let project = chain();
    project.run();
    for set in ["metal.set=copper-paper-md", "shock.up_to=100 GPa"] {
        assert_eq!(project.hvi(&["run", "study.toml", "--set", set]).code, 0);
    }
    assert_eq!(project.files("store/results").len(), 5);
    std::fs::create_dir(project.path("kept")).unwrap();
    let text = std::fs::read_to_string(project.path("study.toml")).unwrap();
    project.write("kept/study.toml", &text);
    let said = project.hvi(&["cache", "gc", "--keep", "kept", "--dry-run"]);
    assert!(said.out.contains("2 keys are needed") && said.out.contains("3 results"), "{}", said.out);
    assert_eq!(project.files("store/results").len(), 5);
    assert_eq!(project.hvi(&["cache", "gc", "--keep", "kept"]).code, 0);
    assert_eq!(project.files("store/results").len(), 2);
    assert!(project.run().err.contains("2 from the store, 0 computed"));
    assert_eq!(project.hvi(&["cache", "gc", "--max-size", "1GB", "--older-than", "30d"]).code, 0);
    assert_eq!(project.files("store/results").len(), 2);
    assert_eq!(project.hvi(&["cache", "gc", "--max-size", "0B"]).code, 0);
    assert_eq!(project.files("store/results").len(), 0);
}

#[test]
fn gc_refuses_what_it_can_not_read() {
    let project = sweep();
    project.run();
    std::fs::create_dir(project.path("kept")).unwrap();
    for (arguments, part) in [
        (["--keep", "kept"], "there is no pipeline in it"),
        (["--keep", "absent"], "can't read it"),
        (["--max-size", "10"], "as in 8GB"),
        (["--older-than", "a month"], "as in 10min"),
    ] {
        let said = project.hvi(&["cache", "gc", arguments[0], arguments[1]]);
        assert_eq!(said.code, 2, "{arguments:?}");
        assert!(said.err.contains(part), "{arguments:?}: {}", said.err);
    }
    project.write("kept/broken.toml", "[step.a]\nuse = \"eos.handbok\"\n");
    assert_eq!(project.hvi(&["cache", "gc", "--keep", "kept"]).code, 2, "what a broken pipeline needs is not known");
    assert_eq!(project.files("store/results").len(), 3);
}

#[test]
fn init_writes_a_pipeline_that_runs() {
    let project = Project::new("");
    let said = project.hvi(&["init", "new/folder"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let run = || project.hvi(&["run", "new/folder/first.toml"]);
    let said = run();
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("4 computed"), "{}", said.err);
    assert!(run().err.contains("4 from the store, 0 computed"));
    let said = project.hvi(&["init", "new/folder"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("is there already"), "{}", said.err);
}

#[test]
fn shells_and_readers_get_help() {
    let project = Project::new("");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = project.hvi(&["completions", shell]);
        assert!(said.code == 0 && said.out.contains("explain"), "{shell}: {}", said.err);
    }
    assert!(project.hvi(&["man"]).out.contains(".TH hvi-flow 1"));
    assert!(project.hvi(&["man", "explain"]).out.contains("field by field"));
    let said = project.hvi(&["man", "explan"]);
    assert!(said.code == 2 && said.err.contains("did you mean `explain`?"), "{}", said.err);
    let said = project.hvi(&["statsu"]);
    assert!(said.code == 2 && said.err.contains("'status'"), "{}", said.err);
}

#[test]
fn the_reference_of_the_stages_is_current() {
    let project = Project::new("");
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/stages.md")).unwrap_or_default();
    let made = project.hvi(&["stages", "--markdown"]).out;
    assert!(made == page, "docs/stages.md is not current: hvi-flow stages --markdown > docs/stages.md");
    for stage in hvi_flow::registry::STAGES {
        assert!(made.contains(&format!("\n## {}\n", stage.name)));
        stage.ports.iter().for_each(|port| assert!(made.contains(&format!("| `{}` |", port.name)), "{}", port.name));
    }
}

/// The properties that RO-Crate 1.1 and the Process Run Crate profile 0.5 require, and that each result names its recipe,
/// code, host, compiler, time and cores.
#[test]
fn exported_results_say_where_they_come_from() {
    let project = sweep();
    let export = |to: &str| project.hvi(&["export", "study.toml", "metal", "--to", to]);
    assert_eq!(export("crate").code, 1, "nothing is there yet");
    project.run();
    let said = export("crate");
    assert_eq!(said.code, 0, "{}", said.err);
    let crate_of = |to: &str| json(&std::fs::read_to_string(project.path(to).join("ro-crate-metadata.json")).unwrap());
    let metadata = crate_of("crate");
    let graph = metadata["@graph"].as_array().unwrap();
    let entity = |id: &str| graph.iter().find(|e| e["@id"] == id).unwrap_or_else(|| panic!("no {id}"));
    let descriptor = entity("ro-crate-metadata.json");
    assert_eq!(descriptor["about"]["@id"], "./");
    assert_eq!(descriptor["conformsTo"][0]["@id"], "https://w3id.org/ro/crate/1.1");
    let root = entity("./");
    for property in ["name", "description", "datePublished", "license", "conformsTo", "hasPart", "mentions"] {
        assert!(!root[property].is_null(), "the root lacks {property}");
    }
    let mut ids: Vec<&str> = graph.iter().map(|e| e["@id"].as_str().unwrap()).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "every entity is there once");
    for part in root["hasPart"].as_array().unwrap() {
        let file = entity(part["@id"].as_str().unwrap());
        let path = project.path("crate").join(file["name"].as_str().unwrap());
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(file["contentSize"], bytes.len().to_string());
        assert_eq!(file["identifier"], format!("blake3:{}", hvi_cache::Digest::of(&bytes)));
    }
    let actions: Vec<_> = graph.iter().filter(|e| e["@type"] == "CreateAction").collect();
    assert_eq!(actions.len(), 3);
    for action in actions {
        let named = |key: &str| -> Vec<String> {
            let all = action[key].as_array().unwrap_or_else(|| panic!("{key}")).iter();
            all.map(|i| entity(i["@id"].as_str().unwrap())["name"].as_str().unwrap().to_string()).collect()
        };
        assert!(entity(action["instrument"]["@id"].as_str().unwrap())["version"].as_str().unwrap().contains("code "));
        assert!(named("object")[0].starts_with("recipes/") && named("object").contains(&"set".to_string()));
        assert!(named("result").len() >= 3, "{:?}", named("result"));
        assert_eq!(named("environment"), ["host", "compiler", "cores of the host", "threads used"]);
        assert_eq!(named("resourceUsage")[..2], ["wall time, s", "CPU time, s"]);
        assert!(action["startTime"].as_str() <= action["endTime"].as_str());
    }
    let said = export("crate");
    assert_eq!(said.code, 2, "never over what is there");
    assert!(said.err.contains("there are files in it"), "{}", said.err);
    assert_eq!(export("again").code, 0);
    assert_eq!(crate_of("again"), metadata, "the same results give the same crate");
}

/// Neither a link in the output folder nor an edited manifest leads a run out of it.
#[test]
fn paths_that_leave_the_output_folder_are_refused() {
    let project = sweep();
    std::fs::create_dir_all(project.path("out/study")).unwrap();
    std::fs::create_dir(project.path("elsewhere")).unwrap();
    std::os::unix::fs::symlink(project.path("elsewhere"), project.path("out/study/metal")).unwrap();
    let said = project.run();
    assert_eq!(said.code, 1);
    assert!(said.err.contains("leads out of"), "{}", said.err);
    assert!(project.files("elsewhere").is_empty());
    std::fs::remove_file(project.path("out/study/metal")).unwrap();
    assert_eq!(project.run().code, 0);
    project.write("precious", "mine");
    let manifest = std::fs::read_to_string(project.path("out/study/.manifest.json")).unwrap();
    let mut edited = json(&manifest);
    edited["files"]["../../precious"] = hvi_cache::Digest::of(b"mine").to_string().into();
    edited["study"] = "".into();
    project.write("out/study/.manifest.json", &edited.to_string());
    assert_eq!(project.run().code, 0);
    assert_eq!(std::fs::read_to_string(project.path("precious")).unwrap(), "mine");
}
