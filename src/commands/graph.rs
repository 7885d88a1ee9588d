//! `graph`: the steps of a pipeline and what they take from each other, as DOT or Mermaid.
use super::{Done, StudyArgs};
use crate::console::say;
use crate::plan::Plan;
use std::collections::BTreeSet;
use std::process::ExitCode;

/// What `graph` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    study: StudyArgs,
    /// In which language
    #[arg(long, value_enum, default_value = "dot")]
    format: Format,
    /// A box a point, instead of one a step
    #[arg(long)]
    nodes: bool,
}

/// A language of graphs.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// Graphviz: hvi-flow graph study.toml | dot -Tsvg
    Dot,
    /// Mermaid, as GitHub draws it
    Mermaid,
}

/// Prints the graph.
///
/// # Errors
/// [`super::Stop`] where the pipeline is wrong.
pub fn run(args: &Args) -> Done {
    let (pipeline, plan) = args.study.read(&[])?;
    let (boxes, arrows) = if args.nodes { points(&plan) } else { steps(&plan) };
    match args.format {
        Format::Dot => {
            let plain = |text: &str| text.replace('\\', "\\\\").replace('"', "\\\"");
            say(format_args!("digraph \"{}\" {{\n  rankdir=LR;\n  node [shape=box];", plain(&pipeline.name)));
            for (i, lines) in boxes.iter().enumerate() {
                let lines: Vec<_> = lines.iter().map(|l| plain(l)).collect();
                say(format_args!("  n{i} [label=\"{}\"];", lines.join("\\n")));
            }
            arrows.iter().for_each(|(from, to)| say(format_args!("  n{from} -> n{to};")));
            say(format_args!("}}"));
        }
        Format::Mermaid => {
            let plain = |text: &str| text.replace('&', "#amp;").replace('"', "#quot;").replace('<', "#lt;");
            say(format_args!("flowchart LR"));
            for (i, lines) in boxes.iter().enumerate() {
                let lines: Vec<_> = lines.iter().map(|l| plain(l)).collect();
                say(format_args!("  n{i}[\"{}\"]", lines.join("<br/>")));
            }
            arrows.iter().for_each(|(from, to)| say(format_args!("  n{from} --> n{to}")));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Lines of each box, and from which box to which an arrow goes.
type Graph = (Vec<Vec<String>>, Vec<(usize, usize)>);

fn steps(plan: &Plan) -> Graph {
    let lines = plan.steps.iter().map(|step| {
        let mut lines = vec![step.name.clone(), step.stage.name.to_string()];
        if step.nodes.len() > 1 {
            lines.push(format!("{} points", step.nodes.len()));
        }
        lines
    });
    let index = |name: &String| plan.steps.iter().position(|s| s.name == *name);
    let into = |(to, step)| -> Vec<(usize, usize)> {
        let step: &crate::plan::PlannedStep = step;
        step.needs.iter().filter_map(|name| Some((index(name)?, to))).collect()
    };
    (lines.collect(), plan.steps.iter().enumerate().flat_map(into).collect())
}

fn points(plan: &Plan) -> Graph {
    let lines = (0..plan.nodes.len()).map(|id| vec![plan.label(id), plan.nodes[id].stage.name.to_string()]);
    let into = |id| plan.needs(id).collect::<BTreeSet<_>>().into_iter().map(move |need| (need, id));
    (lines.collect(), (0..plan.nodes.len()).flat_map(into).collect())
}
