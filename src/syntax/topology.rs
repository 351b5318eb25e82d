//! References from statements of a dataset to other objects, and the body that carries each marker.

use std::collections::{BTreeMap, BTreeSet};

use super::{Argument, Dataset, Number, Statement, Value};
use crate::grammar::ValueKind;
use crate::text::{Edit, Span};

/// A reference to an object by its id, in an argument or in a function. An id of zero means ground or no object and is not a reference.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Reference {
    /// Id space of the object, for example `marker`, `part` or `joint`.
    pub space: &'static str,
    /// Id of the object.
    pub id: u32,
    /// Location of the id.
    pub span: Span,
}

/// Identity of an object: its id space and its id.
pub type ObjectId = (&'static str, u32);

impl Argument {
    /// Returns the objects to which the argument refers.
    pub fn references(&self) -> Vec<Reference> {
        let as_reference = |space, number: &Number| {
            Some(Reference {
                space,
                id: number.as_id()?,
                span: number.span,
            })
        };
        match (&self.value, self.def.map(|def| def.kind)) {
            (Value::Numbers(numbers), Some(ValueKind::Reference(space))) => numbers
                .iter()
                .filter_map(|number| as_reference(space, number))
                .collect(),
            (Value::Function(expression), _) => expression
                .references()
                .into_iter()
                .filter_map(|(space, literal)| as_reference(space, &expression.literals[literal]))
                .collect(),
            _ => Vec::new(),
        }
    }
}

impl Statement {
    /// Returns the object that the statement defines, if the statement has an id.
    pub fn object(&self) -> Option<ObjectId> {
        Some((self.def?.id?, self.number()?))
    }

    /// Returns true for the kinds of bodies that carry markers: parts, point masses and flexible bodies.
    pub fn is_body(&self) -> bool {
        matches!(
            self.kind(),
            Some("PART" | "POINT_MASS" | "FLEX_BODY" | "FE_PART")
        )
    }
}

/// The body that carries each marker, including markers that name no body.
#[derive(Clone, Debug, Default)]
pub struct Topology {
    bodies: BTreeMap<u32, ObjectId>,
}

impl Topology {
    /// Determines the bodies of all markers of a dataset.
    pub fn of(dataset: &Dataset) -> Self {
        let mut bodies = BTreeMap::new();
        let mut before = None;
        for statement in dataset.statements() {
            if statement.carries_markers() {
                before = statement.object();
            }
            if statement.kind() != Some("MARKER") {
                continue;
            }
            let named = ["PART", "POINT_MASS", "FLEX_BODY", "FE_PART"]
                .iter()
                .find_map(|owner| {
                    let reference = *statement.argument(owner)?.references().first()?;
                    Some((reference.space, reference.id))
                });
            let body = named.or(before.filter(|_| statement.follows_body()));
            if let (Some(id), Some(body)) = (statement.number(), body) {
                bodies.entry(id).or_insert(body);
            }
        }
        Self { bodies }
    }

    /// Returns the body that carries a marker, if the marker exists and has a body.
    pub fn body(&self, marker: u32) -> Option<ObjectId> {
        self.bodies.get(&marker).copied()
    }

    /// Returns the bodies to which an element is attached, each of them once, in the order of its arguments.
    ///
    /// These are the bodies of the markers that its arguments name, and bodies that its arguments name directly. Markers in functions are
    /// not considered, because they are only measured.
    pub fn attached(&self, statement: &Statement) -> Vec<ObjectId> {
        let mut found = Vec::new();
        for argument in &statement.arguments {
            if !matches!(argument.value, Value::Numbers(_)) {
                continue;
            }
            for reference in argument.references() {
                let body = match reference.space {
                    "marker" => self.body(reference.id),
                    "part" | "point_mass" | "flex_body" | "fe_part" => {
                        Some((reference.space, reference.id))
                    }
                    _ => None,
                };
                found.extend(body.filter(|body| !found.contains(body)));
            }
        }
        found
    }
}

/// Statements and arguments that are removed together.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Removal {
    /// Indices of the removed statements.
    pub statements: BTreeSet<usize>,
    /// Removed arguments of statements that stay, as pairs (index of the statement, index of the argument).
    pub arguments: BTreeSet<(usize, usize)>,
}

