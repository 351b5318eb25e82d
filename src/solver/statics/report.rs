use std::fmt;

use super::Balance;
use crate::mechanics::Vec3;
use crate::system::{EquationName, Name, NoValue};
use admire_syntax::units::{Dimension, Units};

/// Record of one Newton iteration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Iteration {
    /// Largest residual of any equation before the Newton step.
    pub imbalance: f64,
    /// Largest relative correction of any unknown.
    pub correction: f64,
    /// Fraction of the Newton step that was taken.
    pub step: f64,
}

/// Number of rows of [`history_table`] at the start and at the end of a long history.
const ROWS: usize = 6;

/// Returns a table of the iterations, as lines of text. A long history is shortened to its first and last iterations.
pub fn history_table(history: &[Iteration]) -> Vec<String> {
    let mut out = vec!["iteration  imbalance  correction  step".to_string()];
    for (k, i) in history.iter().enumerate() {
        if history.len() > 2 * ROWS && (ROWS..history.len() - ROWS).contains(&k) {
            if k == ROWS {
                out.push("      ...".to_string());
            }
            continue;
        }
        out.push(format!(
            "{:9}  {:9.2e}  {:10.2e}  {:4.2}",
            k + 1,
            i.imbalance,
            i.correction,
            i.step
        ));
    }
    out
}

/// A motion without stiffness.
#[derive(Clone, PartialEq, Debug)]
pub struct FreeMotion {
    /// Part that moves most.
    pub part: Name,
    /// Other parts that take part in the motion.
    pub others: Vec<Name>,
    /// Description of the motion, for example `spins freely about the line MARKER/13-MARKER/15`.
    pub motion: String,
    /// Direction of the translation or of the rotation axis, in ground axes.
    pub axis: Vec3,
    /// Stiffness of the motion, too small to hold it; `None` if the motion has no stiffness at all.
    pub weak: Option<Weak>,
}

/// A stiffness so small that it is lost in the round-off of larger stiffnesses.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Weak {
    /// Stiffness as a force per length, or a torque per radian.
    pub stiffness: f64,
    /// Ratio of this stiffness to the largest stiffness of the same part.
    pub share: f64,
}

impl FreeMotion {
    fn lacks(&self) -> &'static str {
        match self.weak {
            Some(_) => "this motion has no mass either",
            None => "this motion has neither stiffness nor mass",
        }
    }
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.part, self.motion)?;
        for (k, other) in self.others.iter().enumerate() {
            write!(
                f,
                "{} {other}",
                if k == 0 { ", together with" } else { "," }
            )?;
        }
        if let Some(Weak { stiffness, share }) = self.weak {
            write!(
                f,
                " (its stiffness of {stiffness:.1e}, in units of the deck, is {share:.0e} of the largest stiffness of the part and is lost in round-off; replace the stiffest element by a joint)"
            )?;
        }
        Ok(())
    }
}

/// A part that moved so far in one solution that the equilibrium may not be the intended one.
#[derive(Clone, PartialEq, Debug)]
pub struct Far {
    /// Part that moved far.
    pub part: Name,
    /// Displacement of the centre of the part, in length units of the deck.
    pub shift: f64,
    /// Rotation of the part, in radians.
    pub turn: f64,
}

impl Far {
    /// Rotation above which a part counts as having moved far, in radians.
    pub(super) const TURN: f64 = std::f64::consts::FRAC_PI_3;

    /// Describes the displacement or rotation of the part, for example `PART/4 'KNUCKLE' turned by 118 degrees`.
    pub fn described(&self, units: &Units) -> String {
        let part = &self.part;
        if self.turn > Self::TURN {
            format!("{part} turned by {:.0} degrees", self.turn.to_degrees())
        } else {
            let unit = units.name(Dimension::LENGTH);
            format!(
                "{part} moved by {:.4e} {unit}, which is more than the size of the mechanism",
                self.shift
            )
        }
    }
}

/// Report of a converged solution.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Report {
    /// Total number of iterations, including the iterations of continuation methods.
    pub iterations: usize,
    /// Number of iterations that assembled and factored a new Jacobian. The other iterations used an earlier one.
    pub factorisations: usize,
    /// Largest residual of any equation at the equilibrium.
    pub imbalance: f64,
    /// Largest relative correction of the last iteration.
    pub correction: f64,
    /// Record of every iteration in the last sequence of iterations.
    pub history: Vec<Iteration>,
    /// Motions without stiffness. They are harmless, because no force drives them and they have mass.
    pub free_motions: Vec<FreeMotion>,
    /// Redundant constraint equations that were removed, for example `Zi.Xj in JOINT/4`.
    pub redundant: Vec<EquationName>,
    /// Continuation method that reached the equilibrium; `None` if plain iteration reached it.
    pub continuation: Option<Continuation>,
    /// True if the iteration stopped at the round-off of this model because IMBALANCE is smaller than this round-off.
    pub at_roundoff: bool,
    /// Number of times that a Newton step was halved after the limits TLIMIT and ALIMIT were applied.
    pub shortened: usize,
    /// Largest remaining force and torque on a part, summed again at the equilibrium.
    pub balance: Balance,
    /// Parts that turned by more than 60 degrees or moved by more than the mechanism's size.
    pub far: Vec<Far>,
}

/// Continuation method that reached an equilibrium after plain iteration failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Continuation {
    /// Load continuation: the initial imbalance was released in steps.
    Load {
        /// Number of load steps.
        steps: usize,
    },
    /// Damped continuation: motions were slowed down by a viscous damping that decreased to zero.
    Damped,
}

/// Reason why no equilibrium was found.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum SolveError {
    /// The iteration did not reach the tolerances.
    #[error(
        "no equilibrium after {} {}: the largest imbalance is {imbalance:.3e}, in units of the deck, at {worst}",
        history.len(),
        if history.len() == 1 { "iteration" } else { "iterations" }
    )]
    NotConverged {
        /// Name of the equation with the largest imbalance, for example `PART/4 'KNUCKLE' force along z`.
        worst: String,
        /// Residual of that equation.
        imbalance: f64,
        /// Record of every iteration in the last sequence of iterations.
        history: Vec<Iteration>,
        /// Descriptions of the usual causes that are present in the model.
        causes: Vec<String>,
    },
    /// A massless part moves without any stiffness.
    #[error("{0}: {lacks}", lacks = .0.lacks())]
    FreeMotion(Box<FreeMotion>),
    /// A removed constraint equation is violated although the others hold.
    #[error(
        "{equation} contradicts the other constraints: it is violated by {violation:.3e}, in units of the deck"
    )]
    Inconsistent {
        /// Name of the equation, for example `Zi.Xj in JOINT/4`.
        equation: String,
        /// Residual of the equation.
        violation: f64,
    },
    /// The iteration converged, but the forces do not cancel when they are summed again.
    #[error(
        "the forces recomputed at this equilibrium do not balance; remaining: {0}, in units of the deck"
    )]
    Unbalanced(Box<Balance>),
    /// An element has no value in this configuration.
    #[error(transparent)]
    NoValue(#[from] NoValue),
}
