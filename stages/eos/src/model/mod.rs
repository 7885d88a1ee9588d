//! One file a model.
pub mod gray;
pub mod ideal_gas;
pub mod mie_gruneisen;
mod monotone;
pub mod sesame;
pub mod stiffened_gas;
pub(crate) mod table;
pub mod tabulated;
pub mod tillotson;

/// The smaller of `volume` and the smallest volume from 0.9 `reference` on at which `pressure` vanishes.
///
/// Marches to the first negative pressure in steps of a twentieth of the reference volume (of its own volume in thin matter),
/// then closes in.
pub(crate) fn relax(reference: f64, volume: f64, pressure: impl Fn(f64) -> f64) -> f64 {
    let end = volume / reference;
    let mut low = 0.9;
    while low < end {
        let high = (low * 1.05f64).max(low + 0.05).min(end);
        if pressure(high * reference) < 0.0 {
            let root = hvi_kit::math::bisect(low, high, 1e-12, |u| pressure(u * reference));
            return root.unwrap_or(low) * reference;
        }
        low = high;
    }
    volume
}
