use std::fmt;

use super::Balance;
use crate::mechanics::Vec3;
use crate::system::{EquationName, Name, NoValue};
use admire_syntax::units::{Dimension, Units};

/// One iteration as it went.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Iteration {
    /// Largest residual of any equation before the step.
    pub imbalance: f64,
    /// Largest relative correction.
    pub correction: f64,
    /// Fraction of the Newton step that was taken.
    pub step: f64,
}

/// Rows of [`history_table`] at the start and at the end.
const ROWS: usize = 6;

/// The iterations as lines of a table: the first and the last ones where there are many.
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

/// A motion that nothing resists.
#[derive(Clone, PartialEq, Debug)]
pub struct FreeMotion {
    /// The part that moves most.
    pub part: Name,
    /// Other parts that take part in it.
    pub others: Vec<Name>,
    /// What moves how: `spins freely about the line MARKER/13-MARKER/15`.
    pub motion: String,
    /// Direction of the translation or of the rotation axis, ground axes.
    pub axis: Vec3,
    /// What little holds it; `None` if nothing does.
    pub weak: Option<Weak>,
}

/// A stiffness that is lost in the round-off of others.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Weak {
    /// Force per length, or torque per angle.
    pub stiffness: f64,
    /// Its share of the largest that the part has.
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

/// A part that went so far in one solution that the equilibrium may be another than the one that is meant.
#[derive(Clone, PartialEq, Debug)]
pub struct Far {
    /// The part.
    pub part: Name,
    /// What its centre moved by: length units.
    pub shift: f64,
    /// What it turned by: radians.
    pub turn: f64,
}

impl Far {
    /// Radians from which a turn is a far one.
    pub(super) const TURN: f64 = std::f64::consts::FRAC_PI_3;

    /// What it did, in words: `PART/4 'KNUCKLE' turned by 118 degrees`.
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

/// How a converged solve went.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Report {
    /// Iterations in all, those of continuation included.
    pub iterations: usize,
    /// How many of them worked out and factored a new Jacobian; the others used an earlier one.
    pub factorisations: usize,
    /// Largest residual of any equation at the end.
    pub imbalance: f64,
    /// Largest relative correction of the last iteration.
    pub correction: f64,
    /// Every iteration of the last sequence.
    pub history: Vec<Iteration>,
    /// Motions nothing resists, harmless because nothing drives them and mass holds them.
    pub free_motions: Vec<FreeMotion>,
    /// Redundant constraint equations that were removed, as `Zi.Xj in JOINT/4`.
    pub redundant: Vec<EquationName>,
    /// How the equilibrium was reached if not by plain iteration.
    pub continuation: Option<Continuation>,
    /// True if IMBALANCE is below what round-off allows in this model: the iteration went as far as it can.
    pub at_roundoff: bool,
    /// Iterations whose step was shortened beyond TLIMIT and ALIMIT.
    pub shortened: usize,
    /// What is left of the forces on each part, summed anew at the end.
    pub balance: Balance,
    /// Parts that turned by more than 60 degrees or moved by more than the mechanism's size.
    pub far: Vec<Far>,
}

/// Help that was needed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Continuation {
    /// The imbalance of the start was released in so many steps.
    Load {
        /// How many.
        steps: usize,
    },
    /// Motions were slowed down as by a damper, less and less.
    Damped,
}

/// Why there is no equilibrium.
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
        /// Its imbalance.
        imbalance: f64,
        /// Every iteration of the last sequence.
        history: Vec<Iteration>,
        /// Usual causes that are present in this model.
        causes: Vec<String>,
    },
    /// A massless part moves without any resistance.
    #[error("{0}: {lacks}", lacks = .0.lacks())]
    FreeMotion(Box<FreeMotion>),
    /// A removed constraint equation is violated where the others hold.
    #[error("{equation} contradicts the other constraints: it is violated by {violation:.3e}")]
    Inconsistent {
        /// The equation, as `Zi.Xj in JOINT/4`.
        equation: String,
        /// Its residual.
        violation: f64,
    },
    /// The iteration ended, but forces that are summed anew do not cancel.
    #[error("the forces of this equilibrium do not cancel when they are summed anew: {0} is left")]
    Unbalanced(Box<Balance>),
    /// An element has no value in this configuration.
    #[error(transparent)]
    NoValue(#[from] NoValue),
}
