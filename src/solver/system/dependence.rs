//! Dependencies between functions. They determine which VARIABLEs are unknowns, and the evaluation order of all other functions.
//!
//! A VARIABLE is given explicitly by its function, unless the function reads the VARIABLE itself: directly, through other VARIABLEs or
//! through forces. Such an algebraic loop is solved as part of the equations.

use std::collections::BTreeSet;

use super::System;
use super::compiled_function::{CompiledFunction, Exerted, Source};
use super::structure::{Action, ConstraintEquation, Element, ParameterSource, VariableEquation};

/// Objects through which functions depend on each other.
#[derive(Clone, Copy)]
pub(crate) struct Reads<'a> {
    pub functions: &'a [CompiledFunction],
    pub variables: &'a [VariableEquation],
    pub elements: &'a [Element],
    pub joints: &'a [ConstraintEquation],
}

impl Reads<'_> {
    /// Returns the functions whose values a function needs: the functions of explicit VARIABLEs, of measured forces and of rates of held
    /// states.
    pub(crate) fn of(&self, function: usize) -> Vec<usize> {
        let mut out = Vec::new();
        for source in &self.functions[function].sources {
            match source {
                Source::Variable(k) => out.extend(self.explicit(*k)),
                Source::Output((_, by_variable)) => {
                    out.extend(by_variable.iter().filter_map(|(k, _)| self.explicit(*k)));
                }
                Source::StateRate(_, Some(function)) => out.push(*function),
                Source::Force(force) => {
                    for (who, _) in &force.by {
                        self.push_driving(*who, &mut out);
                    }
                }
                _ => {}
            }
        }
        out
    }

    /// Returns the function of a VARIABLE if the VARIABLE is active and not an unknown.
    pub(crate) fn explicit(&self, variable: usize) -> Option<usize> {
        let variable = &self.variables[variable];
        (variable.active && variable.unknown.is_none()).then_some(variable.function)
    }

    /// Appends the functions that determine a force, given the object that exerts it.
    fn push_driving(&self, who: Exerted, out: &mut Vec<usize>) {
        match who {
            Exerted::Element(k) => self.push_element(&self.elements[k], out),
            Exerted::Joint(k, _) => {
                if let ParameterSource::Function(function) = self.joints[k].drive {
                    out.push(function);
                }
            }
            Exerted::Multi(..) => {}
        }
    }

    /// Appends the functions of an active element.
    pub(crate) fn push_element(&self, element: &Element, out: &mut Vec<usize>) {
        if !element.active {
            return;
        }
        match &element.action {
            Action::Law(_, ParameterSource::Function(function)) => out.push(*function),
            Action::Law(..) => {}
            Action::Vector(components) => out.extend(components.iter().flatten()),
        }
    }

    /// Returns a function and the functions of the VARIABLEs that it reads, directly or through other VARIABLEs. VARIABLEs that are
    /// unknowns are included only if `unknowns` is set.
    pub(crate) fn through_variables(&self, function: usize, unknowns: bool) -> BTreeSet<usize> {
        let mut seen = BTreeSet::new();
        let mut open = vec![function];
        while let Some(function) = open.pop() {
            if !seen.insert(function) {
                continue;
            }
            let mut read = |k: usize| {
                let variable = &self.variables[k];
                if variable.active && (unknowns || variable.unknown.is_none()) {
                    open.push(variable.function);
                }
            };
            for source in &self.functions[function].sources {
                match source {
                    Source::Variable(k) => read(*k),
                    Source::Output((_, by_variable)) => {
                        for (k, _) in by_variable {
                            read(*k);
                        }
                    }
                    _ => {}
                }
            }
        }
        seen
    }

    /// Returns whether any source of a function, or any source of the explicit VARIABLEs that the function reads, satisfies `is`.
    pub(crate) fn any(&self, function: usize, is: impl Fn(&Source) -> bool) -> bool {
        let all = self.through_variables(function, false);
        let mut sources = all.iter().flat_map(|&f| &self.functions[f].sources);
        sources.any(is)
    }

    /// Returns whether a function reads velocities of markers.
    pub(crate) fn velocities(&self, function: usize) -> bool {
        self.any(
            function,
            |source| matches!(source, Source::Moved(measure) if !measure.kind.is_second()),
        )
    }

    /// Returns whether a function depends on time alone.
    pub(crate) fn only_time(&self, function: usize) -> bool {
        !self.any(function, |source| match source {
            Source::Time | Source::Mode | Source::Constant(_) | Source::Sensor(_) => false,
            Source::Variable(k) => self.variables[*k].unknown.is_some(),
            _ => true,
        })
    }

    /// Returns the functions that `roots` need, including the roots, grouped into sets. Functions that depend on each other form one set,
    /// and each set comes after the sets that it needs.
    pub(crate) fn components(&self, roots: impl IntoIterator<Item = usize>) -> Vec<Vec<usize>> {
        components(self.functions.len(), roots, |function| self.of(function))
    }

    /// Returns whether a set of [`Self::components`] is a loop: its functions depend on themselves.
    pub(crate) fn is_loop(&self, component: &[usize]) -> bool {
        match component {
            [function] => self.of(*function).contains(function),
            _ => true,
        }
    }
}

