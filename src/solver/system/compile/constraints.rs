//! Compilation of constraint statements to scalar equations.

use super::{Header, SystemCompiler, name, stated};
use crate::constraint::{
    Constraint, ConstraintEntry, Convel, Drive as Driven, GearedJoint, PairConstraint,
    RelativeCoordinate, constraint, gear_terms,
};
use crate::mechanics::{Pose, RelativeMotion, Vec3};
use crate::model::{CouplerKind, JointKind, MotionAxis, MotionOrder};
use crate::system::catalogue::Role;
use crate::system::structure::{
    ConstraintEquation, GconEquation, ParameterSource, RateDrive, Term,
};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;

impl SystemCompiler<'_> {
    pub(super) fn constraints(&mut self) {
        self.joint_statements();
        self.primitives();
        self.couplers();
        self.gears();
        self.conditions();
        self.motions();
    }

    /// Returns the pose of a marker in ground in the design position.
    fn design(&self, marker: usize) -> Pose {
        let m = &self.model.markers[marker];
        let local = Pose { p: m.qp, R: m.R };
        self.model.parts[m.part.0].pose.compose(&local)
    }

    fn design_motion(&self, i: usize, j: usize) -> RelativeMotion {
        RelativeMotion::between(&self.design(i), &self.design(j), &Vec3::zeros())
    }

    fn joint_statements(&mut self) {
        for j in &self.model.joints {
            let at = (j.i.0, j.j.0);
            let of = ("JOINT", Some(j.header.id));
            let entry = entry("JOINT", j.kind.word());
            let law = match entry.constraint {
                PairConstraint::Convel(_) => {
                    PairConstraint::Convel(Convel::for_design(&self.design_motion(at.0, at.1)))
                }
                other => other,
            };
            let theta = match (entry.argument, j.kind.number()) {
                (Some(argument), Some(value)) => {
                    let argument = stated("JOINT", argument);
                    let joint = self.joints.len();
                    self.argument(of, argument, &[value], Role::Joint { joint })
                }
                _ => 0..0,
            };
            self.push_joint("JOINT", &j.header, at, law, ParameterSource::Theta(theta));
        }
    }

    fn primitives(&mut self) {
        for p in &self.model.primitives {
            let law = entry("JPRIM", p.kind.word()).constraint;
            self.push_joint(
                "JPRIM",
                &p.header,
                (p.i.0, p.j.0),
                law,
                ParameterSource::Theta(0..0),
            );
        }
    }

    fn term(&mut self, i: usize, j: usize, measure: RelativeCoordinate, scale: f64) -> Term {
        Term {
            i,
            j,
            law: PairConstraint::Drive(Driven { measure }),
            scale,
            pair: self.pair(i, j),
        }
    }

    fn couplers(&mut self) {
        for c in &self.model.couplers {
            let mut terms = Vec::new();
            for &(joint, kind, scale) in &c.terms {
                let Some(joint) = self.model.joints.get(joint) else {
                    continue;
                };
                let measure = match kind {
                    CouplerKind::Translation => RelativeCoordinate::Translation(2),
                    CouplerKind::Rotation => RelativeCoordinate::Angle(2),
                };
                terms.push(self.term(joint.i.0, joint.j.0, measure, scale));
            }
            self.push_sum("COUPLER", &c.header, terms, 0.0);
        }
    }

    fn gears(&mut self) {
        for gear in &self.model.gears {
            let mut terms = Vec::new();
            let mut offset = 0.0;
            for (&joint, factor) in gear.joints.iter().zip([1.0, -1.0]) {
                let Some(joint) = self.model.joints.get(joint) else {
                    continue;
                };
                let kind = match joint.kind {
                    JointKind::Revolute => GearedJoint::Revolute,
                    JointKind::Translational => GearedJoint::Translational,
                    JointKind::Cylindrical => GearedJoint::Cylindrical,
                    // Other joint types are rejected when the statement is read.
                    _ => continue,
                };
                let (i, j) = (joint.i.0, joint.j.0);
                let (cv, carrier) = (self.design(gear.cv.0), self.design(j));
                let motion = self.design_motion(i, j);
                for term in gear_terms(kind, &carrier, &cv, factor)
                    .into_iter()
                    .flatten()
                {
                    offset += term.scale * term.measure.evaluate(&motion, 0.0).value;
                    terms.push(self.term(i, j, term.measure, term.scale));
                }
            }
            self.push_sum("GEAR", &gear.header, terms, offset);
        }
    }

    fn push_sum(&mut self, kind: &'static str, header: &Header, terms: Vec<Term>, offset: f64) {
        self.joints.push(ConstraintEquation {
            name: name(kind, header),
            terms,
            drive: ParameterSource::Constant(0.0),
            offset,
            first: self.equations,
            count: 1,
            active: header.active,
        });
        self.equations += 1;
    }

    fn conditions(&mut self) {
        for g in &self.model.gcons {
            let owner = name("GCON", &g.header);
            if let Some(i) = g.i {
                self.used[i.0] = true;
            }
            let function = self.function(&g.function, &owner, None, Dimension::NONE);
            self.conditions.push(GconEquation {
                name: owner,
                i: g.i.map(|i| i.0),
                function,
                equation: self.equations,
                active: g.header.active,
            });
            self.equations += 1;
        }
    }

    fn motions(&mut self) {
        for m in &self.model.motions {
            let owner = name("MOTION", &m.header);
            let (i, j) = (m.i.0, m.j.0);
            let PairConstraint::Drive(Driven { measure }) =
                entry("MOTION", m.axis.word()).constraint
            else {
                continue;
            };
            let dimension = match m.axis {
                MotionAxis::Translation(_) => Dimension::LENGTH,
                MotionAxis::RotationZ | MotionAxis::Body123(_) => Dimension::ANGLE,
            };
            let drive = if m.order == MotionOrder::Displacement {
                ParameterSource::Function(self.function(&m.function, &owner, None, dimension))
            } else {
                let here = measure.evaluate(&self.design_motion(i, j), 0.0).value;
                let held = m.initial_displacement.unwrap_or(here);
                self.diagnostics.push(
                    Diagnostic::warning(
                        Code::InactiveInStatics,
                        format!(
                            "{owner} prescribes a velocity or acceleration, which has no meaning in statics: its displacement is held at {held} {}",
                            self.model.units.name(dimension)
                        ),
                    )
                    .about(owner.object())
                    .help("give the displacement as a function of TIME"),
                );
                let function = self.function(&m.function, &owner, None, Dimension::NONE);
                let start_rate = m.initial_velocity.unwrap_or(0.0);
                self.driven.push(crate::system::Driven {
                    time: 0.0,
                    value: held,
                    rate: start_rate,
                });
                ParameterSource::Rate(RateDrive {
                    function,
                    second: m.order == MotionOrder::Acceleration,
                    index: self.driven.len() - 1,
                    start: m.initial_displacement,
                    start_rate,
                })
            };
            let law = PairConstraint::Drive(Driven { measure });
            self.push_joint("MOTION", &m.header, (i, j), law, drive);
        }
    }

    fn push_joint(
        &mut self,
        kind: &'static str,
        header: &Header,
        (i, j): (usize, usize),
        law: PairConstraint,
        drive: ParameterSource,
    ) {
        let count = law.count();
        let pair = self.pair(i, j);
        self.joints.push(ConstraintEquation {
            name: name(kind, header),
            terms: vec![Term {
                i,
                j,
                law,
                scale: 1.0,
                pair,
            }],
            drive,
            offset: 0.0,
            first: self.equations,
            count,
            active: header.active,
        });
        self.equations += count;
    }
}

/// Returns the registered constraint of a statement and type keyword.
fn entry(statement: &str, word: &str) -> &'static ConstraintEntry {
    constraint(statement, word).expect("a constraint for every type of the model")
}