impl Dataset {
    /// Returns the statements in `removed` together with everything that depends on them: markers on a body, elements on markers, motions
    /// of joints, and so on.
    ///
    /// A body, or a statement without id, is not removed itself. It only loses the arguments that refer to removed objects.
    pub fn dependents(&self, removed: BTreeSet<usize>) -> Removal {
        let topology = Topology::of(self);
        let mut removal = Removal {
            statements: removed,
            arguments: BTreeSet::new(),
        };
        loop {
            let gone: BTreeSet<ObjectId> = removal
                .statements
                .iter()
                .filter_map(|at| self.statements()[*at].object())
                .collect();
            let before = removal.statements.len();
            for (at, statement) in self.statements().iter().enumerate() {
                if removal.statements.contains(&at) {
                    continue;
                }
                let stranded = statement.kind() == Some("MARKER")
                    && statement
                        .number()
                        .and_then(|id| topology.body(id))
                        .is_some_and(|body| gone.contains(&body));
                if stranded {
                    removal.statements.insert(at);
                    continue;
                }
                for (k, argument) in statement.arguments.iter().enumerate() {
                    let hit = argument
                        .references()
                        .iter()
                        .any(|reference| gone.contains(&(reference.space, reference.id)));
                    if hit && (statement.is_body() || statement.object().is_none()) {
                        removal.arguments.insert((at, k));
                    } else if hit {
                        removal.statements.insert(at);
                    }
                }
            }
            if removal.statements.len() == before {
                break;
            }
        }
        removal
            .arguments
            .retain(|(at, _)| !removal.statements.contains(at));
        removal
    }

    /// Returns the edits that carry out a removal.
    pub fn removal_edits(&self, removal: &Removal) -> Vec<Edit> {
        let statements = removal
            .statements
            .iter()
            .map(|at| self.without_statement(&self.statements()[*at]));
        let arguments = removal.arguments.iter().map(|(at, k)| {
            let statement = &self.statements()[*at];
            self.without(statement, &statement.arguments[*k])
        });
        statements.chain(arguments).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::{Source, apply_edits};

    #[test]
    fn what_hangs_on_a_part_goes_with_it() {
        let deck = "t\nPART/1, GROUND\nMARKER/10, PART=1\nPART/2, MASS=1, CM=20\nMARKER/20\nMARKER/21, PART=2\nPART/3, MASS=1, CM=21\n\
                    MARKER/30, PART=3\nJOINT/1, REVOLUTE, I=20, J=10\nJOINT/2, REVOLUTE, I=30, J=10\nMOTION/1, JOINT=1, FUNCTION=TIME\n\
                    VARIABLE/1, FUNCTION=AZ(21,10)\nSFORCE/1, I=30, J=10, ROT, FUNCTION=VARVAL(1)\nSFORCE/2, I=30, J=10, ROT, FUNCTION=TIME\nEND\n";
        let dataset = Dataset::parse(Source::new("a", deck.as_bytes())).value;
        let part = dataset.position("PART", Some(2)).expect("there");
        let removal = dataset.dependents([part].into());
        let bytes = apply_edits(dataset.bytes(), &dataset.removal_edits(&removal)).expect("apart");
        assert_eq!(
            String::from_utf8_lossy(&bytes),
            "t\nPART/1, GROUND\nMARKER/10, PART=1\nPART/3, MASS=1\nMARKER/30, PART=3\nJOINT/2, REVOLUTE, I=30, J=10\n\
             SFORCE/2, I=30, J=10, ROT, FUNCTION=TIME\nEND\n"
        );
    }
}
