//! `eos`: an equation of state from a file or by name, asked for states and curves.
use super::{Done, Stop};
use crate::console::{say, warn};
use crate::mistake::{At, Mistake, Source};
use hvi_eos::curve::CurveError;
use hvi_eos::curves::trace::Sample;
use hvi_eos::curves::{densest, densest_adiabat, text};
use hvi_eos::definition::Definition;
use hvi_eos::handbook::Set;
use hvi_eos::model::sesame;
use hvi_eos::{Eos, EosResult, Tabulated};
use hvi_kit::units::{self, Dimension};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// What `eos` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    ask: Ask,
}

const FILE_HELP: &str = "An equation of state: a TOML or JSON file, a SESAME-like table (.ses), or copper-royce, copper-paper-md, aluminium-paper";

#[derive(clap::Subcommand)]
enum Ask {
    /// Answers for the states of a CSV file: columns V,T or V,E; writes V,T,E,P,phase,liquid_fraction,c
    Eval {
        #[arg(help = FILE_HELP)]
        file: String,
        /// States: columns V and T, or V and E, in SI or in the unit the name carries, as in `V [cm3/g]`
        #[arg(long, value_name = "CSV")]
        states: PathBuf,
    },
    /// A curve as CSV
    Curve {
        #[arg(help = FILE_HELP)]
        file: String,
        #[command(subcommand)]
        kind: Kind,
    },
    /// The equation of state as a TOML file with units
    Show {
        #[arg(help = FILE_HELP)]
        file: String,
    },
    /// The equation of state as a SESAME-like table of pressure and energy over density and temperature
    Table {
        #[arg(help = FILE_HELP)]
        file: String,
        /// Densities over the reference density: from, to, how many
        #[arg(long, num_args = 3, value_names = ["FROM", "TO", "COUNT"], default_values = ["0.7", "1.7", "101"])]
        density: Vec<String>,
        /// Temperatures [K]: from, to, how many
        #[arg(long, num_args = 3, value_names = ["FROM", "TO", "COUNT"], default_values = ["100", "10000", "100"])]
        temperature: Vec<String>,
    },
}

#[derive(clap::Subcommand)]
enum Kind {
    /// The principal Hugoniot, with melting on it
    Hugoniot(UpTo),
    /// P over V at one temperature
    Isotherm {
        #[arg(long, value_name = "QUANTITY", default_value = "300 K")]
        temperature: String,
        #[command(flatten)]
        up_to: UpTo,
    },
    /// V over T at one pressure, up to 6000 K
    Isobar {
        #[arg(long, value_name = "QUANTITY", default_value = "0 GPa")]
        pressure: String,
    },
    /// Adiabatic compression from the reference volume
    Isentrope {
        #[arg(long, value_name = "QUANTITY", default_value = "300 K")]
        temperature: String,
        #[command(flatten)]
        up_to: UpTo,
    },
    /// Release of a shocked state to zero pressure
    Release {
        #[arg(long, value_name = "QUANTITY", default_value = "100 GPa")]
        pressure: String,
    },
    /// Where melting begins
    Melting(UpTo),
    /// The critical point
    Critical,
}

#[derive(clap::Args)]
struct UpTo {
    /// Highest pressure
    #[arg(long, value_name = "QUANTITY", default_value = "400 GPa")]
    up_to: String,
}

/// Answers.
///
/// # Errors
/// [`Stop`] where a file can't be read, or what is asked for isn't there.
pub fn run(args: &Args) -> Done {
    let answer = match &args.ask {
        Ask::Eval { file, states } => {
            let eos = read(file)?.eos;
            let source = load(states)?;
            let samples = text::answer(&eos, &source.text).map_err(|f| marked(&source, &f))?;
            warn_of_extrapolation(&eos, &samples);
            text::write(&samples)
        }
        Ask::Curve { file, kind } => {
            let eos = read(file)?.eos;
            let samples = curve(&eos, kind)?;
            warn_of_extrapolation(&eos, &samples);
            warn_of_end(kind, &samples)?;
            text::write(&samples)
        }
        Ask::Show { file } => {
            let result = read(file)?;
            let shown = Definition::describe(&result).and_then(|d| toml::to_string(&d).ok());
            shown.ok_or_else(|| Mistake::new(format!("`{file}` is a table: use `hvi-flow eos table {file}`")))?
        }
        Ask::Table { file, density, temperature } => {
            let result = read(file)?;
            let reference = 1.0 / result.eos.reference_volume();
            let densities: Vec<f64> = range("--density", density)?.iter().map(|x| x * reference).collect();
            sesame::write(&result.eos, &result.source, &densities, &range("--temperature", temperature)?)
        }
    };
    say(format_args!("{}", answer.trim_end()));
    Ok(ExitCode::SUCCESS)
}

