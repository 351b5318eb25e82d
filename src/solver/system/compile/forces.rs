//! Compilation of force statements to elements.

use super::{Header, Name, SystemCompiler, name};
use crate::element::{Beam, Damping, ElementLaw, Law, ScalarForce};
use crate::mechanics::{Mat6, Vec6};
use crate::model::{SforceKind, SpringKind, VectorForceKind, law_arguments};
use crate::system::catalogue::{GroupDimensions, Role};
use crate::system::structure::{Action, Element, NForce, ParameterSource};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar;
use admire_syntax::grammar::{Components, LawDef, StatementDef};
use admire_syntax::units::Dimension;

const ANY: f64 = f64::NEG_INFINITY;

impl SystemCompiler<'_> {
    pub(super) fn forces(&mut self) {
        self.laws();
        self.scalar_forces();
        self.vector_forces();
        for n in &self.model.nforces {
            let of = ("NFORCE", Some(n.header.id));
            let size = 6 * n.i.len();
            let start = self.theta.len();
            let role = Role::Multi {
                multi: self.multis.len(),
            };
            let stiffness = (GroupDimensions::MultiStiffness(size), ANY);
            self.numbers(of, Some("KMATRIX"), &n.k, stiffness, role);
            self.numbers(
                of,
                Some("LENGTH"),
                &n.length,
                (GroupDimensions::Of(Components::Motion), ANY),
                role,
            );
            self.numbers(
                of,
                Some("FORCE"),
                &n.force,
                (GroupDimensions::Of(Components::Wrench), ANY),
                role,
            );
            let whole = n.k.len() == size * size && n.length.len() == size && n.force.len() == size;
            if !whole {
                let owner = name("NFORCE", &n.header);
                let message = format!(
                    "the matrices and vectors of {owner} do not fit its number of markers, {}",
                    n.i.len()
                );
                self.diagnostics
                    .push(Diagnostic::error(Code::WrongCount, message).about(owner.object()));
            }
            let i: Vec<usize> = n.i.iter().map(|m| m.0).collect();
            let pairs = i.iter().map(|&i| self.pair(i, n.j.0)).collect();
            self.multis.push(NForce {
                name: name("NFORCE", &n.header),
                i,
                j: n.j.0,
                theta: start..self.theta.len(),
                pairs,
                damping: blocks(&n.damping, n.i.len()),
                active: n.header.active && whole,
            });
        }
    }

    /// Compiles a force that is defined by a law of the grammar. `values` holds the values of the law's arguments.
    fn law(
        &mut self,
        def: &'static StatementDef,
        wanted: &'static LawDef,
        header: &Header,
        (i, j): (usize, usize),
        values: &[f64],
    ) {
        let element = self.elements.len();
        let start = self.theta.len();
        let mut rest = values;
        for argument in law_arguments(def, wanted) {
            let (values, behind) = rest.split_at(argument.count.max.unwrap_or(0));
            rest = behind;
            let role = Role::Law { element };
            self.argument((def.name, Some(header.id)), argument, values, role);
        }
        let law = crate::element::law(wanted.name).expect("a law for every name of the grammar");
        debug_assert_eq!(law.parameter_count(), values.len(), "{}", wanted.name);
        let drive = ParameterSource::Theta(start..self.theta.len());
        let reaction = Some(self.part_of(j));
        let action = Action::Law(ElementLaw::Shared(law), drive);
        self.push_element((def.name, header), (i, j, Some(j)), reaction, action);
    }

    pub(super) fn push_element(
        &mut self,
        (kind, header): (&'static str, &Header),
        (i, j, frame): (usize, usize, Option<usize>),
        reaction: Option<usize>,
        action: Action,
    ) {
        let pair = self.pair(i, j);
        if let Some(frame) = frame {
            self.used[frame] = true;
        }
        self.elements.push(Element {
            name: name(kind, header),
            i,
            j,
            frame,
            reaction,
            action,
            damping: None,
            pair,
            active: header.active,
        });
    }

    /// Sets the damping of the element that was added last.
    pub(super) fn damp(&mut self, damping: Option<Damping>) {
        if let Some(element) = self.elements.last_mut() {
            element.damping = damping;
        }
    }

    /// Compiles all forces defined by a law of the grammar.
    fn laws(&mut self) {
        let stated = |kind| grammar::statement(kind).expect("a statement of the grammar");
        let bushing = stated("BUSHING");
        for b in &self.model.bushings {
            let values = [b.k, b.kt, b.force, b.torque].concat();
            let at = (b.i.0, b.j.0);
            self.law(bushing, &bushing.laws[0], &b.header, at, &values);
            let c = Vec6::from_fn(|k, _| if k < 3 { b.c[k] } else { b.ct[k - 3] });
            let C = Mat6::from_diagonal(&c);
            self.damp((c != Vec6::zeros()).then(|| Damping::Matrix(Box::new(C))));
        }
        let spring = stated("SPRINGDAMPER");
        for s in &self.model.springdampers {
            let law = match s.kind {
                SpringKind::Translational => &spring.laws[0],
                SpringKind::Rotational => &spring.laws[1],
            };
            let values = [s.stiffness, s.reference, s.preload];
            self.law(spring, law, &s.header, (s.i.0, s.j.0), &values);
            let damping = match s.kind {
                SpringKind::Translational => Damping::Line(s.damping),
                SpringKind::Rotational => Damping::Turn(s.damping),
            };
            self.damp((s.damping != 0.0).then_some(damping));
        }
        for f in &self.model.pair_forces {
            if let Some(car) = &f.car {
                self.car_bushing(f, car);
                continue;
            }
            self.law(f.def, f.law, &f.header, (f.i.0, f.j.0), &f.values);
            let C = match (&f.damping[..], f.law.name) {
                (all, _) if all.len() == 36 => Some(Mat6::from_column_slice(all)),
                (half, _) if !half.is_empty() => Some(symmetric(half)),
                (_, "field") if f.damping_ratio != 0.0 => {
                    Some(Mat6::from_column_slice(&f.values[..36]) * f.damping_ratio)
                }
                (_, "beam") if f.damping_ratio != 0.0 => {
                    Some(Beam::stiffness_matrix(&f.values) * f.damping_ratio)
                }
                _ => None,
            };
            self.damp(C.map(|C| Damping::Matrix(Box::new(C))));
        }
    }

    fn scalar_forces(&mut self) {
        for s in &self.model.sforces {
            let (law, dimension): (&'static dyn Law, _) = match (s.kind, s.action_only) {
                (SforceKind::Translational, false) => (&ScalarForce::Line, Dimension::FORCE),
                (SforceKind::Translational, true) => (&ScalarForce::AlongZj, Dimension::FORCE),
                (SforceKind::Rotational, _) => (&ScalarForce::AboutZj, Dimension::TORQUE),
            };
            let owner = name("SFORCE", &s.header);
            let function = self.function(&s.function, &owner, None, dimension);
            let reaction = (!s.action_only).then(|| self.part_of(s.j.0));
            self.push_element(
                ("SFORCE", &s.header),
                (s.i.0, s.j.0, Some(s.j.0)),
                reaction,
                Action::Law(ElementLaw::Shared(law), ParameterSource::Function(function)),
            );
        }
    }

    fn vector_forces(&mut self) {
        const ARGUMENTS: [&str; 6] = admire_syntax::FORCE_COMPONENTS;
        for v in &self.model.vector_forces {
            let kind = match v.kind {
                VectorForceKind::Gforce => "GFORCE",
                VectorForceKind::Vforce => "VFORCE",
                VectorForceKind::Vtorque => "VTORQUE",
            };
            let owner: Name = name(kind, &v.header);
            let mut components = [None; 6];
            for (k, function) in v.components.iter().enumerate() {
                let dimension = if k < 3 {
                    Dimension::FORCE
                } else {
                    Dimension::TORQUE
                };
                components[k] = function
                    .as_ref()
                    .map(|f| self.function(f, &owner, Some(ARGUMENTS[k]), dimension));
            }
            if self.model.markers[v.jfloat.0].floating {
                self.floating.entry(v.jfloat.0).or_insert(v.i.0);
            }
            let reaction = Some(self.part_of(v.jfloat.0));
            self.push_element(
                (kind, &v.header),
                (v.i.0, v.jfloat.0, v.rm.map(|m| m.0)),
                reaction,
                Action::Vector(components),
            );
        }
    }
}

/// Returns the symmetric matrix given by its upper half, column by column: the 21 values of CMATRIX of a BEAM.
fn symmetric(half: &[f64]) -> Mat6 {
    let mut C = Mat6::zeros();
    let places = (0..6).flat_map(|column| (0..=column).map(move |row| (row, column)));
    for ((row, column), value) in places.zip(half) {
        C[(row, column)] = *value;
        C[(column, row)] = *value;
    }
    C
}

/// Splits a 6n by 6n matrix, given column by column, into its 6 by 6 blocks, which are returned row by row. Returns an empty list if the
/// matrix is empty.
fn blocks(numbers: &[f64], n: usize) -> Vec<Mat6> {
    if numbers.len() != 36 * n * n {
        return Vec::new();
    }
    let block = |at: usize| {
        let (a, b) = (at / n, at % n);
        Mat6::from_fn(|i, j| numbers[(6 * b + j) * 6 * n + 6 * a + i])
    };
    (0..n * n).map(block).collect()
}