/// Returns the strongly connected components, each after the components to which it has edges. The algorithm is not recursive (R. Tarjan,
/// Depth-first search and linear graph algorithms, SIAM J. Comput. 1, 1972).
fn components(
    count: usize,
    roots: impl IntoIterator<Item = usize>,
    edges: impl Fn(usize) -> Vec<usize>,
) -> Vec<Vec<usize>> {
    const NEW: usize = usize::MAX;
    let (mut found, mut lowest) = (vec![NEW; count], vec![0; count]);
    let mut waiting = vec![false; count];
    let mut stack = Vec::new();
    let mut out = Vec::new();
    let mut next = 0;
    for root in roots {
        if found[root] != NEW {
            continue;
        }
        let mut path: Vec<(usize, Vec<usize>)> = Vec::new();
        let mut entered = Some(root);
        loop {
            if let Some(node) = entered.take() {
                (found[node], lowest[node]) = (next, next);
                next += 1;
                stack.push(node);
                waiting[node] = true;
                path.push((node, edges(node)));
            }
            let Some((node, open)) = path.last_mut() else {
                break;
            };
            let node = *node;
            if let Some(to) = open.pop() {
                if found[to] == NEW {
                    entered = Some(to);
                } else if waiting[to] {
                    lowest[node] = lowest[node].min(found[to]);
                }
                continue;
            }
            path.pop();
            if let Some((before, _)) = path.last() {
                lowest[*before] = lowest[*before].min(lowest[node]);
            }
            if lowest[node] == found[node] {
                let mut component = Vec::new();
                while let Some(member) = stack.pop() {
                    waiting[member] = false;
                    component.push(member);
                    if member == node {
                        break;
                    }
                }
                component.sort_unstable();
                out.push(component);
            }
        }
    }
    out
}

impl System {
    pub(crate) fn reads(&self) -> Reads<'_> {
        Reads {
            functions: &self.functions,
            variables: &self.variables,
            elements: &self.elements,
            joints: &self.joints,
        }
    }

    /// Returns the index of the first unknown that is a dynamic state. The dynamic states follow the unknown VARIABLEs.
    pub(crate) fn first_state(&self) -> usize {
        self.first_variable + self.implicit.len()
    }

    /// Returns the VARIABLEs that are unknowns, with the index of the unknown.
    pub(crate) fn implicit_variables(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let all = self.implicit.iter().enumerate();
        all.map(|(k, &variable)| (variable, self.first_variable + k))
    }

    /// Returns whether functions of the equations read reactions, states or unknown VARIABLEs. Only a solution provides these values.
    pub(crate) fn reads_solution(&self) -> bool {
        let mut sources = self.order.iter().flat_map(|&f| &self.functions[f].sources);
        sources.any(|source| match source {
            Source::Force(_)
            | Source::Friction(..)
            | Source::State(_)
            | Source::StateRate(..)
            | Source::Output(_) => true,
            Source::Variable(k) => self.variables[*k].unknown.is_some(),
            _ => false,
        })
    }

    /// Returns a function and the functions of the explicit VARIABLEs that it reads, in evaluation order.
    pub(crate) fn in_turn(&self, function: usize) -> Vec<usize> {
        let all = self.reads().through_variables(function, false);
        let mut all: Vec<usize> = all.into_iter().collect();
        all.sort_unstable_by_key(|&f| self.ranks[f]);
        all
    }

    /// Returns the functions of active MOTIONs and GCONs.
    pub(crate) fn constraining(&self) -> impl Iterator<Item = usize> + '_ {
        let joints = self.joints.iter().filter(|joint| joint.active);
        let driven = joints.filter_map(|joint| match joint.drive {
            ParameterSource::Function(function) => Some(function),
            ParameterSource::Rate(drive) => Some(drive.function),
            ParameterSource::Theta(_) | ParameterSource::Constant(_) => None,
        });
        let conditions = self.conditions.iter().filter(|c| c.active);
        driven.chain(conditions.map(|c| c.function))
    }

    /// Returns whether an active MOTION or GCON reads a VARIABLE, directly or through other VARIABLEs.
    pub fn constrains(&self, variable: usize) -> bool {
        let (reads, function) = (self.reads(), self.variables[variable].function);
        let mut all = self.constraining();
        all.any(|read| reads.through_variables(read, true).contains(&function))
    }
}

#[cfg(test)]
mod tests {
    use super::components;

    #[test]
    fn every_component_comes_after_those_it_reads() {
        // Edges: 0 -> 1 -> 2 -> 1, 0 -> 3, 4 -> 4, 5 -> 0.
        let edges = [vec![1, 3], vec![2], vec![1], vec![], vec![4], vec![0]];
        let found = components(6, 0..6, |node| edges[node].clone());
        assert_eq!(found.len(), 5);
        let place = |node: usize| found.iter().position(|set| set.contains(&node)).unwrap();
        assert_eq!(place(1), place(2));
        for (node, to) in edges.iter().enumerate() {
            assert!(to.iter().all(|to| place(*to) <= place(node)));
        }
        // Because the search is not recursive, a chain may have any length.
        let long = components(200_000, 0..1, |node| {
            (node + 1 < 200_000)
                .then_some(node + 1)
                .into_iter()
                .collect()
        });
        assert_eq!(long.len(), 200_000);
        assert_eq!(long[0], [199_999]);
    }
}
