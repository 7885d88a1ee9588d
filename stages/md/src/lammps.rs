//! The same state by LAMMPS, run as a program outside: its motion, our samples, our averages.
//!
//! LAMMPS gets the atoms, the potential as a setfl file and a script, all made here; nothing a pipeline says in words gets
//! into the script. It runs in pieces, each from the restart file of the one before, until the error is small enough.
//! Its unit of pressure is the bar; its constants are of CODATA 2002 and taken into account.
use crate::lattice;
use crate::order::Order;
use crate::params::Params;
use crate::potential::{Potential, setfl};
use crate::run::{RESPONSE, SCALE_EVERY, SHARE_OF_REST};
use crate::sampled::{Asked, LEAST_SAMPLES, Sampled};
use crate::state::State;
use crate::units::{BOLTZMANN, TIME};
use hvi_kit::engine::Engine;
use hvi_kit::{Cancel, Ctx, File, StageError};
use std::collections::BTreeMap;
use std::fmt::Write;

/// LAMMPS, as Debian has it.
pub static ENGINE: Engine = Engine {
    program: "lmp",
    version: &["-h"],
    // Open MPI, which Debian builds it with, would start a daemon of its own for each lone process.
    environment: &[("OMPI_MCA_ess_singleton_isolated", "1")],
    install: "install LAMMPS (Debian: apt install lammps)",
};

/// What starts several processes of LAMMPS: Open MPI's, which Debian installs with it, or another one's.
static MPIRUN: Engine = Engine {
    program: "mpirun",
    version: &["--version"],
    // Open MPI: as many processes as were asked for on as many cores as there are, moved as the system likes; also as root.
    environment: &[
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("OMPI_MCA_hwloc_base_binding_policy", "none"),
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ],
    install: "install MPI (Debian: apt install mpi-default-bin)",
};

/// One eV/angstrom3 in LAMMPS' metal units [bar].
pub const BAR: f64 = 1.6021765e6;
/// Boltzmann's constant in LAMMPS' metal units [eV/K].
const ITS_BOLTZMANN: f64 = 8.617343e-5;

/// Arguments under which LAMMPS reads the script `in` and keeps quiet.
pub const ARGUMENTS: [&str; 9] = ["-in", "in", "-log", "log", "-screen", "none", "-nocite", "-sf", "opt"];

/// Runs LAMMPS on the script `script`, beside `files`; brings `wanted` back, and its log as the last.
///
/// # Errors
/// [`StageError::Physics`] with LAMMPS' own words where it fails, or is not here; [`StageError::Cancelled`].
pub fn run(script: &str, files: &[(&str, &[u8])], wanted: &[&str], cancel: &Cancel) -> Result<Vec<String>, StageError> {
    run_as(1, script, files, wanted, cancel)
}

/// As [`run`], as `ranks` processes.
///
/// # Errors
/// As [`run`]; [`StageError::Engine`] where there is no `mpirun` for more than one.
pub fn run_as(
    ranks: u32,
    script: &str,
    files: &[(&str, &[u8])],
    wanted: &[&str],
    cancel: &Cancel,
) -> Result<Vec<String>, StageError> {
    let mut all = vec![("in", script.as_bytes())];
    all.extend(files);
    let names: Vec<&str> = wanted.iter().copied().chain(["log"]).collect();
    let count = ranks.to_string();
    let done = match ranks {
        1 => ENGINE.run(&ARGUMENTS, &all, &names, cancel)?,
        _ => MPIRUN.run(&[&["-np", &count, ENGINE.program][..], &ARGUMENTS].concat(), &all, &names, cancel)?,
    };
    let text = |file: Option<Vec<u8>>| file.map(|f| f.iter().map(|&b| char::from(b)).collect::<String>());
    let texts: Vec<Option<String>> = done.files.into_iter().map(text).collect();
    let log = texts.last().cloned().flatten().unwrap_or_default();
    if !done.success || !log.contains("Total wall time") {
        let mut lines = log.lines().chain(done.printed.lines());
        let last = || done.printed.lines().rfind(|l| l.contains(|c: char| c.is_alphanumeric()));
        let error = lines.find(|l| l.starts_with("ERROR")).or_else(last).unwrap_or("it ended without saying why");
        return Err(StageError::physics(format!("LAMMPS: {error}")));
    }
    let given = wanted.iter().zip(&texts).find(|(_, t)| t.is_none());
    match given {
        Some((name, _)) => Err(StageError::physics(format!("LAMMPS ended well, but left no `{name}`"))),
        None => Ok(texts.into_iter().flatten().collect()),
    }
}

