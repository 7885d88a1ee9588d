//! What makes no table: too few states, numbers that are not finite, volumes or temperatures out of order.
use super::{Node, Parameters};
use crate::EosError;

/// # Errors
/// The first fault, with its isochore.
pub(super) fn check(p: &Parameters) -> Result<(), EosError> {
    let wrong = |parameter, why| Err(EosError { name: "table", parameter, why });
    for (parameter, value) in
        [("reference_volume", p.reference_volume), ("reference_temperature", p.reference_temperature)]
    {
        if !(value > 0.0 && value.is_finite()) {
            return wrong(parameter, format!("is {value}, must be positive"));
        }
    }
    for (parameter, sheet, least) in [("solid", &p.solid, 4), ("liquid", &p.liquid, 2)] {
        if sheet.len() < least && !(parameter == "liquid" && sheet.is_empty()) {
            return wrong(parameter, format!("has {} isochores, needs {least} or more", sheet.len()));
        }
        for (i, isochore) in sheet.iter().enumerate() {
            let place = format!("isochore {} at {:e} m3/kg", i + 1, isochore.volume);
            let rises = i == 0 || isochore.volume > sheet[i - 1].volume;
            if !(isochore.volume > 0.0 && isochore.volume.is_finite() && rises) {
                return wrong(parameter, format!("{place}: volumes must be positive, finite and rise"));
            }
            if isochore.nodes.len() < 2 {
                return wrong(parameter, format!("{place}: has {} states, needs 2 or more", isochore.nodes.len()));
            }
            let finite = |n: &Node| {
                [n.temperature, n.energy, n.pressure, n.errors[0], n.errors[1]].iter().all(|x| x.is_finite())
            };
            if !isochore.nodes.iter().all(finite) {
                return wrong(parameter, format!("{place}: has a number that is not finite"));
            }
            let ordered = |w: &[Node]| w[1].temperature > w[0].temperature && w[1].energy > w[0].energy;
            if isochore.nodes[0].temperature < 0.0 || !isochore.nodes.windows(2).all(ordered) {
                return wrong(parameter, format!("{place}: temperature and energy must rise from state to state"));
            }
        }
    }
    Ok(())
}
