//! What constrains reads through variables: what their functions read moves with it, and its reaction acts on that.

use std::collections::BTreeMap;

use super::Compiler;
use crate::diagnostic::{Code, Diagnostic};
use crate::system::compiled_function::{Source, reads_velocities};
use crate::system::structure::{Drive, Joint};

impl Compiler<'_> {
    /// Puts copies of the functions of variables in the place of the variables that the functions of GCONs and MOTIONs read, those of the
    /// time alone and those that read themselves excepted. After [`Compiler::sources`].
    pub(super) fn read_through_variables(&mut self) {
        let mut copies = BTreeMap::new();
        let of_joint = |joint: &Joint| match joint.drive {
            Drive::Function(function) => Some(function),
            _ => None,
        };
        let mut constrained: Vec<usize> = self.joints.iter().filter_map(of_joint).collect();
        constrained.extend(self.conditions.iter().map(|c| c.function));
        for function in constrained {
            self.read_through(function, &mut copies);
        }
        for condition in self.conditions.iter().filter(|c| c.active) {
            let owner = &condition.name;
            if reads_velocities(&self.functions, condition.function) {
                self.diagnostics.push(
                    Diagnostic::warning(
                        Code::InactiveInStatics,
                        format!("{owner} holds velocities, which are zero in statics: it is left out there"),
                    )
                    .about(owner.object())
                    .help("what it keeps from slipping in a motion is held by nothing in an equilibrium"),
                );
            }
        }
    }

    /// `copies` has the copy of every variable's function so far; none while it is being made.
    fn read_through(&mut self, function: usize, copies: &mut BTreeMap<usize, Option<usize>>) {
        for at in 0..self.functions[function].sources.len() {
            let Source::Variable(variable) = self.functions[function].sources[at] else {
                continue;
            };
            if self.is_of_time(variable, &mut vec![false; self.variables.len()]) {
                continue;
            }
            let copy = match copies.get(&variable) {
                Some(Some(copy)) => *copy,
                // It reads itself.
                Some(None) => continue,
                None => {
                    copies.insert(variable, None);
                    let copy = self.functions.len();
                    let own = self.functions[self.variables[variable].function].clone();
                    self.functions.push(own);
                    self.read_through(copy, copies);
                    copies.insert(variable, Some(copy));
                    copy
                }
            };
            self.functions[function].sources[at] = Source::Through {
                variable,
                function: copy,
            };
        }
    }

    /// True if a variable depends on nothing but the time.
    fn is_of_time(&self, variable: usize, seen: &mut [bool]) -> bool {
        if std::mem::replace(&mut seen[variable], true) {
            return true;
        }
        let function = &self.functions[self.variables[variable].function];
        function.sources.iter().all(|source| match source {
            Source::Time | Source::Mode | Source::Constant(_) | Source::Sensor(_) => true,
            Source::Variable(read) => self.is_of_time(*read, seen),
            _ => false,
        })
    }
}