/// Core-seconds of the loop of the last run in LAMMPS' log: its wall time times its share of a core.
pub fn loop_time(log: &str) -> Option<f64> {
    let wall = log.lines().rfind(|l| l.starts_with("Loop time of"))?.split_whitespace().nth(3)?;
    let share = log.lines().rfind(|l| l.contains("% CPU use"))?.trim().split('%').next()?;
    Some(wall.parse::<f64>().ok()? * share.parse::<f64>().ok()? * 0.01)
}

/// Atoms of one kind as a file for LAMMPS' `read_data`: `[atoms][3]` [angstrom] in a box of edges `edges` [angstrom], with
/// velocities [angstrom/ps] if there are any.
pub fn data(positions: &[[f64; 3]], velocities: &[[f64; 3]], edges: [f64; 3], molar_mass: f64) -> String {
    let mut text = format!("made by hvi-flow\n\n{} atoms\n1 atom types\n", positions.len());
    for (edge, axis) in edges.iter().zip(["x", "y", "z"]) {
        let _ = writeln!(text, "0 {edge:e} {axis}lo {axis}hi");
    }
    let _ = write!(text, "\nMasses\n\n1 {molar_mass:e}\n\nAtoms # atomic\n\n");
    for (k, [x, y, z]) in positions.iter().enumerate() {
        let _ = writeln!(text, "{} 1 {x:e} {y:e} {z:e}", k + 1);
    }
    if !velocities.is_empty() {
        text.push_str("\nVelocities\n\n");
    }
    for (k, [x, y, z]) in velocities.iter().enumerate() {
        let _ = writeln!(text, "{} {x:e} {y:e} {z:e}", k + 1);
    }
    text
}

/// The potential's file, with the one name of an element that scripts use.
pub fn potential(potential: &Potential) -> String {
    setfl(potential, "X")
}

/// The lines of a script from its units to its neighbour lists; `atoms` reads them.
pub fn opening(atoms: &str, skin: f64) -> String {
    format!(
        "units metal\natom_style atomic\nboundary p p p\n{atoms}\npair_style eam/alloy\npair_coeff * * potential X\n\
         neighbor {skin} bin\nneigh_modify every 1 delay 0 check yes\n"
    )
}

/// Runs the state that `params`, which have been checked, describe.
///
/// # Errors
/// As [`run`].
pub fn state(params: &Params, files: &BTreeMap<String, File>, ctx: &Ctx<'_>) -> Result<State, StageError> {
    let asked = params.asked(files).map_err(|e| StageError::physics(e.why))?;
    let mut pieces =
        Pieces { file: potential(&asked.potential), asked, restart: None, sampled: Sampled::default(), done: 0 };
    let (longest, shortest) = (params.steps(params.longest), params.steps(params.shortest));
    let mut more = shortest;
    loop {
        ctx.tick(pieces.done as f64, (pieces.done + more) as f64, "LAMMPS")?;
        pieces.run(more, ctx.cancel)?;
        let taken = pieces.sampled.series.energy.len();
        let left = longest.saturating_sub(pieces.sampled.discarded + taken);
        if pieces.sampled.phase_changed() && left > 0 {
            pieces.sampled.discard();
            more = shortest.min(left);
            continue;
        }
        let ratio = pieces.sampled.averages(pieces.asked.cube()).pressure.error / pieces.asked.target();
        if ratio <= 1.0 || left == 0 {
            return Ok(pieces.sampled.state(&pieces.asked, pieces.done as u64));
        }
        let expected = taken as f64 * (ratio * ratio - 1.0);
        more = ((SHARE_OF_REST * expected) as usize + LEAST_SAMPLES).next_multiple_of(LEAST_SAMPLES).min(left);
    }
}

/// A run of LAMMPS in pieces.
struct Pieces<'a> {
    asked: Asked<'a>,
    /// The potential's.
    file: String,
    /// What the last piece left.
    restart: Option<Vec<u8>>,
    sampled: Sampled,
    /// Steps in all.
    done: usize,
}