/// Says what the answers do not know: phases of a table without them, and how many states are denser than the model's formulas reach.
fn warn_of_extrapolation(eos: &Eos, samples: &[Sample]) {
    if matches!(eos, Eos::Table(_)) && eos.melting_temperature(eos.reference_volume()).is_none() {
        warn(format_args!("the table tells no phases apart: what it calls solid may be molten"));
    }
    let Some(least) = eos.least_volume() else { return };
    let denser: Vec<usize> = (0..samples.len()).filter(|&i| samples[i].volume < least).map(|i| i + 1).collect();
    if let Some(first) = denser.first() {
        warn(format_args!(
            "{} of {} states, the first of them number {first}, are denser than V/V0 = {:.3}: there the {} equation of state goes on along \
             its tangent",
            denser.len(),
            samples.len(),
            least / eos.reference_volume(),
            eos.name()
        ));
    }
}

/// Says where a curve ends before the pressure that was asked for.
fn warn_of_end(kind: &Kind, samples: &[Sample]) -> Result<(), Stop> {
    let (Kind::Hugoniot(up_to) | Kind::Isotherm { up_to, .. } | Kind::Isentrope { up_to, .. } | Kind::Melting(up_to)) =
        kind
    else {
        return Ok(());
    };
    let (asked, reached) = (up_to.si()?, samples.iter().map(|s| s.pressure).fold(0.0, f64::max));
    if reached < 0.97 * asked {
        warn(format_args!("the curve ends at {:.4} GPa: the model's formulas go no further", reached / 1e9));
    }
    Ok(())
}

fn curve(eos: &Eos, kind: &Kind) -> Result<Vec<Sample>, Stop> {
    let v0 = eos.reference_volume();
    let none = |e: CurveError| Stop::Mistake(Mistake::new(e.to_string()));
    Ok(match kind {
        Kind::Hugoniot(up_to) => eos.hugoniot_curve(up_to.si()?).map_err(none)?,
        Kind::Isotherm { temperature, up_to } => {
            let t = above_zero("--temperature", temperature, Dimension::Temperature)?;
            eos.isotherm_curve(t, v0, densest(eos, t, up_to.si()?).map_err(none)?).map_err(none)?
        }
        Kind::Isobar { pressure } => {
            let samples = eos.isobar_curve(quantity("--pressure", pressure, Dimension::Pressure)?, 100.0, 6000.0);
            if samples.is_empty() {
                let none =
                    format!("the {} equation of state has no {pressure} at 100 K, from 0.3 to 1.45 V0", eos.name());
                return Err(Mistake::new(none).into());
            }
            samples
        }
        Kind::Isentrope { temperature, up_to } => {
            let t = above_zero("--temperature", temperature, Dimension::Temperature)?;
            eos.isentrope_curve(v0, t, densest_adiabat(eos, t, up_to.si()?).map_err(none)?).map_err(none)?
        }
        Kind::Release { pressure } => {
            let p = above_zero("--pressure", pressure, Dimension::Pressure)?;
            eos.release_curve(&eos.hugoniot_at_pressure(p).map_err(none)?).map_err(none)?
        }
        Kind::Melting(up_to) => {
            let [begins, _] = eos.melting_curves(up_to.si()?);
            if begins.is_empty() {
                return Err(Mistake::new(format!("the {} equation of state knows no melting there", eos.name())).into());
            }
            begins
        }
        Kind::Critical => {
            let point = eos.critical_point();
            vec![
                point.ok_or_else(|| {
                    Mistake::new(format!("the {} equation of state has no critical point", eos.name()))
                })?,
            ]
        }
    })
}

impl UpTo {
    fn si(&self) -> Result<f64, Mistake> {
        above_zero("--up-to", &self.up_to, Dimension::Pressure)
    }
}

