//! What makes the difference between the paper, its choices run here, and the best known: with the numbers of the results.
use crate::measured::Column;
use hvi_empirical::EtaLaw;
use hvi_eos::Eos;

/// The reason behind a quantity, in a sentence or two; empty where there is nothing to say.
pub fn why(id: &str, columns: &[Column<'_>; 2]) -> String {
    let [paper, best] = columns;
    match id {
        "V0" => "The paper's is its nominal lattice of 3.615 Å, where the states still have some 2 GPa; the best column's is that of \
                 zero pressure at 300 K."
            .into(),
        "C" | "S" => "The paper does not name its potential; C and S trade against each other (they correlate to −0.98), and the \
                      range of compression decides. Mishin's potential lies nearer to experiment (0.394 and 1.489)."
            .into(),
        "gamma0" | "a" => "γ0 and a correlate to 0.9: a fit to fewer or hotter states moves both along one line.".into(),
        "g_e" => "Classical molecular dynamics has no electrons: a fitted g_e is what the anharmonic heat leaves, not electronic heat \
                  (4.9e-7 by experiment)."
            .into(),
        "T_m" => melting(paper, best),
        "hugoniot_dense" | "hugoniot_mean" => "Compared at equal V/V0, each with its own V0. The potential's softness decides: of the \
                                               family of Cu_u3 it grows with compression."
            .into(),
        "sphere_molten" | "cylinder_molten" => "Phases at the volume of the intact matter: at a particle's own, numerically expanded \
                                                volume the melting temperature collapses, and cold fragments count as molten."
            .into(),
        "release_onset" => release(paper, best),
        "alpha" | "beta" | "gamma" => resolution(paper, best),
        "alpha_limit" | "beta_limit" | "gamma_limit" => {
            "By the best known at two resolutions, extrapolated to a vanishing cell. What is left below the speed from which release \
             melts is heat of the transfer and of artificial viscosity at the contact that has not gone yet."
                .into()
        }
        "eta_contact" | "eta_contact_slow" => {
            "Artificial viscosity overheats some three cells where bodies meet, at any resolution: its share of what melts goes with the              cells, and is set apart here. It is an upper bound: at high speed shocked matter at the contact melts by right."
                .into()
        }
        "eta_rms" | "eta_check_rms" => checked(paper, best),
        _ => String::new(),
    }
}

fn melting(paper: &Column<'_>, best: &Column<'_>) -> String {
    let points = |c: &Column<'_>| c.copper.and_then(|e| e.fit.as_ref()).map_or(0, |f| f.melting.len());
    let mut text = "A perfect crystal that is heated goes on as a solid beyond its melting point; eq 33 counts it as molten, which \
                    makes T_m a matter of how far the sweep overheats it and of the step in temperature."
        .to_string();
    if points(best) > 0 {
        text += &format!(" The best column takes it from {} cells with crystal and melt side by side.", points(best));
    }
    if points(paper) == 0
        && let Some(Eos::Gray(gray)) = paper.impacted.map(|e| &e.eos)
    {
        text += &format!(
            " Experiment: 1790 K; the paper's own column, which its impacts used: {} K.",
            gray.parameters().melting_temperature
        );
    }
    text
}

fn release(paper: &Column<'_>, best: &Column<'_>) -> String {
    let take = |c: &Column<'_>| crate::measured::take("release_onset", c).map(|f| f.value);
    match (take(paper), take(best)) {
        (Some(a), Some(b)) => format!(
            "Below {a:.2} km/s (the paper's copper) or {b:.2} km/s (the best) no shock of a symmetric impact is strong enough for its \
             release to melt anything: melt that a run shows at lower speed is heat at the contact that the method makes, not physics."
        ),
        _ => String::new(),
    }
}

/// What the grid has to do with the law's exponent, where all runs have the same cell.
fn resolution(paper: &Column<'_>, best: &Column<'_>) -> String {
    let across = |e: &EtaLaw| {
        let of = |pick: fn(f64, f64) -> f64, start| e.points.iter().map(|p| p.diameter / p.cell).fold(start, pick);
        (of(f64::min, f64::INFINITY), of(f64::max, 0.0))
    };
    let mut text = String::new();
    if let Some(eta) = paper.eta {
        let (few, many) = across(eta);
        text = format!(
            "With the same cells for all spheres the small ones have {few:.0} across and the large ones {many:.0}: heat at the contact \
             is a layer of a few cells, so its share falls as cells over diameter, which looks like a power of D/t near −0.7. That \
             speaks for the grid as the exponent's source; the same sweep at another size of cells would show it."
        );
    }
    if let Some(eta) = best.eta {
        let (few, many) = across(eta);
        text += &format!(" The best column has {few:.0} to {many:.0} cells across.");
    }
    text
}

fn checked(paper: &Column<'_>, best: &Column<'_>) -> String {
    let of = |name: &str, c: &Column<'_>| {
        c.eta.map(|e| format!("{name}: worst {:.2} of {} new runs", e.own.new.worst, e.own.new.runs))
    };
    let both: Vec<String> = [of("paper's choices", paper), of("best", best)].into_iter().flatten().collect();
    both.join("; ")
}
