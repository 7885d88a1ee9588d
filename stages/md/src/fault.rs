//! What can go wrong while atoms move: where, what, what was allowed, what to do.

/// The run can't go on. Atoms are numbered as the sites they started from, cell by cell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say it")]
pub enum Fault {
    #[error(
        "the box of {edge:.3} angstrom is too small: with this potential it must be at least {needed:.3} angstrom; take more atoms"
    )]
    Small { edge: f64, needed: f64 },
    #[error(
        "step {step} ({time:.3} ps): atoms {} and {} are {distance:.4} angstrom apart, nearer than the {nearest:.3} angstrom where the \
         potential begins; take a shorter time_step, a lower temperature or a greater volume", atoms[0], atoms[1]
    )]
    Close { step: u64, time: f64, atoms: [u32; 2], distance: f64, nearest: f64 },
    #[error(
        "step {step} ({time:.3} ps): atom {atom} has an electron density of {density:.3}, outside of 0 to {densest:.3} where \
         the potential is known; take a shorter time_step, a lower temperature or a greater volume"
    )]
    Dense { step: u64, time: f64, atom: u32, density: f64, densest: f64 },
    #[error("step {step} ({time:.3} ps): velocities are no longer finite; take a shorter time_step")]
    Lost { step: u64, time: f64 },
}
