//! Force statements to elements.

use super::{Compiler, Header, Name, name};
use crate::diagnostic::{Code, Diagnostic};
use crate::element::{
    Beam, Bushing, Field, ForceLaw, Law, RotationalSpring, ScalarForce, TranslationalSpring,
};
use crate::model::{SforceKind, SpringKind, VectorForceKind};
use crate::system::catalogue::{Quantity, Role};
use crate::system::multi::Multi;
use crate::system::structure::{Action, Drive, Element};
use crate::units::Dimension;

const STIFFNESS: Dimension = Dimension::new(1, 0, -1, 0, 0);
const TURNING_STIFFNESS: Dimension = Dimension::new(1, 0, 1, 0, -1);
const ANY: f64 = f64::NEG_INFINITY;

/// An argument whose numbers a law takes: keyword, values, dimension, least value.
type Argument<'a> = (&'static str, &'a [f64], Quantity, f64);

impl Compiler<'_> {
    pub(super) fn forces(&mut self) {
        self.connectors();
        self.springs();
        self.beams();
        self.scalar_forces();
        self.vector_forces();
        for n in &self.model.nforces {
            let of = ("NFORCE", Some(n.header.id));
            let size = 6 * n.i.len();
            let start = self.theta.len();
            let stiffness = (Quantity::MultiStiffness(size), ANY);
            self.numbers(of, Some("KMATRIX"), &n.k, stiffness, Role::Multi);
            self.numbers(
                of,
                Some("LENGTH"),
                &n.length,
                (Quantity::Motion, ANY),
                Role::Multi,
            );
            self.numbers(
                of,
                Some("FORCE"),
                &n.force,
                (Quantity::Wrench, ANY),
                Role::Multi,
            );
            let whole = n.k.len() == size * size && n.length.len() == size && n.force.len() == size;
            if !whole {
                self.diagnostics.push(Diagnostic::error(
                    Code::WrongCount,
                    format!(
                        "{} does not have numbers for its {} markers",
                        name("NFORCE", &n.header),
                        n.i.len()
                    ),
                ));
            }
            let i: Vec<usize> = n.i.iter().map(|m| m.0).collect();
            let pairs = i.iter().map(|&i| self.pair(i, n.j.0)).collect();
            self.multis.push(Multi {
                name: name("NFORCE", &n.header),
                i,
                j: n.j.0,
                theta: start..self.theta.len(),
                pairs,
                active: n.header.active && whole,
            });
        }
    }

    fn law(
        &mut self,
        kind: &'static str,
        header: &Header,
        (i, j): (usize, usize),
        law: ForceLaw,
        arguments: &[Argument],
    ) {
        let element = self.elements.len();
        let start = self.theta.len();
        for (argument, values, quantity, minimum) in arguments {
            let of = (kind, Some(header.id));
            let bounds = (*quantity, *minimum);
            self.numbers(of, Some(argument), values, bounds, Role::Law { element });
        }
        debug_assert_eq!(law.parameter_count(), self.theta.len() - start, "{kind}");
        let drive = Drive::Theta(start..self.theta.len());
        let reaction = Some(self.part_of(j));
        let action = Action::Law(law, drive);
        self.push_element((kind, header), (i, j, Some(j)), reaction, action);
    }

    fn push_element(
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
            pair,
            active: header.active,
        });
    }

    fn connectors(&mut self) {
        let same = Quantity::Same;
        for b in &self.model.bushings {
            let arguments = [
                ("K", &b.k[..], same(STIFFNESS), 0.0),
                ("KT", &b.kt[..], same(TURNING_STIFFNESS), 0.0),
                ("FORCE", &b.force[..], same(Dimension::FORCE), ANY),
                ("TORQUE", &b.torque[..], same(Dimension::TORQUE), ANY),
            ];
            let law = ForceLaw::Bushing(Bushing);
            self.law("BUSHING", &b.header, (b.i.0, b.j.0), law, &arguments);
        }
        for f in &self.model.fields {
            let arguments = [
                ("KMATRIX", &f.k[..], Quantity::Stiffness, ANY),
                ("LENGTH", &f.length[..], Quantity::Motion, ANY),
                ("FORCE", &f.force[..], Quantity::Wrench, ANY),
            ];
            let law = ForceLaw::Field(Field);
            self.law("FIELD", &f.header, (f.i.0, f.j.0), law, &arguments);
        }
    }

    fn springs(&mut self) {
        let same = Quantity::Same;
        for s in &self.model.springdampers {
            let (k, reference, preload) = (&[s.stiffness], &[s.reference], &[s.preload]);
            let at = (s.i.0, s.j.0);
            match s.kind {
                SpringKind::Translational => {
                    let arguments = [
                        ("K", &k[..], same(STIFFNESS), 0.0),
                        ("LENGTH", &reference[..], same(Dimension::LENGTH), 0.0),
                        ("FORCE", &preload[..], same(Dimension::FORCE), ANY),
                    ];
                    let law = ForceLaw::TranslationalSpring(TranslationalSpring);
                    self.law("SPRINGDAMPER", &s.header, at, law, &arguments);
                }
                SpringKind::Rotational => {
                    let arguments = [
                        ("KT", &k[..], same(TURNING_STIFFNESS), 0.0),
                        ("ANGLE", &reference[..], same(Dimension::ANGLE), ANY),
                        ("TORQUE", &preload[..], same(Dimension::TORQUE), ANY),
                    ];
                    let law = ForceLaw::RotationalSpring(RotationalSpring);
                    self.law("SPRINGDAMPER", &s.header, at, law, &arguments);
                }
            }
        }
    }

    fn beams(&mut self) {
        let area_moment = Dimension::new(0, 0, 4, 0, 0);
        let modulus = Dimension::new(1, 0, -2, 0, 0);
        let dimensions = [
            ("LENGTH", Dimension::LENGTH),
            ("AREA", Dimension::new(0, 0, 2, 0, 0)),
            ("IXX", area_moment),
            ("IYY", area_moment),
            ("IZZ", area_moment),
            ("EMODULUS", modulus),
            ("GMODULUS", modulus),
            ("ASY", Dimension::NONE),
            ("ASZ", Dimension::NONE),
        ];
        for b in &self.model.beams {
            if let Some(why) = Beam::refusal(b.formulation) {
                self.diagnostics.push(Diagnostic::error(
                    Code::NotSolvedNatively,
                    format!("{} has {why}", name("BEAM", &b.header)),
                ));
            }
            let arguments: Vec<Argument> = dimensions
                .iter()
                .enumerate()
                .map(|(k, &(argument, dimension))| {
                    let value = &b.properties[k..=k];
                    (argument, value, Quantity::Same(dimension), 0.0)
                })
                .collect();
            let law = ForceLaw::Beam(Beam);
            self.law("BEAM", &b.header, (b.i.0, b.j.0), law, &arguments);
        }
    }

    fn scalar_forces(&mut self) {
        for s in &self.model.sforces {
            let (law, dimension) = match (s.kind, s.action_only) {
                (SforceKind::Translational, false) => (ScalarForce::Line, Dimension::FORCE),
                (SforceKind::Translational, true) => (ScalarForce::AlongZj, Dimension::FORCE),
                (SforceKind::Rotational, _) => (ScalarForce::AboutZj, Dimension::TORQUE),
            };
            let owner = name("SFORCE", &s.header);
            let function = self.function(&s.function, &owner, None, dimension);
            let reaction = (!s.action_only).then(|| self.part_of(s.j.0));
            self.push_element(
                ("SFORCE", &s.header),
                (s.i.0, s.j.0, Some(s.j.0)),
                reaction,
                Action::Law(ForceLaw::ScalarForce(law), Drive::Function(function)),
            );
        }
    }

    fn vector_forces(&mut self) {
        const ARGUMENTS: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
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
