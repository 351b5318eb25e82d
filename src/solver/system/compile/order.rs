//! Evaluation order of the functions: which functions the equations need, and which VARIABLEs are unknowns.

use std::collections::BTreeSet;

use super::SystemCompiler;
use crate::system::compiled_function::Source;
use crate::system::dependence::Reads;
use crate::system::structure::{ParameterSource, StateRhs, Switch};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Evaluation order of the functions.
pub(super) struct Order {
    /// Functions that the equations need, in evaluation order.
    pub equations: Vec<usize>,
    /// Functions that the constraint equations need, in evaluation order.
    pub constraints: Vec<usize>,
    /// Whether constraint equations read states or unknown VARIABLEs.
    pub data_constrain: bool,
    /// Rank of every function in an evaluation order of all functions.
    pub ranks: Vec<usize>,
    /// VARIABLEs that are unknowns, in the order of their unknowns.
    pub implicit: Vec<usize>,
}

impl SystemCompiler<'_> {
    pub(super) fn reads(&self) -> Reads<'_> {
        Reads {
            functions: &self.functions,
            variables: &self.variables,
            elements: &self.elements,
            joints: &self.joints,
        }
    }

    /// Determines the evaluation order of the functions. Requires [`SystemCompiler::sources`]. VARIABLEs in loops become unknowns, with
    /// indices from `first_variable` on. Loops without a VARIABLE are reported.
    pub(super) fn order(&mut self, first_variable: usize) -> Order {
        let all = 0..self.functions.len();
        let reads = self.reads();
        let looped: BTreeSet<usize> = reads
            .components(all.clone())
            .into_iter()
            .filter(|component| reads.is_loop(component))
            .flatten()
            .collect();
        let mut implicit = Vec::new();
        for (k, variable) in self.variables.iter_mut().enumerate() {
            if variable.active && looped.contains(&variable.function) {
                variable.unknown = Some(first_variable + implicit.len());
                implicit.push(k);
            }
        }
        let reads = self.reads();
        let components = reads.components(all);
        let loops = components.iter().filter(|c| reads.is_loop(c));
        let circles: Vec<Diagnostic> = loops
            .map(|component| {
                let owner = &self.functions[component[0]].owner;
                Diagnostic::error(
                    Code::NotSolvedNatively,
                    format!("the function of {owner} reads its own force"),
                )
                .about(owner.object())
                .help("define the force in a VARIABLE, which may depend on itself")
            })
            .collect();
        let mut ranks = vec![0; self.functions.len()];
        for (rank, function) in components.into_iter().flatten().enumerate() {
            ranks[function] = rank;
        }
        let flat = |roots: Vec<usize>| reads.components(roots).into_iter().flatten().collect();
        let equations: Vec<usize> = flat(self.roots(&implicit));
        let constrained = self.constrained();
        let beyond = |source: &Source| match source {
            Source::State(_) | Source::StateRate(..) | Source::Output(_) => true,
            Source::Variable(k) => self.variables[*k].unknown.is_some(),
            _ => false,
        };
        // If constraints read anything besides positions and time, their rates need all functions of the equations.
        let data_constrain = constrained.iter().any(|&f| reads.any(f, beyond));
        let constraints = if data_constrain {
            equations.clone()
        } else {
            flat(constrained)
        };
        self.diagnostics.extend(circles);
        Order {
            equations,
            constraints,
            data_constrain,
            ranks,
            implicit,
        }
    }

    /// Returns the functions of GCONs, and of MOTIONs that prescribe a displacement.
    fn constrained(&self) -> Vec<usize> {
        let driven = self.joints.iter().filter_map(|joint| match joint.drive {
            ParameterSource::Function(function) => Some(function),
            _ => None,
        });
        let conditions = self.conditions.iter().map(|c| c.function);
        driven.chain(conditions).collect()
    }

    /// Returns the functions that forces, constraints, rates of states, SENSORs and unknown VARIABLEs need.
    fn roots(&self, implicit: &[usize]) -> Vec<usize> {
        let reads = self.reads();
        let mut roots = self.constrained();
        for element in &self.elements {
            reads.push_element(element, &mut roots);
        }
        for rate in self.states.iter().flat_map(|s| [&s.rate, &s.moving]) {
            match rate {
                StateRhs::Function(function) => roots.push(*function),
                StateRhs::Linear(_, by_variable) => {
                    roots.extend(by_variable.iter().filter_map(|(k, _)| reads.explicit(*k)));
                }
                StateRhs::Held => {}
            }
        }
        for (function, evaluate) in &self.sensors {
            for function in std::iter::once(function).chain(evaluate) {
                roots.extend(reads.of(*function));
            }
        }
        roots.extend(implicit.iter().map(|&k| self.variables[k].function));
        roots
    }

    /// Returns the switches of the functions that the equations need, and the times at which functions are not smooth. A time integration
    /// monitors both.
    pub(super) fn watched(&mut self, order: &Order) -> (Vec<Switch>, Vec<f64>) {
        let (mut switches, mut breaks) = (Vec::new(), Vec::new());
        for &number in &order.equations {
            let function = &mut self.functions[number];
            let first = switches.len();
            if let Some(program) = &function.program {
                let all = program.switches().iter().enumerate();
                switches.extend(all.map(|(k, &of_time)| Switch {
                    function: number,
                    of_time,
                    jumps: program.may_jump(k),
                }));
            }
            function.switches = first..switches.len();
            breaks.append(&mut self.breaks[number]);
        }
        // Functions of prescribed rates are integrated separately from the equations.
        let rates = self.joints.iter().filter_map(|joint| match joint.drive {
            ParameterSource::Rate(drive) => Some(drive.function),
            _ => None,
        });
        for function in self.reads().components(rates).into_iter().flatten() {
            breaks.extend(&self.breaks[function]);
        }
        breaks.sort_by(f64::total_cmp);
        (switches, breaks)
    }
}
