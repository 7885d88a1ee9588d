//! The notes: what was fitted to what, how well, at which resolution, and what that is worth.
use crate::eta::{EtaLaw, Full, Zeros};
use crate::law::Law;
use crate::point::{Point, close, tidy};
use crate::refined::Refined;
use crate::score::{Score, Scores, Standing, standing};

/// A range of numbers, as `6.0` or `6.0 to 30.2`.
pub fn span(points: &[Point], of: impl Fn(&Point) -> f64) -> String {
    let (low, high) = points.iter().map(of).fold((f64::MAX, 0f64), |(a, b), x| (a.min(x), b.max(x)));
    if high - low < 0.05 { format!("{low:.1}") } else { format!("{low:.1} to {high:.1}") }
}

/// The note of the parameters.
pub fn method(r: &EtaLaw) -> String {
    let count = |keep: fn(&Point) -> bool| r.points.iter().filter(|p| keep(p)).count();
    let zeros = match r.zeros {
        Zeros::Keep => "count like any other",
        Zeros::Drop => "are left out",
    };
    let full = match r.full {
        Full::Limit => "count in the fit as exact where the law is above them",
        Full::Keep => "count like any other",
        Full::Drop => "are left out",
    };
    let parts = [
        format!(
            "η = (α v² + β v)(D/t)^γ, v in km/s, by unweighted least squares (Levenberg-Marquardt). η is the {}. {} runs with \
             η = 0 {zeros}; {} with η of 0.999 or more {full} (by that rule the fit's rms is {:.3}).",
            r.measure.describe(),
            count(|p| p.eta == 0.0),
            count(Point::is_full),
            r.counted.rms
        ),
        meaning(r),
        errors(r),
        format!("Raw deviations, the law not cut at 1: {}.", scores(&r.own)),
        checks(r),
        excess(r),
        format!(
            "The paper's law: {}. Its values were fitted to other runs, at a resolution it does not state: agreement with Table 4 \
             is not the aim.",
            scores(&r.paper)
        ),
    ];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// What the law means, and what it does not.
fn meaning(r: &EtaLaw) -> String {
    let known = match &r.refined {
        None => " Only runs of another resolution can tell how much of it: give them as `finer`.".to_string(),
        Some(Refined { limit: Ok(limit), .. }) => {
            let law = &limit.fit.law;
            let onset = if law.alpha > 0.0 && law.beta < 0.0 {
                format!(", and the law is above 0 from {:.2} km/s on", -law.beta / law.alpha)
            } else {
                String::new()
            };
            format!(
                " Extrapolated to a vanishing cell ({} pairs of runs, rms {:.3}), γ is {:.3} instead of {:.3}{onset}.",
                limit.pairs, limit.rms, law.gamma, r.fit.law.gamma
            )
        }
        Some(Refined { limit: Err(why), .. }) => {
            format!(" The fractions extrapolated to a vanishing cell don't determine a law: {why}.")
        }
    };
    format!(
        "{} Numerical heat, most of it of the transfer between particles and grid, melts a share of the projectile that falls with N_D. Below the \
         speed at which the projectile's matter melts on release that is all of η, and the limit for small cells is 0. At fixed N, \
         N_D grows with D/t once D is above t: γ at fixed N mostly mirrors N_D, not physics.{known}",
        resolution(&r.points)
    )
}

/// At which resolution the fractions are meant.
pub fn resolution(points: &[Point]) -> String {
    format!(
        "The law is meant at N = {} cells through the thinner of plate and projectile, that is N_D = {} across the projectile.",
        span(points, |p| p.cells),
        span(points, Point::across)
    )
}

fn errors(r: &EtaLaw) -> String {
    match r.spread {
        Some(s) => format!(
            "± is the standard deviation, and 95 % the range, of laws fitted to whole families of D/t drawn with replacement: runs of \
             one D/t lie to the same side of the law. With {} families it is rough itself. The error by covariance takes the runs \
             for independent, which they are not.",
            s.families
        ),
        None => "± is one standard error by the covariance, which takes the runs for independent, and so is too small where runs \
                 of one D/t lie to the same side of the law; no bootstrap of whole families of D/t could be had (it needs 3)."
            .into(),
    }
}

fn say(s: &Score) -> String {
    format!("rms {:.3}, worst {:.3}", s.rms, s.worst)
}

/// Every kind of run that there is, with its count.
pub fn scores(s: &Scores) -> String {
    let mut parts = vec![format!("{} on {} runs fitted", say(&s.fitted), s.fitted.runs)];
    if s.new.runs > 0 {
        parts.push(format!("{} on {} new check runs", say(&s.new), s.new.runs));
    }
    if s.outside.runs > 0 {
        parts.push(format!(
            "of these {} on {} beyond the fitted range of speed or D/t",
            say(&s.outside),
            s.outside.runs
        ));
    }
    if s.repeats.runs > 0 {
        parts.push(format!("{} on {} repeats", say(&s.repeats), s.repeats.runs));
    }
    parts.join("; ")
}

/// What the check runs can say.
fn checks(r: &EtaLaw) -> String {
    let of = |keep: fn(Standing) -> bool| {
        let mut ratios: Vec<f64> = r.check.iter().filter(|p| keep(standing(p, &r.points))).map(Point::ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.dedup_by(|a, b| close(*a, *b));
        ratios.iter().map(|&x| tidy(x).to_string()).collect::<Vec<_>>().join(", ")
    };
    let mut parts = Vec::new();
    if r.own.new.runs > 0 {
        parts.push(format!("New check runs have D/t = {}.", of(|s| s != Standing::Repeat)));
    }
    if r.own.repeats.runs > 0 {
        parts.push(format!(
            "Repeats (D/t = {}) have the v, D/t and N of a fitted run: the scene has no length of its own, so they are that run at \
             another scale, and check nothing.",
            of(|s| s == Standing::Repeat)
        ));
    }
    parts.join(" ")
}

/// Where the law passes 1.
fn excess(r: &EtaLaw) -> String {
    let mut tops: Vec<(f64, f64)> = Vec::new();
    for p in r.points.iter().chain(&r.check) {
        match tops.iter_mut().find(|(ratio, _)| close(*ratio, p.ratio())) {
            Some((_, top)) => *top = top.max(p.velocity * 1e-3),
            None => tops.push((p.ratio(), p.velocity * 1e-3)),
        }
    }
    tops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let over = |law: &Law, (ratio, top): &(f64, f64)| law.full_from(*ratio).filter(|v| v < top).map(|v| (*ratio, v));
    let over: Vec<String> = tops
        .iter()
        .filter_map(|at| over(&r.fit.law, at))
        .map(|(ratio, v)| format!("from {v:.2} km/s at D/t = {}", tidy(ratio)))
        .collect();
    if over.is_empty() {
        return "Within the runs' speeds the law stays below 1.".into();
    }
    format!("Within the runs' speeds the law exceeds 1, where it means no more than \"all\": {}.", over.join(", "))
}

/// The note of the extrapolation.
pub fn extrapolation(r: &Refined) -> String {
    let beyond = r.pairs.iter().filter(|p| !(0.0..=1.0).contains(&p.limit())).count();
    let full = r.pairs.iter().filter(|p| p.coarse.is_full()).count();
    let full = match full {
        0 => String::new(),
        n => format!(
            " In {n} of them all has melted at the coarse resolution: there the extrapolation is an upper bound."
        ),
    };
    let law = match &r.limit {
        Ok(_) => String::new(),
        Err(why) => format!(" They don't determine eq 35: {why}."),
    };
    format!(
        "N: cells through the thinner of plate and projectile; N_D: across the projectile. Extrapolated to N → ∞ as if the error \
         went as 1/N, η₀ = η_fine + (η_fine − η_coarse)/(h_coarse/h_fine − 1) with the cell sizes h; ± is how far that is from \
         η_fine. Two resolutions can't show that the error does go as 1/N, and \
         no error of the extrapolated law's parameters holds this ±. {beyond} of {} lie outside 0..1: shown as they are, \
         clipped to it for the fit alone.{full}{law}",
        r.pairs.len()
    )
}
