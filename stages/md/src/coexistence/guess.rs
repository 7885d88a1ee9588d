//! Where melting may be, from the crystal at rest: F. A. Lindemann's rule (Phys. Z. 11, 609 (1910)).
use crate::fault::Fault;
use crate::lanes::Isa;
use crate::lattice;
use crate::potential::Potential;
use crate::system::System;
use crate::table::Tables;
use crate::units::BOLTZMANN;
use hvi_kit::math::bisect;

/// Root mean square way of an atom in the cage of its resting neighbours, over the distance of nearest sites, at melting. The
/// rule is good to a tenth or two of the temperature; the value is that of Mishin's copper at zero pressure.
const LINDEMANN: f64 = 0.097;
/// Grueneisen coefficient of close-packed metals, for the thermal pressure of a first box.
const GRUENEISEN: f64 = 2.0;

/// Cubic edge [angstrom] of the crystal whose edge at rest without pressure is `ground`, at `pressure` [eV/angstrom3] and `temperature` [K], with 3 k_B T and 2 for gamma.
pub fn edge(potential: &Potential, ground: f64, pressure: f64, temperature: f64) -> f64 {
    let excess = |edge: f64| {
        let atom = 0.25 * edge * edge * edge;
        lattice::at_rest(potential, edge).pressure + 3.0 * GRUENEISEN * BOLTZMANN * temperature / atom - pressure
    };
    // beyond 1.06 the lattice at rest is near its spinodal
    bisect(0.75 * ground, 1.06 * ground, 1e-9, excess).unwrap_or(1.06 * ground)
}

/// A first guess of the melting temperature [K] at `pressure` [eV/angstrom3], of the crystal whose edge at rest without pressure
/// is `ground` [angstrom].
///
/// # Errors
/// [`Fault`] where the crystal is off the potential's tables.
pub fn melting(tables: &Tables, ground: f64, pressure: f64) -> Result<f64, Fault> {
    let mut temperature = 1500.0;
    for _ in 0..4 {
        let edge = edge(&tables.potential, ground, pressure, temperature);
        let reach = LINDEMANN * lattice::NEAREST * edge;
        temperature = (reach * reach * cage(tables, edge)? / (3.0 * BOLTZMANN)).clamp(100.0, 20_000.0);
    }
    Ok(temperature)
}

/// Force constant of one atom in its cage of resting neighbours [eV/angstrom2].
fn cage(tables: &Tables, edge: f64) -> Result<f64, Fault> {
    let needed = 2.0 * (tables.potential.cutoff() + 1.0);
    let cells = (needed / edge).ceil() as usize;
    let mut sites = lattice::sites(cells, edge);
    let off = 0.01 * edge;
    sites[0][0] += off;
    let system = System::new(tables.clone(), Isa::best(), &sites, edge * cells as f64)?;
    Ok(-system.forces()[0][0] / off)
}
