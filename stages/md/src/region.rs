//! Which states and melting points the scenes of a pipeline call for: those that shocks and releases come to, and a margin.
//!
//! The scenes' ways are estimates by a handbook's equation of state, made before there is one of the potential's: volumes on a
//! shock differ by a hundredth or two between the two, temperatures by a tenth (the potential's Hugoniot stands some 6 % off in
//! pressure). Colder states at the same volume stay: repeated shocks and slower flow come to them, and the cold curve is fitted to
//! them.
use crate::coexistence;
use crate::params::Params;
use hvi_kit::Reach;

/// In volume over that at rest: states this far beyond those reached bound them from outside.
const VOLUME: f64 = 0.03;
/// In temperature, as a factor and on top [K]: a sweep's steps of a few hundred kelvin still have one beyond.
const TEMPERATURE: (f64, f64) = (1.2, 300.0);
/// In pressure, as a factor and on top [Pa].
const PRESSURE: (f64, f64) = (1.1, 2e9);
/// A fit needs the neighbourhood of rest whatever scenes do, solid and molten: volumes from this on, up to the temperature [K] at
/// which all face-centred metals are well molten (platinum at 2041 K), and the melting point without pressure.
const ANCHOR: (f64, f64) = (0.85, 3000.0);
/// Matter this far below melting may still melt by what the estimate leaves out: strength, jetting, a second shock.
const HOMOLOGOUS: f64 = 0.8;

fn beyond((factor, more): (f64, f64), value: f64) -> f64 {
    factor * value + more
}

/// Whether the state is needed.
pub fn needs_state(params: &Params, reach: &Reach) -> bool {
    let temperature = params.temperature.si();
    match &params.pressed {
        // The volume is not known yet, the pressure is, and with it no more than the hottest of all.
        Some(pressed) => {
            pressed.rise.si() <= beyond(PRESSURE, reach.highest_pressure())
                && temperature <= beyond(TEMPERATURE, reach.highest_temperature())
        }
        None => {
            let ratio = params.volume_ratio;
            // For the fit, not for the scenes.
            let is_anchor = ratio >= ANCHOR.0 && temperature <= ANCHOR.1;
            is_anchor
                || (ratio >= reach.volume_ratios()[0] - VOLUME
                    && temperature <= beyond(TEMPERATURE, reach.hottest(ratio)))
        }
    }
}

/// Whether the melting point is needed: matter comes near melting at its pressure or a higher one, or it is the one without pressure.
pub fn needs_melting(params: &coexistence::Params, reach: &Reach) -> bool {
    let highest = reach.melting_pressure(HOMOLOGOUS).unwrap_or(0.0);
    params.pressure.si() <= beyond(PRESSURE, highest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hvi_kit::Reached;
    use serde_json::json;

    /// To 0.7 V0, 2500 K and 140 GPa, and back to 1.06 V0 at 1300 K, where copper about melts.
    fn reach() -> Reach {
        let state = |volume_ratio, temperature, pressure, homologous| Reached {
            volume_ratio,
            temperature,
            pressure,
            homologous,
        };
        let shock = state(0.7, 2500.0, 1.4e11, 0.6);
        Reach { ways: vec![vec![state(1.0, 300.0, 0.0, 0.2), shock, state(1.06, 1300.0, 0.0, 0.97)]] }
    }

    fn state(more: serde_json::Value) -> bool {
        let mut written = json!({ "potential": "mishin-2001", "volume_ratio": 1.0, "temperature": "300 K" });
        written.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        needs_state(&serde_json::from_value(written).unwrap(), &reach())
    }

    #[test]
    fn states_of_scenes_stay_and_those_beyond_go() {
        for (volume_ratio, temperature, stays) in [
            (1.06, 300.0, true),
            (0.7, 2500.0, true),
            (0.7, 3200.0, true),  // within the margin of 1.2 * 2500 + 300 K
            (0.7, 3400.0, false), // beyond
            (0.68, 300.0, true),
            (0.66, 300.0, false), // .7 - .03 is the least
            (0.85, 300.0, true),
            (1.06, 2900.0, true), // molten at rest: a fit needs it
            (1.06, 3100.0, false),
        ] {
            let is = state(json!({ "volume_ratio": volume_ratio, "temperature": format!("{temperature} K") }));
            assert_eq!(is, stays, "{volume_ratio} {temperature}");
        }
        let pressed = |rise: f64, temperature: f64| {
            state(json!({ "pressed": { "rise": format!("{rise} Pa") }, "temperature": format!("{temperature} K") }))
        };
        assert!(pressed(1.5e11, 3000.0) && !pressed(1.6e11, 3000.0) && !pressed(1e11, 3400.0));
    }

    #[test]
    fn melting_points_are_needed_where_matter_comes_near_melting() {
        let melting = |pressure: f64, reach: &Reach| {
            let written = json!({ "potential": "mishin-2001", "pressure": format!("{pressure} Pa") });
            needs_melting(&serde_json::from_value(written).unwrap(), reach)
        };
        // On release alone, at no pressure: 2 GPa are the margin.
        assert!(melting(0.0, &reach()) && !melting(2e10, &reach()));
        let mut cold = reach();
        cold.ways[0][2].homologous = 0.5;
        assert!(melting(0.0, &cold) && !melting(5e9, &cold), "the one without pressure stays");
        let mut hot = reach();
        hot.ways[0][1].homologous = 1.1;
        assert!(melting(1.5e11, &hot) && !melting(2e11, &hot));
    }
}
