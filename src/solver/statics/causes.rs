//! Search of a model for the usual reasons why an iteration finds no equilibrium. The search does not depend on the iteration method.

use std::collections::BTreeMap;

use super::StaticSettings;
use super::rank::{FREE, free_motion, free_motions, motion_of};
use super::report::FreeMotion;
use crate::function::Program;
use crate::linear::{Lu, Matrix};
use crate::system::{Load, Parameters, Scratch, State, System};

/// Joint equations whose violation exceeds this share of the model's length count as open.
const OPEN: f64 = 1e-3;
/// A free motion counts as driven if the residual does more work along it than this share of the summed magnitudes of the work terms.
const DRIVEN: f64 = 1e-9;
/// Joint equations whose violation is below this share of the model's length count as closed.
const CLOSED: f64 = 1e-6;
/// Largest number of causes of one kind that are listed. Further causes of this kind are only counted.
const TOLD: usize = 3;

/// Wording for the weight of a part.
const WEIGHT: &str = "the weight of ";

/// Data available after an iteration has failed.
pub(super) struct Ended<'a> {
    pub system: &'a System,
    pub parameters: &'a Parameters,
    pub start: &'a State,
    pub end: &'a State,
    /// Residual at the end of the iteration.
    pub g: &'a [f64],
    /// Jacobian that was assembled last.
    pub matrix: &'a Matrix,
    /// Factors of this Jacobian or of an earlier one.
    pub factors: &'a Lu,
    /// True if all iterations that MAXIT allows were used.
    pub spent: bool,
    /// Number of Newton steps that were cut to TLIMIT or ALIMIT.
    pub limited: usize,
    pub settings: &'a StaticSettings,
}