fn quantity(option: &str, text: &str, dimension: Dimension) -> Result<f64, Mistake> {
    units::si(text, dimension).map_err(|why| Mistake::new(format!("{option}: {why}")))
}

fn above_zero(option: &str, text: &str, dimension: Dimension) -> Result<f64, Mistake> {
    let value = quantity(option, text, dimension)?;
    if value > 0.0 { Ok(value) } else { Err(Mistake::new(format!("{option}: `{text}` must be above zero"))) }
}

/// `[from, to, count]` as that many numbers, both ends included.
fn range(option: &str, words: &[String]) -> Result<Vec<f64>, Mistake> {
    let wrong = || {
        Mistake::new(format!(
            "{option} {}: expected two rising positive numbers and a count from 2 to 10000",
            words.join(" ")
        ))
    };
    let number = |k: usize| words[k].parse::<f64>().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).ok_or_else(wrong);
    let (from, to) = (number(0)?, number(1)?);
    let count = words[2].parse::<usize>().ok().filter(|n| (2..=10_000).contains(n) && to > from).ok_or_else(wrong)?;
    Ok((0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect())
}

fn load(path: &Path) -> Result<Arc<Source>, Mistake> {
    let name = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Arc::new(Source { name, text })),
        Err(e) => Err(Mistake::new(format!("can't read {name}: {e}"))),
    }
}

/// The equation of state called `file`: a published set, or a file.
fn read(file: &str) -> Result<EosResult, Mistake> {
    if let Some(set) = Set::named(file) {
        return made(Definition::of(set), None);
    }
    let path = Path::new(file);
    if !path.exists() {
        let none = Mistake::new(format!("there is no file `{file}`, nor a published equation of state of that name"));
        return Err(none.nearest(file, Set::ALL.map(Set::name)));
    }
    let source = load(path)?;
    let at = |span: Range<usize>| At { source: source.clone(), span };
    match path.extension().and_then(|e| e.to_str()) {
        Some("ses") => {
            let table = sesame::read(&source.text, 300.0).map_err(|e| Mistake::new(format!("{file}: {e}")))?;
            let eos = Tabulated::new(table).map_err(|e| Mistake::new(format!("{file}: {e}")))?;
            Ok(EosResult { eos: Eos::Table(eos), source: format!("table of {file}"), fit: None })
        }
        Some("json") => {
            let parsed = serde_json::from_str::<Definition>(&source.text);
            let wrong = |e: serde_json::Error| {
                let span = line_span(&source.text, e.line());
                Mistake::new("this is no equation of state").at(&at(span), e.to_string())
            };
            made(parsed.map_err(wrong)?, Some(&source))
        }
        _ => {
            let parsed = toml::from_str::<Definition>(&source.text);
            let wrong = |e: toml::de::Error| {
                let span = e.span().unwrap_or(0..source.text.len().min(1));
                Mistake::new("this is no equation of state").at(&at(span), e.message())
            };
            made(parsed.map_err(wrong)?, Some(&source))
        }
    }
}

/// The equation of state that `definition` describes; a fault is marked at its key in `source`.
fn made(definition: Definition, source: Option<&Arc<Source>>) -> Result<EosResult, Mistake> {
    definition.make().map_err(|e| {
        let mistake = Mistake::new("these parameters make no equation of state");
        let place = source.and_then(|s| Some((s, s.text.find(&e.key)?)));
        match place {
            Some((s, start)) => mistake.at(&At { source: s.clone(), span: start..start + e.key.len() }, e.why),
            None => mistake.help(e.why),
        }
    })
}

fn marked(source: &Arc<Source>, fault: &text::Fault) -> Mistake {
    let line = line_span(&source.text, fault.line);
    let start = source.text[line.clone()].find(&fault.text).filter(|_| !fault.text.is_empty());
    let span = start.map_or(line.clone(), |k| line.start + k..line.start + k + fault.text.len());
    Mistake::new("these states can't be read").at(&At { source: source.clone(), span }, &fault.why)
}

/// Bytes of line `number`, counted from 1.
fn line_span(text: &str, number: usize) -> Range<usize> {
    let mut start = 0;
    for (i, line) in text.split_inclusive('\n').enumerate() {
        if i + 1 == number {
            return start..start + line.trim_end().len();
        }
        start += line.len();
    }
    text.len().saturating_sub(1)..text.len()
}
