//! Compilation of FRICTION statements.

use super::{SystemCompiler, name};
use crate::element::FrictionLaw;
use crate::model::JointKind;
use crate::system::surface::{JointFriction, Pressing, Slide};
use admire_syntax::diagnostic::{Code, Diagnostic};

impl SystemCompiler<'_> {
    /// Compiles all FRICTIONs. Must run after the joints are compiled, because the joints come first among the constraints.
    pub(super) fn joint_frictions(&mut self) {
        for f in &self.model.frictions {
            let owner = name("FRICTION", &f.header);
            let Some(joint) = self.model.joints.get(f.joint) else {
                continue;
            };
            if f.header.active && f.in_statics {
                self.diagnostics.push(
                    Diagnostic::warning(
                        Code::NotSolvedInStatics,
                        format!("{owner} exerts no friction in statics: its surfaces are at rest, and its stiction is not deformed"),
                    )
                    .about(owner.object())
                    .help("kinematic and dynamic simulations include it and start with undeformed stiction after a static solution; the friction of ADAMS in statics is not documented; INACTIVE=STATIC switches it off there"),
                );
            }
            let (i, j) = (joint.i.0, joint.j.0);
            let pair = self.pair(i, j);
            let force = f64::from(u8::from(f.inputs.reaction_force));
            let bend = f64::from(u8::from(f.inputs.bending_moment));
            let twist = f64::from(u8::from(f.inputs.torsional_moment));
            let (force_preload, torque_preload) = if f.inputs.preload {
                (f.force_preload, f.torque_preload)
            } else {
                (0.0, 0.0)
            };
            let none = Pressing {
                preload: 0.0,
                across: force,
                along: 0.0,
                bending: 0.0,
                torsion: 0.0,
                ball: false,
                overlap: None,
            };
            let pin = Pressing {
                along: force * f.friction_arm / f.pin_radius,
                bending: bend / f.bending_arm,
                ..none
            };
            let overlap = Some((f.overlap, f.overlap_by_displacement));
            let about = |axis| (Slide::AboutI(axis), Slide::AboutJ(axis));
            let kinds: Vec<(Vec<Slide>, f64, Pressing)> = match joint.kind {
                JointKind::Translational => {
                    let pressing = Pressing {
                        preload: force_preload,
                        bending: bend,
                        torsion: twist / f.reaction_arm,
                        overlap,
                        ..none
                    };
                    vec![(vec![Slide::AlongZ], 1.0, pressing)]
                }
                JointKind::Cylindrical => {
                    let pressing = Pressing {
                        preload: force_preload,
                        bending: bend,
                        overlap,
                        ..none
                    };
                    let slides = vec![Slide::AlongZ, Slide::AboutJ(2)];
                    vec![(slides, f.pin_radius, pressing)]
                }
                JointKind::Revolute => vec![(vec![Slide::AboutJ(2)], f.pin_radius, pin)],
                JointKind::Hooke | JointKind::Universal => {
                    // The pins of the cross lie along xi and yj (HOOKE), or along zi and zj (UNIVERSAL).
                    let pins = match joint.kind {
                        JointKind::Hooke => [about(0).0, about(1).1],
                        _ => [about(2).0, about(2).1],
                    };
                    let all = pins.into_iter().zip(f.yokes);
                    all.filter(|(_, on)| *on)
                        .map(|(slide, _)| (vec![slide], f.pin_radius, pin))
                        .collect()
                }
                JointKind::Spherical => {
                    let ball = Pressing { ball: true, ..none };
                    let slides = (0..3).map(Slide::AboutI).collect();
                    vec![(slides, f.ball_radius, ball)]
                }
                _ => Vec::new(),
            };
            // EFFECT: without stiction, the sliding coefficient applies down to zero velocity. Without sliding, the coefficient is zero
            // beyond the transition.
            let law = FrictionLaw {
                mu_static: if f.stiction {
                    f.mu_static
                } else {
                    f.mu_dynamic
                },
                mu_dynamic: if f.sliding { f.mu_dynamic } else { 0.0 },
                stiction_velocity: f.stiction_velocity,
                sliding_velocity: f.stiction_velocity * f.transition.max(1.0 + 1e-9),
                deformation: f.deformation,
            };
            for (slides, radius, pressing) in kinds {
                self.frictions.push(JointFriction {
                    name: owner.clone(),
                    joint: f.joint,
                    i,
                    j,
                    pair,
                    slides,
                    radius,
                    law,
                    sticks: f.stiction,
                    slips: f.sliding,
                    at_rest: None,
                    pressing,
                    torque_preload,
                    active: f.header.active,
                });
            }
        }
    }
}
