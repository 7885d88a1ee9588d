//! What the melted fraction shows: Table 4 and Figs 14 to 17 of the paper, and what the resolution does to them.
use crate::eta::EtaLaw;
use crate::point::Point;
use crate::score::standing;
use hvi_kit::view::View;

mod figures;
mod tables;
mod words;

/// Everything there is to see.
pub fn views(r: &EtaLaw) -> Vec<View> {
    let mut views = vec![View::Table(tables::parameters(r))];
    if let Some(refined) = &r.refined {
        views.push(View::Figure(figures::resolutions(refined)));
        views.push(View::Table(tables::resolutions(refined)));
    }
    views.push(View::Figure(figures::comparison(r, true)));
    if !r.check.is_empty() {
        views.push(View::Figure(figures::comparison(r, false)));
    }
    views.push(View::Figure(figures::phases(r, "projectile", |p| p.projectile)));
    views.push(View::Figure(figures::phases(r, "plate", |p| p.plate)));
    let role = |p: &Point| if p.used { "fitted" } else { "left out" };
    views.push(View::Table(tables::runs(r, &r.points, "Runs fitted", role)));
    if !r.check.is_empty() {
        let role = |p: &Point| standing(p, &r.points).describe();
        views.push(View::Table(tables::runs(r, &r.check, "Runs checked", role)));
    }
    views
}
