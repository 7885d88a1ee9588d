//! Johnson-Cook damage.
use hvi_kit::lanes::{Real, exp, log};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fracture strain `ef = (D1 + D2 exp(D3 s*)) (1 + D4 ln rate*) (1 + D5 T*)`; failure when the sum of `dep / ef` is 1.
///
/// `s*` is mean stress over equivalent stress, tension positive (the paper writes it with the pressure's letter). Source:
/// G. R. Johnson and W. H. Cook, Eng. Fract. Mech. 21, 31 (1985); Liu, Wang & Zhang (2013) eqs 19-20. Changes: s* counts at
/// most 1.5, the model's stated range (beyond it spall decides), and ef no less than `least`, since some published sets
/// give negative strains there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damage {
    /// D1.
    pub d1: f64,
    /// D2.
    pub d2: f64,
    /// D3.
    pub d3: f64,
    /// D4.
    pub d4: f64,
    /// D5.
    pub d5: f64,
    /// Least fracture strain.
    #[serde(default = "least")]
    pub least: f64,
}

fn least() -> f64 {
    0.01
}

/// Exponent beyond which the fracture strain counts as infinite: exp(30) is 1e13.
const FAR: f64 = 30.0;

impl Damage {
    /// Damage that the plastic strain increment `increment` adds at `triaxiality` s*, `rate` [1/s] over the reference
    /// rate, and `homologous` temperature T*.
    #[inline(always)]
    pub fn increment<R: Real>(&self, increment: R, triaxiality: R, rate: R, homologous: R) -> R {
        let mut shape = R::of(self.d1);
        let mut far = R::of(0.0);
        if self.d2 != 0.0 {
            let exponent = triaxiality.at_most(1.5).times(self.d3);
            shape = exp(exponent.at_most(FAR)).times(self.d2).plus(self.d1);
            if self.d2 > 0.0 {
                far = R::of(1.0).where_less(R::of(FAR), exponent, far);
            }
        }
        if self.d4 != 0.0 {
            shape = shape * log(rate.at_least(1.0)).times(self.d4).plus(1.0);
        }
        let thermal = homologous.at_least(0.0).at_most(1.0).times(self.d5).plus(1.0);
        let damage = increment / (shape * thermal).at_least(self.least);
        R::of(0.0).where_less(R::of(0.0), far, damage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OFHC copper: D1 .54, D2 4.89, D3 -3.03, D4 .014, D5 1.12, at s* = 1/3 (simple tension), 1e3 per second, T* = .5.
    #[test]
    fn fracture_strain_of_copper() {
        let d = Damage { d1: 0.54, d2: 4.89, d3: -3.03, d4: 0.014, d5: 1.12, least: 0.01 };
        let strain = (0.54 + 4.89 * (-1.01f64).exp()) * (1.0 + 0.014 * 1e3f64.ln()) * 1.56;
        assert!((d.increment(0.1, 1.0 / 3.0, 1e3, 0.5) - 0.1 / strain).abs() < 1e-15);
        assert_eq!(d.increment(0.1, -1e9, 1e3, 0.5), 0.0);
        assert!(d.increment(0.1, 1e9, 1e-30, -3.0).is_finite());
    }

    /// A constant fracture strain is D1 alone.
    #[test]
    fn constant() {
        let d = Damage { d1: 1.0, d2: 0.0, d3: 0.0, d4: 0.0, d5: 0.0, least: 0.01 };
        assert_eq!(d.increment(0.25, -5.0, 1e8, 0.9), 0.25);
    }
}
