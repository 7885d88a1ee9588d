//! Which effects a scene calls for: decided before a step is taken, by closed-form estimates, each with its number.
//!
//! `effects/symmetry.rs` the dimension; `effects/estimate.rs` the states that the scene can reach; `effects/reach.rs` the same
//! before there is an equation of state; `effects/guard.rs` what watches, while a run goes on, the effects that were left off.
mod estimate;
mod guard;
mod reach;
mod symmetry;
use crate::params::{Params, SpaceChoice};
use crate::result::{Crossing, Decision};
use crate::scene::Layout;
use estimate::Estimate;
pub use estimate::impedance_match;
pub use guard::Watch;
use hvi_eos::Eos;
use hvi_kit::math;
pub use reach::reach;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Who decides what the keys of effects leave open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Choice {
    /// Estimates from the scene and its equations of state.
    Auto,
}

/// What a run does where an effect that was left off passes its threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Guard {
    /// It begins again with the effect on; the crossing is kept in the result.
    #[default]
    Rerun,
    /// It stops, and says so.
    Error,
}

/// An effect that can be left off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Effect {
    /// Shear stress.
    Strength,
    /// Softening of strength by heat, below melting.
    Softening,
    /// Dependence of strength on the rate of strain.
    Rate,
    /// Johnson-Cook damage.
    Damage,
    /// Tension cut-off with void opening.
    Spall,
    /// A velocity field of its own for the projectile, which may slide and part.
    Contact,
    /// Artificial heat conduction in shocks.
    Conduction,
    /// A plate wider than the waves reach.
    Width,
}

impl Effect {
    /// Its name: that of its key, but for contact and width.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Strength => "strength",
            Effect::Softening => "softening",
            Effect::Rate => "rate",
            Effect::Damage => "damage",
            Effect::Spall => "spall",
            Effect::Contact => "contact",
            Effect::Conduction => "conduction",
            Effect::Width => "width",
        }
    }

    /// The number from which it is on, in a plan and for the guard alike where both have it.
    pub fn threshold(self) -> f64 {
        match self {
            Effect::Strength => 2e-3,
            Effect::Softening | Effect::Rate => 0.02,
            Effect::Damage => 0.1,
            Effect::Spall => 0.5,
            Effect::Contact => 1e-3,
            Effect::Conduction => 0.5,
            Effect::Width => 0.01,
        }
    }
}

/// Coefficient of friction where the plan turns contact on: that of metals sliding fast on each other is .1 to .3.
pub const FRICTION: f64 = 0.2;

/// A scene as it is to be run, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The parameters with everything decided.
    pub params: Params,
    /// One line a decision.
    pub decisions: Vec<Decision>,
    /// What the plan, not the user, left off.
    pub off: Vec<Effect>,
}

impl Params {
    /// Whether estimates decide what is left open.
    pub fn is_auto(&self) -> bool {
        self.effects == Some(Choice::Auto)
    }

    /// The same scene with every effect on, in a quarter of three dimensions, or all that its symmetry asks for: on the same cells
    /// and plate, to the same end. What `effects = "auto"` is measured by.
    pub fn everything_on(&self) -> Params {
        let layout = Layout::of(&self.settled());
        let mut params = self.clone();
        let space = symmetry::of(self).0;
        params.space = Some(if space == SpaceChoice::Axisymmetric { SpaceChoice::Quarter } else { space });
        if space != SpaceChoice::Line {
            params.plate.width = Some(hvi_kit::units::Length::new(layout.width));
        }
        params.end = Some(hvi_kit::units::Time::new(layout.end));
        (params.strength, params.rate, params.softening) = (Some(true), Some(true), Some(true));
        (params.damage, params.spall, params.conduction) = (None, None, None);
        params.friction = self.friction.or(Some(FRICTION));
        params.effects = None;
        params
    }

    /// The parameters with the dimension decided: it follows from the scene's symmetry alone.
    pub fn settled(&self) -> Params {
        let mut params = self.clone();
        if self.is_auto() && self.space.is_none() {
            params.space = Some(symmetry::of(self).0);
        }
        params
    }
}

/// Decides what `params` leave open; `eos` by body. Without `effects = "auto"` nothing is.
pub fn plan(params: &Params, eos: &[Eos]) -> Plan {
    let mut plan = Plan { params: params.settled(), decisions: Vec::new(), off: Vec::new() };
    if !params.is_auto() {
        return plan;
    }
    let (space, why) = symmetry::of(params);
    let angle = params.tilt().to_degrees();
    plan.decide(
        "dimension",
        name(params.space.unwrap_or(space)),
        params.space.is_some(),
        ("angle to the normal", angle, 0.0, "deg"),
        &why,
    );
    let found = Estimate::of(&plan.params, eos);
    plan.strength(params, &found);
    plan.separation(params, &found);
    plan.heat(params, &found);
    plan.extent(params);
    plan
}

fn name(space: SpaceChoice) -> &'static str {
    match space {
        SpaceChoice::Line => "line",
        SpaceChoice::Axisymmetric => "axisymmetric",
        SpaceChoice::Quarter => "quarter",
        SpaceChoice::Half => "half",
        SpaceChoice::Full => "full",
    }
}

impl Plan {
    fn decide(&mut self, effect: &str, choice: &str, by_hand: bool, number: (&str, f64, f64, &str), source: &str) {
        let (what, number, threshold, unit) = number;
        let source = if by_hand { format!("set by hand; {source}") } else { source.to_string() };
        self.decisions.push(Decision {
            effect: effect.into(),
            choice: choice.into(),
            what: what.into(),
            number,
            threshold,
            unit: unit.into(),
            source,
        });
    }

