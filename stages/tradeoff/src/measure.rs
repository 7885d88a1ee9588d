//! The quantities of a result that accuracy is asked of, and the work it took in units that no machine changes.
use crate::shock;
use hvi_eos::fit::FittedParameter;
use hvi_eos::survey::Survey;
use hvi_eos::{Eos, EosResult};
use hvi_impact::material::Material;
use hvi_impact::result::Impact;
use hvi_kit::{Artifact, Digest, LoadError, Store, load};
use hvi_md::State;

/// One quantity of one result.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// What it is.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Its statistical standard error, in its unit; 0 where it has none.
    pub noise: f64,
    /// What it would be without any error, where that is known.
    pub exact: Option<f64>,
    /// What errors are relative to; `None`: the limit itself.
    pub scale: Option<f64>,
    /// What they are relative to at least, where it is the limit.
    pub least: f64,
}

impl Measure {
    /// A quantity whose true value is not known.
    pub fn free(name: &'static str, unit: &'static str, value: f64) -> Measure {
        Measure { name, unit, value, noise: 0.0, exact: None, scale: None, least: 0.0 }
    }
    /// A quantity whose true value is known.
    pub fn exact(name: &'static str, unit: &'static str, value: f64, exact: f64) -> Measure {
        Measure { exact: Some(exact), ..Measure::free(name, unit, value) }
    }
    /// A quantity that is itself a relative deviation, and would be 0.
    pub fn deviation(name: &'static str, value: f64) -> Measure {
        Measure { exact: Some(0.0), scale: Some(1.0), ..Measure::free(name, "", value) }
    }
}

/// All quantities of one result.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// In a fixed order.
    pub all: Vec<Measure>,
    /// Units of work done.
    pub work: f64,
    /// What a unit is.
    pub unit: &'static str,
}

/// Why a result has no quantities.
#[derive(Debug)]
pub enum Unknown {
    /// Results of this kind are not known here.
    Kind,
    /// The result can't be read.
    Load(LoadError),
}

/// The quantities of the result `digest` of `kind`; `eos` is the metal's where it is not the material's own.
///
/// # Errors
/// [`Unknown`] where there are none for such results, or it can't be read.
pub fn of_kind(kind: &str, digest: Digest, store: &Store, eos: Option<&Eos>) -> Result<Measures, Unknown> {
    match kind {
        Impact::KIND => Ok(of_impact(&load(store, digest).map_err(Unknown::Load)?, eos)),
        EosResult::KIND => Ok(of_fit(&load(store, digest).map_err(Unknown::Load)?)),
        Survey::KIND => Ok(of_survey(&load(store, digest).map_err(Unknown::Load)?)),
        State::KIND => Ok(of_state(&load(store, digest).map_err(Unknown::Load)?)),
        _ => Err(Unknown::Kind),
    }
}

/// The quantities that results of `kind` can have; none of other kinds.
pub fn names(kind: &str) -> &'static [&'static str] {
    match kind {
        Impact::KIND => &[
            "melted share",
            "leading edge",
            "hole diameter",
            "debris momentum",
            "pressure behind the shock",
            "density behind the shock",
            "pressure profile",
            "energy drift",
        ],
        EosResult::KIND => &["C", "S", "gamma0", "melting temperature"],
        Survey::KIND => &["pressure", "temperature", "sound speed", "share of liquid"],
        State::KIND => &["pressure", "energy", "stated error of pressure", "stated error of energy"],
        _ => &[],
    }
}

/// Share of the impact speed beyond which matter of the plate is debris.
const FLYING: f64 = 0.1;

