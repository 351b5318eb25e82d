//! Motions of a deck that nothing resists, such as the spin of a link between two ball joints.

use std::sync::Arc;

use super::{CaseSweeper, Loads, tight_settings};
use crate::mechanics::{Pose, Vec3};
use crate::model::{MarkerIx, Model, PartIx};
use crate::statics::{FreeMotion, twist};
use crate::syntax::Address;
use crate::system::{Parameters, Slot, State, System};

/// Velocity of the origin and angular velocity, axes of the part.
pub(crate) type Twist = (Vec3, Vec3);

/// Where so many load cases have no equilibrium no further one is tried.
const TRIED: usize = 3;
/// A part whose pitch is below this share of its motion turns about a line; a point nearer to it than this share of the model lies on it.
const STEADY: f64 = 1e-6;

/// The motions of a deck that nothing resists, at the first of its load cases if that has an equilibrium, else at one of the next.
///
/// Each is held as a twist of every part in the axes of that part, where the spin of a link between two ball joints stays the same wherever
/// the link is. Another solver's answers are moved along them; the built-in one works them out anew for each answer.
#[derive(Clone, Debug, Default)]
pub struct FreeMotions {
    /// The parts that move, in words.
    words: Vec<FreeMotion>,
    /// A twist for each part of the model.
    motions: Arc<Vec<Vec<Twist>>>,
    weights: Arc<Vec<Weight>>,
}

/// The mass centre of a part that spins with the line through two points, on which it lies.
///
/// An error of one of the points by a tenth of a millimetre would leave it beside the line, and its weight would then say how far the part
/// is turned. On a rig friction does: it is a thousand times as large. The mass centre goes with the line.
#[derive(Clone, Debug)]
struct Weight {
    /// Its marker.
    mass_centre: u32,
    /// Markers at the ends of the line, with the frames of their parts in that of this one.
    ends: [(u32, Pose); 2],
    /// Where it lies between them.
    share: f64,
}

/// A [`Weight`] of a compiled deck: places of the mass centre and of both ends.
#[derive(Clone, Debug)]
pub(crate) struct HeldWeight {
    mass_centre: [Slot; 3],
    ends: [([Slot; 3], Pose); 2],
    share: f64,
}

impl HeldWeight {
    /// Puts the mass centre where the line is with these numbers.
    pub(crate) fn hold(&self, parameters: &mut Parameters) {
        let [a, b] = self
            .ends
            .map(|(slots, pose)| pose.point(&Vec3::from(slots.map(|slot| parameters.get(slot)))));
        let place = a + self.share * (b - a);
        for (slot, value) in self.mass_centre.iter().zip(place.iter()) {
            parameters.set(*slot, *value);
        }
    }
}

impl FreeMotions {
    /// Of a model and what it was compiled to, under its loads; none where no load case has an equilibrium.
    pub(crate) fn new(model: &Model, system: &System, loads: Loads) -> Self {
        let mut parameters = system.parameters();
        let settings = tight_settings(system);
        let mut sweeper = CaseSweeper::new(system, loads, settings.clone());
        for case in 0..sweeper.cases().min(TRIED) {
            sweeper.load(case, &mut parameters);
            let mut state = system.state();
            let solver = sweeper.solver();
            let Ok(report) = solver.solve(system, &parameters, &mut state, &settings) else {
                continue;
            };
            if report.free_motions.is_empty() {
                return Self::default();
            }
            let Ok(tangent) = solver.tangent(system, &parameters, &state) else {
                continue;
            };
            let motions = tangent.free_motions(system);
            let in_part = |(k, pose): (usize, &Pose), motion: &[f64]| {
                let (v, w) = twist(system, &state, PartIx(k), motion);
                let turned = pose.R.transpose();
                (turned * v, turned * w)
            };
            let twists = motions.iter().map(|motion| {
                let parts = state.poses.iter().enumerate();
                parts.map(|part| in_part(part, motion)).collect()
            });
            let weights = motions
                .iter()
                .flat_map(|motion| weights(model, system, &state, motion));
            return Self {
                weights: Arc::new(weights.collect()),
                motions: Arc::new(twists.collect()),
                words: report.free_motions,
            };
        }
        Self::default()
    }

    /// True if something resists every motion.
    pub(crate) fn is_empty(&self) -> bool {
        self.motions.is_empty()
    }

    /// A twist for each part of the model, motion by motion.
    pub(crate) fn twists(&self) -> &[Vec<Twist>] {
        &self.motions
    }

