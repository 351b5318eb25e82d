use std::fmt;

use super::Balance;
use crate::mechanics::Vec3;
use crate::system::{EquationName, Name, NoValue};
use admire_syntax::units::{Dimension, Units};

/// Record of one iteration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Iteration {
    /// Largest residual of any equation before the step.
    pub imbalance: f64,
    /// Largest relative correction.
    pub correction: f64,
    /// Fraction of the Newton step that was taken.
    pub step: f64,
}

/// Number of rows of [`history_table`] at the start and at the end of a long history.
const ROWS: usize = 6;

/// Returns the iterations as lines of a table; of a long history only the first and the last ones.
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
    /// The part that moves most.
    pub part: Name,
    /// Other parts that take part in the motion.
    pub others: Vec<Name>,
    /// Description of the motion, for example `spins freely about the line MARKER/13-MARKER/15`.
    pub motion: String,
    /// Direction of the translation or of the rotation axis, in ground axes.
    pub axis: Vec3,
    /// Stiffness that is too small to hold the motion; `None` if there is none.
    pub weak: Option<Weak>,
}

/// A stiffness that is lost in the round-off of others.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Weak {
    /// Force per length, or torque per angle.
    pub stiffness: f64,
    /// Share of the largest stiffness of the part.
    pub share: f64,
}

impl FreeMotion {
    fn lacks(&self) -> &'static str {
        match self.weak {
            Some(_) => "no mass holds it either",
            None => "it has neither stiffness nor mass there",
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
                " (the stiffness of {stiffness:.1e} there is {share:.0e} of its largest and is lost in round-off; replace the stiffest \
                 element by a joint)"
            )?;
        }
        Ok(())
    }
}

/// A part that moved so far in one solution that the equilibrium may not be the intended one.
#[derive(Clone, PartialEq, Debug)]
pub struct Far {
    /// The part.
    pub part: Name,
    /// Displacement of its centre, in length units.
    pub shift: f64,
    /// Rotation, in radians.
    pub turn: f64,
}

impl Far {
    /// Rotation above which a part has moved far, radians.
    pub(super) const TURN: f64 = std::f64::consts::FRAC_PI_3;

    /// Describes the motion, for example `PART/4 'KNUCKLE' turned by 118 degrees`.
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
    /// Total number of iterations, including those of continuation.
    pub iterations: usize,
    /// Number of iterations that assembled and factored a new Jacobian; the others used an earlier one.
    pub factorisations: usize,
    /// Largest residual of any equation at the end.
    pub imbalance: f64,
    /// Largest relative correction of the last iteration.
    pub correction: f64,
    /// All iterations of the last sequence.
    pub history: Vec<Iteration>,
    /// Motions without stiffness. They are harmless, because nothing drives them and they have mass.
    pub free_motions: Vec<FreeMotion>,
    /// Redundant constraint equations that were removed, as `Zi.Xj in JOINT/4`.
    pub redundant: Vec<EquationName>,
    /// Continuation that reached the equilibrium; `None` if plain iteration did.
    pub continuation: Option<Continuation>,
    /// True if IMBALANCE is below the round-off of this model, and the iteration stopped at the round-off.
    pub at_roundoff: bool,
    /// Number of times that a step was halved after the limits TLIMIT and ALIMIT were applied.
    pub shortened: usize,
    /// Remaining forces on the parts, summed again at the end.
    pub balance: Balance,
    /// Parts that turned by more than 60 degrees or moved by more than the mechanism's size.
    pub far: Vec<Far>,
}

/// Method that reached an equilibrium after plain iteration failed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Continuation {
    /// The imbalance of the start was released in steps.
    Load {
        /// Number of steps.
        steps: usize,
    },
    /// Motions were slowed down by a viscous damping that decreased to zero.
    Damped,
}

/// Reason why no equilibrium was found.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum SolveError {
    /// The iteration did not reach the tolerances.
    #[error(
        "no equilibrium after {} iterations: largest imbalance {imbalance:.3e} at {worst}",
        history.len()
    )]
    NotConverged {
        /// The equation with the largest imbalance: `PART/4 'KNUCKLE' force along z`.
        worst: String,
        /// Imbalance of that equation.
        imbalance: f64,
        /// All iterations of the last sequence.
        history: Vec<Iteration>,
        /// Usual causes that are present in the model.
        causes: Vec<String>,
    },
    /// A massless part moves without any stiffness.
    #[error("{0}: {lacks}", lacks = .0.lacks())]
    FreeMotion(Box<FreeMotion>),
    /// A removed constraint equation is violated although the others hold.
    #[error("{equation} contradicts the other constraints: it is violated by {violation:.3e}")]
    Inconsistent {
        /// The equation, as `Zi.Xj in JOINT/4`.
        equation: String,
        /// Residual of the equation.
        violation: f64,
    },
    /// The iteration converged, but the forces do not cancel when they are summed again.
    #[error("the forces of this equilibrium do not cancel when they are summed anew: {0} is left")]
    Unbalanced(Box<Balance>),
    /// An element has no value in this configuration.
    #[error(transparent)]
    NoValue(#[from] NoValue),
}