/// Of an impact at its end: on a line the shocked state, else what melts, flies and is left open.
///
/// The hole's diameter is that of the disc of plate with the mass of its debris: it has a value at any resolution, where a rim's
/// place depends on what is called the rim.
pub fn of_impact(run: &Impact, eos: Option<&Eos>) -> Measures {
    let (mut all, mut work) = (Vec::new(), 0.0);
    if let (Some(end), Some(last)) = (run.snapshots.last(), run.ledger.last()) {
        let p = &end.particles;
        work = p.mass.len() as f64 * last.step as f64;
        if run.diameter.is_finite() {
            let flies = |i: usize| f64::from(p.velocity[0][i]) > FLYING * run.velocity;
            let sum = |of: &dyn Fn(usize) -> f64| (0..p.mass.len()).map(of).sum::<f64>();
            let mass = |i: usize| f64::from(p.mass[i]);
            let all_mass = sum(&mass);
            let multiple = run.bodies.iter().map(|b| b.mass).sum::<f64>() / all_mass;
            let momentum = multiple * sum(&|i| if flies(i) { mass(i) * f64::from(p.velocity[0][i]) } else { 0.0 });
            let gone = multiple * sum(&|i| if flies(i) && p.body[i] == 1 { mass(i) } else { 0.0 });
            let area = run.bodies.get(1).map_or(f64::NAN, |plate| gone / (plate.density * run.thickness));
            if let Some(melt) = end.melt.first() {
                // Of a hundredth molten nobody asks a hundredth: below a tenth its error counts as one of a tenth.
                all.push(Measure { least: 0.1, ..Measure::free("melted share", "", melt.liquid) });
            }
            all.push(Measure::free("leading edge", "m/s", run.leading[1]));
            all.push(Measure::free("hole diameter", "mm", 2e3 * (area / std::f64::consts::PI).sqrt()));
            all.push(Measure::free("debris momentum", "N s", momentum));
        } else {
            let own = run.bodies.first().and_then(|b| Material::named(&b.material)).map(|m| m.eos);
            all.extend(eos.or(own.as_ref()).map(|eos| shock::planar(run, eos)).unwrap_or_default());
        }
        all.push(Measure::deviation("energy drift", last.drift));
    }
    Measures { all, work, unit: "particle-steps" }
}

/// Of a fitted equation of state: C, S, gamma0 and T_m, with their quoted errors.
pub fn of_fit(result: &EosResult) -> Measures {
    let names = [("C", "C", "cm/us"), ("S", "S", ""), ("gamma0", "gamma0", ""), ("T_m", "melting temperature", "K")];
    let fitted = result.fit.iter().flat_map(|fit| &fit.parameters);
    let measure = |p: &FittedParameter| {
        let (_, name, unit) = names.iter().find(|(symbol, ..)| *symbol == p.symbol)?;
        Some(Measure { noise: p.quoted_error(), ..Measure::free(name, unit, p.value) })
    };
    let states = result.fit.as_ref().map_or(0, |fit| fit.residuals.len());
    Measures { all: fitted.filter_map(measure).collect(), work: states as f64, unit: "states" }
}

/// Of an equation of state held against another: its largest errors.
pub fn of_survey(survey: &Survey) -> Measures {
    let all = vec![
        Measure::deviation("pressure", survey.pressure.largest),
        Measure::deviation("temperature", survey.temperature.largest),
        Measure::deviation("sound speed", survey.sound_speed.largest),
        Measure::deviation("share of liquid", survey.liquid.largest),
    ];
    Measures { all, work: survey.calls as f64, unit: "calls" }
}

/// Of a state of molecular dynamics: its averages, and the errors it states of them.
pub fn of_state(state: &State) -> Measures {
    let average = |name, unit, value: f64, noise: f64| Measure { noise, ..Measure::free(name, unit, value) };
    let stated = |name, unit, error: f64, of: f64| Measure {
        exact: Some(0.0),
        scale: Some(of.abs()),
        ..Measure::free(name, unit, error)
    };
    let (p, e) = (state.pressure / 1e9, state.energy / 1e3);
    let (dp, de) = (state.pressure_error / 1e9, state.energy_error / 1e3);
    let all = vec![
        average("pressure", "GPa", p, dp),
        average("energy", "kJ/kg", e, de),
        stated("stated error of pressure", "GPa", dp, p),
        stated("stated error of energy", "kJ/kg", de, e),
    ];
    Measures { all, work: f64::from(state.atoms) * state.steps as f64, unit: "atom-steps" }
}