    /// The weights that go with the ends of their parts, of a deck that has the same markers.
    pub(crate) fn held_weights(&self, system: &System) -> Vec<HeldWeight> {
        let place = |marker: u32| {
            let slot = |k: usize| {
                system.catalogue().slot(&Address {
                    kind: "MARKER".to_string(),
                    id: Some(marker),
                    argument: Some("QP".to_string()),
                    index: Some(k),
                })
            };
            Some([slot(1)?, slot(2)?, slot(3)?])
        };
        let held = |weight: &Weight| {
            let [(a, pose_a), (b, pose_b)] = weight.ends;
            Some(HeldWeight {
                mass_centre: place(weight.mass_centre)?,
                ends: [(place(a)?, pose_a), (place(b)?, pose_b)],
                share: weight.share,
            })
        };
        self.weights.iter().filter_map(held).collect()
    }

    /// A sentence for each motion: what is not compared.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let each = self.words.iter().zip(self.motions.iter());
        each.map(|(words, motion)| {
            let mut moved = motion.iter().filter(|(v, w)| v.norm() + w.norm() > 0.0);
            if words.others.is_empty() && moved.all(turns_about_a_line) {
                let part = words.part.short();
                format!("{part} spins freely; its rotation about its own axis is ignored")
            } else {
                format!("{words}; this motion is ignored")
            }
        })
        .collect()
    }

    /// True if a part moves in one of them.
    pub(crate) fn moves(&self, part: PartIx) -> bool {
        let mut twists = self.motions.iter().map(|motion| &motion[part.0]);
        twists.any(|(v, w)| v.norm() + w.norm() > 0.0)
    }
}

fn turns_about_a_line((v, w): &Twist) -> bool {
    let turn = w.norm();
    turn > 0.0 && v.dot(w).abs() <= STEADY * turn * v.norm()
}

/// The mass centres on the line about which all parts of a motion turn, if they do, with the joints at its ends.
fn weights(model: &Model, system: &System, state: &State, motion: &[f64]) -> Vec<Weight> {
    let near = STEADY * system.length;
    let twists = (0..state.poses.len()).map(|part| twist(system, state, PartIx(part), motion));
    let twists: Vec<Twist> = twists.collect();
    let moving = |part: usize| twists[part].0.norm() + twists[part].1.norm() > 0.0;
    let Some(first) = (0..twists.len()).find(|part| moving(*part)) else {
        return Vec::new();
    };
    let (v, w) = &twists[first];
    let turn = w.norm();
    if !turns_about_a_line(&twists[first]) {
        return Vec::new();
    }
    let axis = w / turn;
    let foot = state.poses[first].p + w.cross(v) / (turn * turn);
    let is_common = |part: usize| {
        let (v, w) = &twists[part];
        let apart = w.cross(&(state.poses[part].p - foot)) - v;
        (w - turn * axis).norm() <= STEADY * turn && apart.norm() <= near * turn
    };
    if !(0..twists.len())
        .filter(|part| moving(*part))
        .all(is_common)
    {
        return Vec::new();
    }
    // Where a marker of these parts lies along the line, if it does.
    let along = |marker: MarkerIx| {
        let own = &model.markers[marker.0];
        let from = state.poses[own.part.0].point(&own.qp) - foot;
        let along = from.dot(&axis);
        let on_line = moving(own.part.0) && (from - along * axis).norm() <= near;
        on_line.then_some(along)
    };
    let joints = model.joints.iter().map(|joint| [joint.i, joint.j]);
    let primitives = model
        .primitives
        .iter()
        .map(|primitive| [primitive.i, primitive.j]);
    let ends = joints.chain(primitives).flatten();
    let mut ends: Vec<(f64, MarkerIx)> = ends.filter_map(|end| Some((along(end)?, end))).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(&(from, a)), Some(&(to, b))) = (ends.first(), ends.last()) else {
        return Vec::new();
    };
    if to - from <= near {
        return Vec::new();
    }
    let weight = |(k, part): (usize, &crate::model::Part)| {
        let mass_centre = part.cm?;
        let share = (along(mass_centre)? - from) / (to - from);
        let inverse = state.poses[k].inverse();
        let end = |marker: MarkerIx| {
            let own = &model.markers[marker.0];
            (own.header.id, inverse.compose(&state.poses[own.part.0]))
        };
        Some(Weight {
            mass_centre: model.markers[mass_centre.0].header.id,
            ends: [end(a), end(b)],
            share,
        })
    };
    model.parts.iter().enumerate().filter_map(weight).collect()
}