impl Pieces<'_> {
    /// Runs `steps` more steps, the first time after equilibration.
    fn run(&mut self, steps: usize, cancel: &Cancel) -> Result<(), StageError> {
        let params = self.asked.params;
        let edge = self.asked.lattice * params.cells() as f64;
        let sites = lattice::sites(params.cells(), self.asked.lattice);
        let atoms = data(&sites, &[], [edge; 3], self.asked.potential.molar_mass());
        let script = self.script(steps);
        let start = match &self.restart {
            Some(restart) => ("restart.in", restart.as_slice()),
            None => ("data", atoms.as_bytes()),
        };
        let files = [start, ("potential", self.file.as_bytes())];
        let texts = run_as(params.ranks, &script, &files, &["series", "looks", "restart.out"], cancel)?;
        let first = self.sampled.discarded + self.sampled.series.energy.len();
        if self.restart.is_none() {
            self.done += params.steps(params.equilibration);
        }
        self.done += steps;
        self.read_series(&texts[0], first)?;
        self.read_looks(&texts[1], first)?;
        self.restart = Some(texts[2].chars().map(|c| c as u8).collect());
        Ok(())
    }

    fn script(&self, steps: usize) -> String {
        let params = self.asked.params;
        let fresh = self.restart.is_none();
        let atoms = if fresh { "read_data data" } else { "read_restart restart.in" };
        let temperature = params.temperature.si() * BOLTZMANN / ITS_BOLTZMANN;
        let mut script = opening(atoms, 0.8);
        let _ = write!(
            script,
            "timestep {}\nthermo {LEAST_SAMPLES}\nthermo_modify lost error\ncompute way all displace/atom\n\
             compute virial all pressure NULL virial\nvariable pull atom fx*c_way[1]+fy*c_way[2]+fz*c_way[3]\n\
             compute pull all reduce sum v_pull\n",
            params.time_step.si() / TIME
        );
        let bath = format!("fix bath all nvt temp {temperature} {temperature} {RESPONSE}\n");
        if fresh {
            let (all, seed) = (params.steps(params.equilibration), params.seed % 900_000_000 + 1);
            let _ = write!(
                script,
                "velocity all create {} {seed} mom yes rot no dist gaussian\nfix move all nve\n\
                 fix scale all temp/rescale {SCALE_EVERY} {temperature} {temperature} 0 1\nrun {}\nunfix move\nunfix scale\n\
                 {bath}run {}\nreset_timestep 0\n",
                2.0 * temperature,
                all / 2,
                all - all / 2
            );
        } else {
            script.push_str(&bath);
        }
        let _ = write!(
            script,
            "fix series all ave/time 1 1 1 c_thermo_pe c_virial c_pull c_thermo_temp file series format \" %.15g\"\n\
             dump looks all custom {LEAST_SAMPLES} looks x y z c_way[1] c_way[2] c_way[3]\nrun {steps}\n\
             write_restart restart.out\n"
        );
        script
    }

    /// Takes the samples of steps after `first`.
    fn read_series(&mut self, text: &str, first: usize) -> Result<(), StageError> {
        for line in text.lines().filter(|l| !l.starts_with('#')) {
            let row = numbers::<5>(line)?;
            let [step, energy, bars, pull, temperature] = row;
            if step as usize > first {
                let series = &mut self.sampled.series;
                series.energy.push(energy);
                series.pressure.push(bars / BAR);
                series.site_virial.push(pull);
                series.temperature.push(temperature * ITS_BOLTZMANN / BOLTZMANN);
            }
        }
        Ok(())
    }

    /// Takes the looks of steps after `first`.
    fn read_looks(&mut self, text: &str, first: usize) -> Result<(), StageError> {
        for frame in text.split("ITEM: TIMESTEP\n").skip(1) {
            let mut lines = frame.lines();
            let [step] = numbers::<1>(lines.next().unwrap_or_default())?;
            if step as usize <= first {
                continue;
            }
            let rows = lines.skip_while(|l| !l.starts_with("ITEM: ATOMS")).skip(1).map(numbers::<6>);
            let rows: Vec<[f64; 6]> = rows.collect::<Result<_, _>>()?;
            let positions: Vec<[f64; 3]> = rows.iter().map(|r| [r[0], r[1], r[2]]).collect();
            let ways: Vec<[f64; 3]> = rows.iter().map(|r| [r[3], r[4], r[5]]).collect();
            let edge = self.asked.lattice * self.asked.params.cells() as f64;
            self.sampled.looks.push(Order::of(&positions, &ways, self.asked.lattice, edge));
        }
        Ok(())
    }
}

/// `N` finite numbers, which are a line.
fn numbers<const N: usize>(line: &str) -> Result<[f64; N], StageError> {
    let all: Vec<f64> = line.split_whitespace().map_while(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    all.try_into()
        .map_err(|_| StageError::physics(format!("LAMMPS wrote `{line}` where {N} finite numbers were expected")))
}
