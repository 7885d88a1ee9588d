//! The units of the atoms' world, angstrom, electronvolt and picosecond, and what they are in SI (CODATA 2018).

/// Boltzmann's constant [eV/K].
pub const BOLTZMANN: f64 = 8.617333262e-5;
/// One atomic mass unit [eV ps2/angstrom2]: 1.66053906660e-27 kg over 1.602176634e-19 J/eV, times 1e4.
pub const ATOMIC_MASS: f64 = 1.660_539_066_60e-4 / 1.602_176_634;
/// One eV/angstrom3 [Pa].
pub const PRESSURE: f64 = 1.602_176_634e11;
/// One eV an atom of molar mass 1 g/mol [J/kg]: 1.602176634e-19 J times Avogadro's number, over 1e-3 kg/mol.
pub const SPECIFIC_ENERGY: f64 = 1.602_176_634 * 6.022_140_76 * 1e7;
/// One cubic angstrom an atom of molar mass 1 g/mol [m3/kg]: 1e-30 m3 times Avogadro's number, over 1e-3 kg/mol.
pub const SPECIFIC_VOLUME: f64 = 6.022_140_76e-4;
/// One picosecond [s].
pub const TIME: f64 = 1e-12;
