//! Which variant of the method steps a run: kernel, transfer, order of the stress update, heat conduction.
use crate::kernel::Kernel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How velocity passes from the grid back to particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Transfer {
    /// Affine: velocity and its gradient field from the grid (Jiang, Schroeder & Teran 2017). Needs a quadratic or cubic kernel.
    #[default]
    Apic,
    /// Affine, with the particle's own velocity plus the grid's acceleration, less what it has apart from the grid times a share of
    /// damping: the more the faster matter is compressed, little elsewhere (after Y. Fei, Q. Guo, R. Wu, L. Huang & M. Gao, ACM Trans. Graph.
    /// 40, 109 (2021), whose share is one number; here it is a mean over the nodes, so that momentum is kept). Needs a quadratic or
    /// cubic kernel.
    Aflip,
    /// The particle's own velocity plus the grid's acceleration (Brackbill & Ruppel 1986): no dissipation, noise stays.
    Flip,
    /// FLIP less what `order` passes to the grid and back leave of the velocity (Hammerquist & Nairn 2017): 1 is PIC.
    Xpic {
        /// Passes, 1 to 8.
        order: u32,
    },
}

/// What becomes of motion that the grid holds and particles can't.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TransferHeat {
    /// Heat, all of it.
    #[default]
    All,
    /// Heat where matter is being compressed, as in shocks, which need it. Elsewhere no physics turns motion into heat but plastic
    /// work, which is counted by itself: there it stays unresolved motion, an account of the ledger, and melts nothing. For the
    /// transfers AFLIP and FLIP.
    Shocks,
}

/// When stress is brought up to date within a step. Energy is booked as the work of the stress that acted in all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Stress extrapolated to the middle of the step, velocity gradient of the middle.
    #[default]
    Midpoint,
    /// Update stress first, by the gradient at the start of the step.
    Usf,
    /// Update stress last, by the gradient at its end.
    Usl,
    /// Modified update stress last: by the gradient of the particles' new velocities on the grid (Sulsky, Zhou & Schreyer 1995).
    Musl,
}

impl Scheme {
    /// Whether matter deforms in a pass of its own after its motion.
    pub fn deforms_last(self) -> bool {
        matches!(self, Scheme::Usl | Scheme::Musl)
    }
}

/// The variant of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Weights.
    pub kernel: Kernel,
    /// Return of velocity.
    pub transfer: Transfer,
    /// What becomes of motion that particles can't hold.
    pub transfer_heat: TransferHeat,
    /// Order of the stress update.
    pub scheme: Scheme,
    /// Coulomb friction between the first body and all others, which may then slide and part; without it they stick where they meet.
    pub friction: Option<f64>,
    /// Coefficient of the heat conduction in compressing matter, see [`crate::conduction`]; 0: none.
    pub conduction: f64,
}

impl Default for Method {
    fn default() -> Self {
        Method {
            kernel: Kernel::Cubic,
            transfer: Transfer::Apic,
            transfer_heat: TransferHeat::All,
            scheme: Scheme::Midpoint,
            friction: None,
            conduction: CONDUCTION,
        }
    }
}

/// Default coefficient of heat conduction: with the viscosity's .3 and .7 the three cells at the contact of copper on copper at
/// 5.9 km/s keep less than a quarter of what they do without it and with .5 and 2, and pressure, velocity and residual energy
/// behind the shock stay as they are (`tests/battery_wall.rs`).
pub const CONDUCTION: f64 = 80.0;

impl Method {
    /// Second moment of the kernel for the affine transfer [m2] on cells of `cell` [m]; 0 for the others, which carry no affine
    /// motion.
    #[inline(always)]
    pub fn moment(&self, cell: f64) -> f64 {
        match self.transfer {
            Transfer::Apic | Transfer::Aflip => self.kernel.moment() * cell * cell,
            _ => 0.0,
        }
    }

    /// What can't be combined: the key and why.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        if matches!(self.transfer, Transfer::Apic | Transfer::Aflip) && self.kernel.moment() == 0.0 {
            let (transfer, kernel) = (self.transfer, self.kernel);
            let why = format!("is {transfer:?}, which needs kernel = \"quadratic\" or \"cubic\", not {kernel:?}");
            return Some(("transfer", why.to_lowercase()));
        }
        let keeps = matches!(self.transfer, Transfer::Aflip | Transfer::Flip);
        if self.transfer_heat == TransferHeat::Shocks && !keeps {
            let why = "is \"shocks\", which needs transfer = \"aflip\" or \"flip\": the others take motion away in every step";
            return Some(("transfer_heat", why.into()));
        }
        match self.transfer {
            Transfer::Xpic { order } if !(1..=8).contains(&order) => {
                Some(("transfer", format!("has order {order}, must be 1 to 8")))
            }
            _ => None,
        }
    }
}
