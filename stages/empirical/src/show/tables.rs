//! Tables of the law, of its resolutions and of its runs.
use super::words;
use crate::eta::EtaLaw;
use crate::law::TABLE_4;
use crate::point::{Point, tidy};
use crate::refined::{Pair, Refined};
use hvi_impact::result::PHASES;
use hvi_kit::view::{Cell, Table};

fn columns<const N: usize>(names: [(&str, &str); N]) -> Vec<(String, String)> {
    names.map(|(name, unit)| (name.to_string(), unit.to_string())).to_vec()
}

/// Table 4: the parameters at the stated resolution, extrapolated, and the paper's.
pub fn parameters(r: &EtaLaw) -> Table {
    let limit = r.refined.as_ref().and_then(|refined| refined.limit.as_ref().ok());
    let fitted = format!("fitted at N = {}", words::span(&r.points, |p| p.cells));
    let mut head = columns([
        ("parameter", ""),
        ("unit", ""),
        (&fitted, ""),
        ("error by covariance", ""),
        ("95 % from", ""),
        ("95 % to", ""),
    ]);
    if limit.is_some() {
        head.extend(columns([("extrapolated to N → ∞", ""), ("its error by covariance", "")]));
    }
    head.extend(columns([("paper's Table 4", "")]));
    let row = |(i, (name, unit)): (usize, (&str, &str))| {
        let edge = |k: usize| r.spread.map_or(Cell::Empty, |s| s.range[k].values()[i].into());
        let mut row = vec![
            name.into(),
            unit.into(),
            Cell::Uncertain(r.fit.law.values()[i], r.error().values()[i]),
            r.fit.error.values()[i].into(),
            edge(0),
            edge(1),
        ];
        if let Some(l) = limit {
            let error = l.spread.map_or(l.fit.error, |s| s.error);
            row.push(Cell::Uncertain(l.fit.law.values()[i], error.values()[i]));
            row.push(l.fit.error.values()[i].into());
        }
        row.push(TABLE_4.values()[i].into());
        row
    };
    Table {
        title: "Melted fraction: parameters of eq 35".into(),
        columns: head,
        rows: [("α", "s²/km²"), ("β", "s/km"), ("γ", "")].into_iter().enumerate().map(row).collect(),
        note: words::method(r),
    }
}

/// Each pair of resolutions and what it is extrapolated to.
pub fn resolutions(r: &Refined) -> Table {
    let row = |p: &Pair| {
        let place = [p.fine.velocity * 1e-3, p.fine.ratio(), p.fine.diameter * 1e3];
        let cells = [p.coarse.cells, p.coarse.across(), p.fine.cells, p.fine.across()];
        let etas = [p.coarse.eta, p.coarse.contact, p.fine.eta, p.fine.contact];
        let numbers = place.iter().chain(&cells).chain(&etas);
        numbers.map(|&x| tidy(x).into()).chain([Cell::Uncertain(tidy(p.limit()), tidy(p.uncertainty()))]).collect()
    };
    Table {
        title: "Melted fraction at two resolutions".into(),
        columns: columns([
            ("v", "km/s"),
            ("D/t", ""),
            ("D", "mm"),
            ("N coarse", "cells"),
            ("N_D coarse", "cells"),
            ("N fine", "cells"),
            ("N_D fine", "cells"),
            ("η coarse", ""),
            ("of it at the contact, coarse", ""),
            ("η fine", ""),
            ("of it at the contact, fine", ""),
            ("η extrapolated", ""),
        ]),
        rows: r.pairs.iter().map(row).collect(),
        note: words::extrapolation(r),
    }
}

/// All that the law knows of some runs.
pub fn runs(r: &EtaLaw, points: &[Point], title: &str, role: impl Fn(&Point) -> &'static str) -> Table {
    let mut head = columns([
        ("v", "km/s"),
        ("D", "mm"),
        ("t", "mm"),
        ("D/t", ""),
        ("cells through", ""),
        ("cells across the projectile", ""),
        ("time", "µs"),
    ]);
    for body in ["projectile", "plate"] {
        head.extend(PHASES.iter().map(|phase| (format!("{body}: {phase}"), String::new())));
    }
    head.extend(columns([("η", ""), ("of it at the contact", ""), ("eq 35", ""), ("eq 35 − η", ""), ("role", "")]));
    let row = |p: &Point| {
        let (v, law) = (p.velocity * 1e-3, r.fit.law.at(p.velocity * 1e-3, p.ratio()));
        let place = [v, p.diameter * 1e3, p.thickness * 1e3, p.ratio(), p.cells, p.across(), p.time * 1e6];
        let numbers = place.iter().chain(&p.projectile).chain(&p.plate).chain([&p.eta, &p.contact, &law]);
        numbers.copied().chain([law - p.eta]).map(|x| tidy(x).into()).chain([role(p).into()]).collect()
    };
    Table {
        title: title.into(),
        columns: head,
        rows: points.iter().map(row).collect(),
        note: "Masses by phase are shares of the projectile's mass, also the plate's. Cells through: of the thinner of plate and \
               projectile. eq 35 − η is raw: a law above 1 counts as wrong. At the contact: liquid in matter that began within \
               three cells of where projectile and plate meet; artificial viscosity overheats it on cells of any size."
            .into(),
    }
}
