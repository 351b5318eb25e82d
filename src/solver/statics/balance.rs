//! Remaining force and torque on each part, summed independently of the residual of Newton's method.

use std::fmt;

use serde::Serialize;

use crate::mechanics::{Vec3, exceeds};
use crate::model::PartIx;
use crate::system::{Name, NoValue, Parameters, Scratch, State, System};
use admire_syntax::units::{Dimension, Units};

/// Remaining force or torque that round-off explains, as a share of the largest sum of load magnitudes on a part.
const ROUND_OFF: f64 = 1e-9;
/// Remaining torque that round-off of lever arms explains, as a share of the largest sum of force magnitudes times the model's length.
const ARMS: f64 = 1e-12;
/// Allowed remaining force or torque, as a multiple of IMBALANCE. It exceeds one because IMBALANCE applies to single components.
const COMPONENTS: f64 = 10.0;

/// Remaining force or torque on one part.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Left {
    /// Magnitude of the force or torque.
    #[serde(rename = "left")]
    pub size: f64,
    /// Part that the force or torque acts on.
    #[serde(serialize_with = "in_words")]
    pub part: Name,
}

fn in_words<S: serde::Serializer>(name: &Name, out: S) -> Result<S::Ok, S::Error> {
    out.collect_str(name)
}

/// Largest remaining force and largest remaining torque on any part, in units of the deck (force, and force times length).
///
/// They are summed from the individual loads of the free-body diagrams, with torques about the centres of the parts. The residual that Newton's
/// method reduces to zero is computed in another way, so these sums check it.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Balance {
    /// Largest remaining force; `None` if no part can move.
    pub force: Option<Left>,
    /// Largest remaining torque; `None` if no part can rotate.
    pub torque: Option<Left>,
    /// Largest sum of the magnitudes of all forces on one part.
    #[serde(skip)]
    forces: f64,
    /// Largest sum of the magnitudes of all torques on one part, plus an allowance for round-off of lever arms.
    #[serde(skip)]
    torques: f64,
}

/// Sums of the loads on one part.
#[derive(Clone, Debug, Default)]
pub(super) struct Sum {
    force: Vec3,
    torque: Vec3,
    /// Sum of the magnitudes of the forces.
    forces: f64,
    /// Sum of the magnitudes of the torques.
    torques: f64,
}

