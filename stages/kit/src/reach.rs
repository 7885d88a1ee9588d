//! The states that a scene brings matter to: what an equation of state must be right for.

/// A state on the way of shock and release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Volume over that of the matter at rest.
    pub volume_ratio: f64,
    /// Temperature [K].
    pub temperature: f64,
    /// Pressure [Pa].
    pub pressure: f64,
    /// Temperature over that of melting at this volume; infinite where the latter isn't known.
    pub homologous: f64,
}

/// The states that scenes bring one matter to, as ways of shock and release: what is cooler at the same volume is reached by
/// gentler ways.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// Each way from rest to where pressure is gone again.
    pub ways: Vec<Vec<Reached>>,
}

/// The states that parameters bring matter to, by the dotted key of the input that describes it; nothing where no estimate can be
/// made, so that it may be any.
pub type ByInput = Vec<(String, Option<Reach>)>;

impl Reach {
    fn states(&self) -> impl Iterator<Item = &Reached> {
        self.ways.iter().flatten()
    }

    /// Least and largest volume over that at rest; 1 and 1 where nothing happens.
    pub fn volume_ratios(&self) -> [f64; 2] {
        self.states().fold([1.0, 1.0], |[low, high], s| [low.min(s.volume_ratio), high.max(s.volume_ratio)])
    }

    /// The highest temperature [K] at `volume_ratio`; outside of the volumes reached that at the nearest one.
    pub fn hottest(&self, volume_ratio: f64) -> f64 {
        let [low, high] = self.volume_ratios();
        let at = volume_ratio.clamp(low, high);
        let between = |pair: &[Reached]| {
            let (a, b) = (pair[0], pair[1]);
            let width = b.volume_ratio - a.volume_ratio;
            let share = if width == 0.0 { 1.0 } else { (at - a.volume_ratio) / width };
            (0.0..=1.0).contains(&share).then_some(a.temperature + share * (b.temperature - a.temperature))
        };
        self.ways.iter().flat_map(|way| way.windows(2).filter_map(between)).fold(0.0, f64::max)
    }

    /// The highest temperature of all [K].
    pub fn highest_temperature(&self) -> f64 {
        self.states().map(|s| s.temperature).fold(0.0, f64::max)
    }

    /// The highest pressure of all [Pa].
    pub fn highest_pressure(&self) -> f64 {
        self.states().map(|s| s.pressure).fold(0.0, f64::max)
    }

    /// The highest pressure [Pa] at which matter is at `homologous` times its melting temperature or hotter, if it ever is.
    pub fn melting_pressure(&self, homologous: f64) -> Option<f64> {
        self.states().filter(|s| s.homologous >= homologous).map(|s| s.pressure).reduce(f64::max)
    }

    /// What is reached, in words.
    pub fn words(&self) -> String {
        let [low, high] = self.volume_ratios();
        let melting = self.states().map(|s| s.homologous).fold(0.0, f64::max);
        let melting = match melting {
            m if m.is_infinite() => String::new(),
            m => format!(", {m:.2} of the melting temperature"),
        };
        format!(
            "V/V0 {low:.3} to {high:.3}, at most {:.0} K and {:.1} GPa{melting}",
            self.highest_temperature(),
            self.highest_pressure() / 1e9
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(volume_ratio: f64, temperature: f64, pressure: f64, homologous: f64) -> Reached {
        Reached { volume_ratio, temperature, pressure, homologous }
    }

    /// Shocked to 0.7 and 2000 K, released to 1.05 and 1000 K.
    fn reach() -> Reach {
        let way = vec![state(1.0, 300.0, 0.0, 0.2), state(0.7, 2000.0, 1e11, 0.5), state(1.05, 1000.0, 0.0, 0.8)];
        Reach { ways: vec![way] }
    }

    #[test]
    fn the_hottest_way_counts_and_outside_the_nearest_volume() {
        let reach = reach();
        let release = |v: f64| 2000.0 - 1000.0 * (v - 0.7) / 0.35;
        for v in [0.7, 0.8, 0.95, 1.05] {
            assert!((reach.hottest(v) - release(v)).abs() < 1e-9, "{v}");
        }
        assert_eq!(reach.hottest(0.5), 2000.0);
        assert_eq!(reach.hottest(1.2), 1000.0);
        assert_eq!(Reach::default().hottest(1.0), 0.0);
    }

    #[test]
    fn melting_is_reached_up_to_a_pressure() {
        let reach = reach();
        assert_eq!(reach.melting_pressure(0.4), Some(1e11));
        assert_eq!(reach.melting_pressure(0.6), Some(0.0));
        assert_eq!(reach.melting_pressure(0.9), None);
        assert_eq!(reach.volume_ratios(), [0.7, 1.05]);
        assert!(reach.words().contains("2000 K and 100.0 GPa, 0.80 of"), "{}", reach.words());
    }
}
