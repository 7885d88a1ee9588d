//! `region = "auto"` of a step: of its sweep only the states that the pipeline's scenes bring matter to.
//!
//! What a scene comes to is the stages' own estimate ([`hvi_kit::Stage::reach`]), made from its parameters before anything is computed;
//! it counts for the steps that the scene's equation of state is made from. Points that a reference selects stay, and where a scene
//! can't be estimated, or no point at all is called for, all do.
use crate::mistake::Mistake;
use crate::pipeline::Pipeline;
use crate::plan::{self, Input, NodeId, Plan};
use crate::reference::{self, Selection};
use hvi_kit::Reach;
use std::collections::{HashMap, HashSet};

/// What became of a step's sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The step.
    pub step: String,
    /// Points that stay.
    pub kept: usize,
    /// Points that were written.
    pub written: usize,
    /// Why.
    pub why: String,
}

impl Region {
    /// What was left out and why, in a sentence.
    pub fn sentence(&self) -> String {
        let Region { step, kept, written, why } = self;
        format!("{step}: region = \"auto\" leaves out {} of {written} points: {why}", written - kept)
    }
}

/// The pipeline with the points left out that no scene calls for, where steps ask for that.
///
/// # Errors
/// [`Mistake`] where the pipeline can't be planned, or `region` stands in a step that asks for no states of matter.
pub fn settled(mut pipeline: Pipeline) -> Result<Pipeline, Mistake> {
    if pipeline.steps.iter().all(|step| step.region.is_none()) {
        return Ok(pipeline);
    }
    let plan = plan::plan(&pipeline, &[])?;
    let scenes = Scenes::of(&plan);
    let named = named(&pipeline, &plan);
    for step in &mut pipeline.steps {
        let Some(at) = &step.region else { continue };
        let index = plan.steps.iter().position(|s| s.name == step.name).expect("all steps are planned");
        let nodes = plan.steps[index].nodes.clone();
        let written = nodes.len();
        let is_reached = |id: NodeId, reach: &Reach| (step.stage.is_reached)(&plan.nodes[id].params, reach);
        if nodes.clone().any(|id| is_reached(id, &Reach::default()).is_none()) {
            let title = format!("step `{}`: `{}` computes no state of matter", step.name, step.stage.name);
            return Err(Mistake::new(title).at(at, "nothing can be left out of it").help("leave out `region`"));
        }
        let why = match scenes.to(&plan, index) {
            Found::Nothing => "no scene comes after it".to_string(),
            Found::Anything(scene) => format!("no estimate can be made of {scene}"),
            Found::Reach(reach) => {
                let stays = |id: &NodeId| named.contains(id) || is_reached(*id, &reach) == Some(true);
                let kept: Vec<bool> = nodes.map(|id| stays(&id)).collect();
                let words = reach.words();
                if kept.contains(&true) {
                    let mut kept = kept.iter();
                    step.points.retain(|_| *kept.next().expect("a node a point"));
                    format!("scenes bring its matter to {words}")
                } else {
                    format!("none of them is called for, as scenes bring its matter to {words}: the step may go")
                }
            }
        };
        pipeline.regions.push(Region { step: step.name.clone(), kept: step.points.len(), written, why });
    }
    pipeline.remarks.extend(pipeline.regions.iter().map(Region::sentence));
    Ok(pipeline)
}

/// Nodes that a reference names by a selection, or that fill a port alone.
fn named(pipeline: &Pipeline, plan: &Plan) -> HashSet<NodeId> {
    let one = |input: &Input| match input {
        Input::One(id) => Some(*id),
        Input::Many(_) | Input::File(_) => None,
    };
    let mut all: HashSet<NodeId> = plan.nodes.iter().flat_map(|node| node.inputs.values().filter_map(one)).collect();
    let mut texts = Vec::new();
    let steps = pipeline.steps.iter().flat_map(|step| step.params.0.iter().chain(step.points.iter().flatten()));
    steps.chain(&pipeline.tradeoff.0).for_each(|(_, value)| plan::references(value, &mut texts));
    for (text, _) in texts {
        let selects = |text: &str| matches!(reference::parse(text).map(|r| r.selection), Ok(Selection::Where(_)));
        if selects(text.trim_start_matches('@')) {
            all.extend(reference::nodes(plan, &text).into_iter().flatten());
        }
    }
    all
}

/// What scenes bring the matter of a step to.
enum Found {
    /// None comes after it.
    Nothing,
    /// The scene of this label may bring it anywhere.
    Anything(String),
    Reach(Reach),
}

/// What each scene brings matter to, by the node that its equation of state comes from.
struct Scenes {
    found: Vec<(NodeId, NodeId, Option<Reach>)>,
    /// By step: the steps it is made from, itself included.
    made_from: Vec<HashSet<usize>>,
}

impl Scenes {
    fn of(plan: &Plan) -> Scenes {
        let index: HashMap<&str, usize> = plan.steps.iter().enumerate().map(|(i, s)| (s.name.as_str(), i)).collect();
        let mut made_from: Vec<HashSet<usize>> = Vec::new();
        for (i, step) in plan.steps.iter().enumerate() {
            let mut all = HashSet::from([i]);
            step.needs.iter().for_each(|name| all.extend(&made_from[index[name.as_str()]]));
            made_from.push(all);
        }
        let mut found = Vec::new();
        for (scene, node) in plan.nodes.iter().enumerate() {
            for (key, reach) in (node.stage.reach)(&node.params) {
                if let Some(Input::One(eos)) = node.inputs.get(&key) {
                    found.push((*eos, scene, reach));
                }
            }
        }
        Scenes { found, made_from }
    }

    /// What they bring the matter of step `index` to.
    fn to(&self, plan: &Plan, index: usize) -> Found {
        let mut all: Option<Reach> = None;
        for (eos, scene, reach) in &self.found {
            if !self.made_from[plan.nodes[*eos].step].contains(&index) {
                continue;
            }
            match reach {
                Some(reach) => all.get_or_insert_default().ways.extend(reach.ways.iter().cloned()),
                None => return Found::Anything(plan.label(*scene)),
            }
        }
        all.map_or(Found::Nothing, Found::Reach)
    }
}