impl Balance {
    /// Sums the loads on every part and finds the largest remaining force and torque.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this state.
    pub fn of(
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Self, NoValue> {
        Self::summed(system, parameters, state, scratch, &mut Vec::new())
    }

    /// Does the same as [`Self::of`] with existing work space for the sums.
    pub(super) fn summed(
        system: &System,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        sums: &mut Vec<Sum>,
    ) -> Result<Self, NoValue> {
        sums.clear();
        sums.resize(system.bodies.len(), Sum::default());
        system
            .evaluate(parameters, state, scratch)?
            .each_load(|load| {
                let part = load.part.0;
                let torque = load.torque_about(&system.reference_point(state, load.part));
                let sum = &mut sums[part];
                sum.force += load.force;
                sum.torque += torque;
                sum.forces += load.force.norm();
                sum.torques += torque.norm();
            })?;
        let mut out = Self::default();
        let (mut force, mut torque) = (None, None);
        for (part, body) in system.bodies.iter().enumerate() {
            let left = |size: f64, before: &mut Option<(f64, usize)>| {
                if before.is_none_or(|(most, _)| exceeds(size, most)) {
                    *before = Some((size, part));
                }
            };
            if body.freedoms >= 3 {
                left(sums[part].force.norm(), &mut force);
                out.forces = out.forces.max(sums[part].forces);
            }
            if body.freedoms == 6 {
                left(sums[part].torque.norm(), &mut torque);
                out.torques = out.torques.max(sums[part].torques);
            }
        }
        out.torques += ARMS / ROUND_OFF * system.length * out.forces;
        let named = |(size, part): (f64, usize)| Left {
            size,
            part: system.part_name(PartIx(part)).clone(),
        };
        out.force = force.map(named);
        out.torque = torque.map(named);
        Ok(out)
    }

    /// Returns true if IMBALANCE and round-off explain the remaining force and torque.
    pub fn holds(&self, imbalance: f64) -> bool {
        let within = |left: &Option<Left>, sizes: f64| {
            let most = COMPONENTS * imbalance + ROUND_OFF * sizes;
            left.as_ref().is_none_or(|left| left.size <= most)
        };
        within(&self.force, self.forces) && within(&self.torque, self.torques)
    }

    /// Keeps the larger remaining force and the larger remaining torque of two balances.
    pub fn or_worse(&mut self, other: &Self) {
        let larger = |own: &mut Option<Left>, other: &Option<Left>| {
            let most = own.as_ref().map_or(-1.0, |own| own.size);
            if other
                .as_ref()
                .is_some_and(|other| exceeds(other.size, most))
            {
                own.clone_from(other);
            }
        };
        larger(&mut self.force, &other.force);
        larger(&mut self.torque, &other.torque);
        self.forces = self.forces.max(other.forces);
        self.torques = self.torques.max(other.torques);
    }

    /// Describes the remaining force and torque, for example `1.2e-10 N on PART/2, 3.0e-09 N mm on PART/3`. The text is empty if no part can
    /// move.
    pub fn describe(&self, units: &Units) -> String {
        let kinds = [
            (&self.force, Dimension::FORCE),
            (&self.torque, Dimension::TORQUE),
        ];
        let told = kinds.into_iter().filter_map(|(left, dimension)| {
            let left = left.as_ref()?;
            let unit = units.name(dimension);
            Some(format!("{:.1e} {unit} on {}", left.size, left.part))
        });
        told.collect::<Vec<_>>().join(", ")
    }
}

impl fmt::Display for Balance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [("a force", &self.force), ("a torque", &self.torque)];
        let told = kinds.into_iter().filter_map(|(what, left)| {
            let left = left.as_ref()?;
            Some(format!("{what} of {:.3e} on {}", left.size, left.part))
        });
        f.write_str(&told.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::statics::{Solver, StaticSettings};
    use admire_syntax::Dataset;
    use admire_syntax::text::Source;

    /// A block of 2 kg on a spring of 10 N/mm: k x = m g. Next to the equilibrium, the remaining force is k times the distance from it.
    const DECK: &str = "A block on a spring
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
MARKER/11, PART=1, QP=0, 0, 200
PART/2, MASS=2, CM=20, IP=100, 100, 100
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
SPRINGDAMPER/1, TRANSLATIONAL, I=20, J=11, K=10, LENGTH=200
ACCGRAV/KGRAV=-9810
END
";

    #[test]
    fn what_is_beside_an_equilibrium_is_refused() {
        let parsed = Dataset::parse(Source::new("deck", DECK));
        let model = Model::lower(&parsed.value).value;
        let system = System::compile(&model).value;
        let (parameters, mut state) = (system.parameters(), system.state());
        let mut solver = Solver::new(&system);
        let settings = StaticSettings::tight();
        let report = solver
            .solve(&system, &parameters, &mut state, &settings)
            .unwrap();
        assert!(report.balance.holds(settings.imbalance));
        assert!(report.balance.force.as_ref().unwrap().size < 1e-8);
        assert_eq!(solver.worst_balance(), Some(&report.balance));
        for (away, told) in [(1e-6, 1e-5), (-0.5, 5.0)] {
            let mut wrong = state.clone();
            wrong.poses[1].p.z += away;
            let mut scratch = Scratch::new(&system);
            let left = Balance::of(&system, &parameters, &wrong, &mut scratch).unwrap();
            let force = left.force.as_ref().unwrap();
            assert!((force.size - told).abs() < 1e-6 * told, "{left}");
            assert_eq!(force.part.to_string(), "PART/2");
            assert!(!left.holds(settings.imbalance), "{left}");
            // A false solution is refused in fits and sweeps as in a single run.
            let refused =
                solver.check_balance(&system, &parameters, &wrong, &settings, &mut report.clone());
            let Err(crate::statics::SolveError::Unbalanced(found)) = refused else {
                panic!("{refused:?}");
            };
            assert_eq!(*found, left);
        }
        assert_eq!(solver.worst_balance(), Some(&report.balance));
    }
}