    /// Decides an effect by its number; one that can't be estimated is on. `set` is what the user wrote.
    fn switch(&mut self, effect: Effect, set: Option<bool>, what: &str, number: f64, source: &str) -> bool {
        let on = set.unwrap_or(!(number <= effect.threshold()));
        if !on && set.is_none() {
            self.off.push(effect);
        }
        let choice = if on { "on" } else { "off" };
        self.decide(effect.name(), choice, set.is_some(), (what, number, effect.threshold(), ""), source);
        on
    }

    /// Strength, and what it depends on.
    fn strength(&mut self, params: &Params, found: &Estimate) {
        let source = "(A + B) / (rho v^2 / 2): what it takes to deform a volume by 1 over the kinetic energy in it; largest of the bodies";
        let on = self.switch(
            Effect::Strength,
            params.strength,
            "work of strength over kinetic energy",
            found.strength,
            source,
        );
        self.params.strength = Some(on);
        if !on {
            return;
        }
        let source = "T*^m at the residual temperature after release from the impedance match, or heated by a plastic strain of 1";
        self.params.softening = Some(self.switch(
            Effect::Softening,
            params.softening,
            "share of strength lost to heat",
            found.softening,
            source,
        ));
        let source = "C ln((v / cell) / rate0), the highest rate that the grid can show";
        self.params.rate =
            Some(self.switch(Effect::Rate, params.rate, "share of strength due to rate", found.rate, source));
        if found.damage.is_finite() {
            let source = "strain of the shock, or of a displacement v t of the smallest size (at most 1), over the fracture strain in simple tension";
            let on = self.switch(Effect::Damage, params.damage, "damage by the strain expected", found.damage, source);
            self.params.damage = Some(on);
        }
    }

    /// What lets matter part: spall, and contact.
    fn separation(&mut self, params: &Params, found: &Estimate) {
        let tension = found.pressure / found.spall;
        if found.spall.is_finite() {
            let source =
                "pressure of the impedance match, which release can turn into tension, over the spall strength";
            self.params.spall =
                Some(self.switch(Effect::Spall, params.spall, "tension over spall strength", tension, source));
        }
        // Bodies that stick pass on tension up to the spall strength, and slide only as their matter shears.
        let (what, number) = if params.tilt() > 0.0 {
            ("tangential over normal velocity", math::sin(params.tilt()) / math::cos(params.tilt()))
        } else {
            ("spall strength over pressure", 1.0 / tension)
        };
        let set = params.friction.map(|_| true);
        let source =
            "impedance match: where the pressure is below the spall strength bodies part whole; oblique ones slide";
        if self.switch(Effect::Contact, set, what, number, source) && set.is_none() {
            self.params.friction = Some(FRICTION);
        }
    }

    fn heat(&mut self, params: &Params, found: &Estimate) {
        let source = "release from the impedance match: below half the melting temperature the heat that viscosity leaves at a contact melts nothing";
        let set = params.conduction.map(|k| k > 0.0);
        let on = self.switch(Effect::Conduction, set, "residual over melting temperature", found.melting, source);
        if set.is_none() {
            self.params.conduction = Some(if on { self.params.conduction() } else { 0.0 });
        }
    }

    fn extent(&mut self, params: &Params) {
        let layout = Layout::of(&self.params);
        if self.params.space() != SpaceChoice::Line {
            let sound = params.plate.material.sound_speed(&params.plate.material.eos);
            let reach = 1.5 * layout.diameter + 1.1 * sound * layout.end;
            let source = "1.5 D + 1.1 c T: no wave is back from the rim by the end";
            let choice = format!("{:.4} mm", layout.width * 1e3);
            self.decide(
                "plate width",
                &choice,
                params.plate.width.is_some(),
                ("reach of waves", reach * 1e3, layout.width * 1e3, "mm"),
                source,
            );
            if params.plate.width.is_none() {
                self.off.push(Effect::Width);
                self.params.plate.width = Some(hvi_kit::units::Length::new(layout.width));
            }
        }
        let source = "three passages of projectile and plates at the speed normal to them; with one plate at most eight of a sound wave";
        let choice = format!("{:.4} us", layout.end * 1e6);
        self.decide("end", &choice, params.end.is_some(), ("end", layout.end * 1e6, layout.end * 1e6, "us"), source);
        self.params.end = Some(hvi_kit::units::Time::new(layout.end));
    }

    /// The plan after an effect has crossed its threshold: with it on.
    pub fn after(mut self, crossing: &Crossing) -> Plan {
        let effect = crossing.effect;
        self.off.retain(|&e| e != effect);
        let p = &mut self.params;
        match effect {
            Effect::Strength => (p.strength, p.softening, p.rate, p.damage) = (Some(true), None, None, None),
            Effect::Softening => p.softening = Some(true),
            Effect::Rate => p.rate = Some(true),
            Effect::Damage => p.damage = Some(true),
            Effect::Spall => p.spall = Some(true),
            Effect::Contact => p.friction = Some(FRICTION),
            Effect::Conduction => p.conduction = None,
            Effect::Width => {
                let wider = 1.5 * p.plate.width.map_or(0.0, |w| w.si());
                p.plate.width = Some(hvi_kit::units::Length::new(wider));
                // The wider plate is watched too.
                self.off.push(Effect::Width);
            }
        }
        self
    }
}
