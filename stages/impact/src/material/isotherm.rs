//! Energy of matter at the reference temperature by volume, from a table: what part of its energy is not heat.
use hvi_eos::Eos;
use hvi_kit::lanes::Eight;

/// Cubics through the equation of state's own values; beyond the table's ends its last value holds. Where that jumps (GRAY's, at V_J) the
/// table goes over in a few intervals.
#[derive(Clone, Debug, PartialEq)]
pub struct Isotherm {
    /// Coefficients of an interval by the share of it, constant first [J/kg].
    cubics: Vec<[f64; 4]>,
}

/// V/V0 from here to there, in so many intervals.
const RANGE: [f64; 2] = [0.25, 2.25];
const INTERVALS: usize = 512;

impl Isotherm {
    /// Of `eos`.
    pub fn new(eos: &Eos) -> Isotherm {
        let (volume, temperature) = (eos.reference_volume(), eos.reference_temperature());
        let step = (RANGE[1] - RANGE[0]) / INTERVALS as f64;
        let at = |i: f64| eos.energy_at(volume * (RANGE[0] + i * step), temperature);
        let cubic = |i: usize| {
            let i = i as f64;
            let [before, start, end, after] = [at(i - 1.0), at(i), at(i + 1.0), at(i + 2.0)];
            let (slope, last) = (0.5 * (end - before), 0.5 * (after - start));
            let rise = end - start;
            [start, slope, 3.0 * rise - 2.0 * slope - last, slope + last - 2.0 * rise]
        };
        Isotherm { cubics: (0..INTERVALS).map(cubic).collect() }
    }

    /// Energy [J/kg] at volumes of `ratio` times the reference one.
    #[inline(always)]
    pub fn energy<R: Eight>(&self, ratio: R) -> R {
        let scale = INTERVALS as f64 / (RANGE[1] - RANGE[0]);
        let place = ratio.plus(-RANGE[0]).times(scale).at_least(0.0).at_most(INTERVALS as f64);
        let (mut places, mut cubics, mut shares) = ([0.0; 8], [[0.0; 4]; 8], [0.0; 8]);
        place.store(&mut places);
        for lane in 0..8 {
            let i = (places[lane] as usize).min(INTERVALS - 1);
            (cubics[lane], shares[lane]) = (self.cubics[i], places[lane] - i as f64);
        }
        let ([a, b, c, d], share) = (R::columns(&cubics), R::load(&shares));
        a + share * (b + share * (c + share * d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use hvi_kit::lanes::Plain;

    /// Within 1e-5 of the energy of compression, c0^2 (about 1.6e7 J/kg for copper), from V/V0 .5 to 1.4: the fourth difference of a
    /// function of that size over intervals of .004 is 1e-8 of it, times 5/384 and what the Hugoniot's pole adds.
    #[test]
    fn the_table_is_the_equation_of_state() {
        let eos = Material::named("copper").expect("shipped").eos;
        let isotherm = Isotherm::new(&eos);
        for i in 0..900 {
            let ratio = 0.5 + 1e-3 * i as f64 + 1e-4;
            let mut found = [0.0; 8];
            isotherm.energy(Plain::load(&[ratio; 8])).store(&mut found);
            let known = eos.energy_at(ratio * eos.reference_volume(), eos.reference_temperature());
            assert!((found[0] - known).abs() < 160.0, "{ratio}: {} J/kg, expected {known}", found[0]);
        }
    }
}