impl Ended<'_> {
    /// Returns descriptions of all causes that are found. Returns a massless free motion as an error, because it explains the failure by
    /// itself.
    pub(crate) fn causes(&self, scratch: &mut Scratch) -> Result<Vec<String>, FreeMotion> {
        let mut out = Vec::new();
        self.free_motions(scratch, &mut out)?;
        if let Some(most) = self.settings.budget.filter(|_| self.spent) {
            out.push(format!("the iteration reached MAXIT={most}"));
        }
        self.open_joints(scratch, &mut out);
        if self.limited > 0 {
            let steps = if self.limited == 1 {
                "step was"
            } else {
                "steps were"
            };
            out.push(format!(
                "{} {steps} cut to TLIMIT={} or ALIMIT={} degrees: the start is far from equilibrium",
                self.limited,
                self.settings.tlimit,
                self.settings.alimit.to_degrees().round()
            ));
        }
        self.large_angles(scratch, &mut out);
        self.steady_rates(&mut out);
        self.kinks(&mut out);
        Ok(out)
    }

    fn free_motions(&self, scratch: &mut Scratch, out: &mut Vec<String>) -> Result<(), FreeMotion> {
        let mut told = Vec::new();
        // If joints are open, the parts cannot perform the motion. The loads that drive the motion are then not named.
        let equations = &self.g[self.system.first_equation..self.system.first_variable];
        let closed = equations
            .iter()
            .all(|gap| gap.abs() < CLOSED * self.system.length);
        let (system, parameters) = (self.system, self.parameters);
        free_motions(system, parameters, self.end, self.matrix, self.factors)
            .map_err(|massless| *massless)?;
        for m in 0..self.factors.deficiency() {
            let z = self.factors.null_vector(m);
            let Some(motion) = free_motion(system, parameters, self.end, self.matrix, &z) else {
                continue;
            };
            // The Jacobian is almost symmetric. The linear equations therefore have a solution only if the residual does no work along a free
            // motion. Residuals of open joints do work with the multipliers.
            let (mut work, mut size) = (0.0, 0.0);
            for k in 0..self.system.first_variable {
                work += self.g[k] * z[k];
                size += (self.g[k] * z[k]).abs();
            }
            if f64::abs(work) > DRIVEN * size {
                let drivers = if closed {
                    self.drivers(&z, scratch)
                } else {
                    None
                };
                let by = drivers.unwrap_or_else(|| "an unidentified load".to_string());
                // An arm that starts horizontal has no stiffness there, but gains some as soon as it has fallen a little.
                let level = if by.contains(WEIGHT) && motion.motion.starts_with(FREE.about) {
                    "; if this is so only at the start, change the start positions"
                } else {
                    ""
                };
                told.push(format!("{motion}; this motion is driven by {by}{level}"));
            }
        }
        some(told, out);
        Ok(())
    }

    /// Describes the loads that do work along a motion. Returns `None` if there are none.
    fn drivers(&self, z: &[f64], scratch: &mut Scratch) -> Option<String> {
        let (system, parameters, state) = (self.system, self.parameters, self.end);
        let mut here = system.evaluate(parameters, state, scratch).ok()?;
        let loads = here.loads().ok()?;
        let by = |load: &Load<'_>| match load.by {
            Some(name) => name.to_string(),
            None => format!("{WEIGHT}{}", system.bodies[load.part.0].name),
        };
        let speed = |load: &Load<'_>| {
            let (v, w) = motion_of(system, load.part.0, z);
            let arm = load.point - system.reference_point(state, load.part);
            (v + w.cross(&arm), w)
        };
        let mut powers: BTreeMap<String, f64> = BTreeMap::new();
        for load in &loads {
            let (v, w) = speed(load);
            *powers.entry(by(load)).or_default() += load.force.dot(&v) + load.torque.dot(&w);
        }
        // Elements that only transmit forces do no work in total.
        let most = powers.values().fold(0.0_f64, |a, p| a.max(p.abs()));
        powers.retain(|_, power| power.abs() > 1e-6 * most);
        let names: Vec<&str> = powers.keys().map(String::as_str).collect();
        Some(match names.as_slice() {
            [] => return None,
            [one] => (*one).to_string(),
            [all @ .., last] if all.len() < TOLD => {
                format!("{} and {last}", all.join(", "))
            }
            [first, ..] => format!("{first} and {} others", names.len() - 1),
        })
    }

    fn open_joints(&self, scratch: &mut Scratch, out: &mut Vec<String>) {
        let mut g = vec![0.0; self.system.unknowns()];
        let (system, parameters) = (self.system, self.parameters);
        if system
            .residual(parameters, self.start, scratch, &mut g)
            .is_err()
        {
            return;
        }
        let mut told = Vec::new();
        for k in 0..system.equations {
            let gap = g[system.first_equation + k];
            if self.start.redundant.get(k) != Some(&true) && gap.abs() > OPEN * system.length {
                let equation = system.constraint_equation_name(k);
                told.push(format!("{equation} is violated by {gap:.3} at the start, in length units of the deck or rad"));
            }
        }
        some(told, out);
    }

    /// Reports bushings, fields and beams that are rotated by more than 1 rad about x or y of the J marker. The law of such an element is
    /// not meaningful at these projected angles (guide/formats.md 2.7).
    fn large_angles(&self, scratch: &mut Scratch, out: &mut Vec<String>) {
        let mut here = self.system.at(self.parameters, self.end, scratch);
        here.place_markers();
        let mut told = Vec::new();
        for element in self.system.elements.iter().filter(|e| e.active) {
            if !matches!(element.name.kind, "BUSHING" | "FIELD" | "BEAM") {
                continue;
            }
            let angles = here.motion(element.i, element.j, element.pair, true).angles;
            let worst = angles.x.abs().max(angles.y.abs());
            if worst > 1.0 {
                told.push(format!(
                    "I of {} is rotated by {:.0} degrees about x or y of J: the projected angles of its force law are not valid there",
                    element.name,
                    worst.to_degrees()
                ));
            }
        }
        some(told, out);
    }

    /// Reports states whose rate is a nonzero constant. A model with such a state has no equilibrium, because in an equilibrium all rates are zero.
    fn steady_rates(&self, out: &mut Vec<String>) {
        let system = self.system;
        let mut depends = vec![false; self.g.len()];
        for (row, _, value) in self.matrix.entries() {
            depends[row] |= value != 0.0;
        }
        let states = system.first_state()..self.g.len();
        let steady = states.filter(|&row| !depends[row] && self.g[row] != 0.0);
        let told = steady.map(|row| {
            format!(
                "the rate of {} is constant here, {:.4e} per unit of time: the state has no equilibrium; STATIC_HOLD keeps it at its value in statics",
                system.equation_name(row),
                self.g[row]
            )
        });
        some(told.collect(), out);
    }

    fn kinks(&self, out: &mut Vec<String>) {
        let told = self
            .system
            .order
            .iter()
            .map(|&f| &self.system.functions[f])
            .filter(|f| f.program.as_ref().is_some_and(Program::has_branches))
            .map(|f| {
                format!(
                    "the function of {} has an IF: the iteration may fail at a jump or kink of the function",
                    f.owner
                )
            })
            .collect();
        some(told, out);
    }
}

fn some(mut told: Vec<String>, out: &mut Vec<String>) {
    let more = told.len().saturating_sub(TOLD);
    told.truncate(TOLD);
    if let (Some(last), true) = (told.last_mut(), more > 0) {
        *last += &format!(" (and {more} more like this)");
    }
    out.append(&mut told);
}
