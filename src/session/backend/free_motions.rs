//! Motions of a deck that meet no stiffness, such as the spin of a link between two ball joints.

use std::sync::Arc;

use super::{CaseSweeper, Loads, tight_settings};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{MarkerIx, Model, Part, PartIx, PartKind};
use admire_solver::statics::{FreeMotion, twist};
use admire_solver::system::{Parameters, Slot, State, System};
use admire_syntax::catalogue::references;
use admire_syntax::{Address, Dataset, Reference};

/// Velocity of the origin of a part, and angular velocity of the part, both in axes of the part.
pub type Twist = (Vec3, Vec3);

/// Maximum number of load cases that are tried until one of them has an equilibrium.
const TRIED: usize = 3;
/// Fraction of the mass that stays on a spinning part when its weight is moved to the parts that carry it. The weight of this fraction
/// resists the spin no more than round-off does.
const TRACE: f64 = 1e-12;
/// Relative tolerance for a rotation about a line.
///
/// A part rotates about a line if the translation along the axis is smaller than this fraction of its velocity. A point lies on the line if
/// its distance is smaller than this fraction of the model size.
const STEADY: f64 = 1e-6;

/// Zero-stiffness motions of a deck, computed at the equilibrium of the first load case that has one.
///
/// Each motion consists of a twist for every part, in axes of that part. In these axes, the spin of a link between two ball joints does not
/// depend on the position of the link.
///
/// A solution of an external solver is shifted along these motions before it is compared with measurements. The built-in solver recomputes
/// the motions at each solution.
#[derive(Clone, Debug, Default)]
pub struct FreeMotions {
    /// Descriptions of the motions, for the user.
    words: Vec<FreeMotion>,
    /// Twists of the parts; the first index is the motion, the second the part of the model.
    motions: Arc<Vec<Vec<Twist>>>,
    weights: Arc<Vec<Weight>>,
}

/// A part that spins about a line through its mass centre, and the parts that carry it on this line.
///
/// As soon as the mass centre is off the line, gravity determines the rotation of the part in the model; a hardpoint error of a hundredth
/// of a millimetre suffices. On a real rig, friction determines the rotation, because it is a thousand times larger than this effect of
/// gravity. The weight of the part is therefore applied to the parts that carry it.
#[derive(Clone, Debug)]
struct Weight {
    part: Address,
    carriers: Vec<Carrier>,
}

/// A part, other than ground, that carries a fraction of the weight of a spinning part.
#[derive(Clone, Debug)]
struct Carrier {
    mass: Address,
    share: f64,
    /// Ids of the marker at the mass centre of the carrier and of the marker where it carries the spinning part. `None` if other statements
    /// use the marker at the mass centre, because this marker must then not be moved.
    places: Option<[u32; 2]>,
}

/// A [`Weight`] whose addresses were resolved to parameter slots of a compiled deck.
#[derive(Clone, Debug)]
pub struct HeldWeight {
    mass: Slot,
    carriers: Vec<HeldShare>,
}

#[derive(Clone, Debug)]
struct HeldShare {
    mass: Slot,
    share: f64,
    places: Option<[[Slot; 3]; 2]>,
}

impl HeldWeight {
    /// Moves the mass of the spinning part to its carriers, and leaves the fraction [`TRACE`] of the mass on the part itself.
    pub fn hold(&self, parameters: &mut Parameters) {
        let weight = parameters.get(self.mass);
        parameters.set(self.mass, TRACE * weight);
        for carrier in &self.carriers {
            let (own, more) = (parameters.get(carrier.mass), carrier.share * weight);
            let whole = own + more;
            parameters.set(carrier.mass, whole);
            for (centre, end) in carrier.places.iter().flat_map(|[a, b]| a.iter().zip(b)) {
                let moment = own * parameters.get(*centre) + more * parameters.get(*end);
                parameters.set(*centre, moment / whole);
            }
        }
    }

    /// Resets all parameters that [`Self::hold`] changes to their values in `deck`.
    pub fn release(&self, parameters: &mut Parameters, deck: &Parameters) {
        let places = self.carriers.iter().filter_map(|own| own.places);
        let centres = places.flat_map(|[centre, _]| centre);
        let masses = self.carriers.iter().map(|own| own.mass);
        for slot in centres.chain(masses).chain([self.mass]) {
            parameters.set(slot, deck.get(slot));
        }
    }
}

impl FreeMotions {
    /// Finds the motions of a lowered and compiled deck under its loads. Finds no motions if none of the first load cases has an
    /// equilibrium.
    pub fn new(dataset: &Dataset, model: &Model, system: &System, loads: Loads) -> Self {
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
                .flat_map(|motion| weights((dataset, model), system, &state, motion));
            return Self {
                weights: Arc::new(weights.collect()),
                motions: Arc::new(twists.collect()),
                words: report.free_motions,
            };
        }
        Self::default()
    }

    /// Returns true if the deck has no zero-stiffness motion, or none was found.
    pub fn is_empty(&self) -> bool {
        self.motions.is_empty()
    }

    /// Returns the twists; the first index is the motion, the second the part of the model.
    pub fn twists(&self) -> &[Vec<Twist>] {
        &self.motions
    }

    /// Returns the weights of the spinning parts, resolved in a compiled deck that has the same parts.
    pub fn held_weights(&self, system: &System) -> Vec<HeldWeight> {
        let slot = |address: &Address| system.catalogue().slot(address);
        let place = |marker: u32| {
            let at = |k| slot(&address("MARKER", marker, "QP", Some(k)));
            Some([at(1)?, at(2)?, at(3)?])
        };
        let share = |carrier: &Carrier| {
            let places = carrier.places;
            Some(HeldShare {
                mass: slot(&carrier.mass)?,
                share: carrier.share,
                places: places.and_then(|[a, b]| Some([place(a)?, place(b)?])),
            })
        };
        let held = |weight: &Weight| {
            Some(HeldWeight {
                mass: slot(&weight.part)?,
                carriers: weight.carriers.iter().map(share).collect::<Option<_>>()?,
            })
        };
        self.weights.iter().filter_map(held).collect()
    }

    /// Returns a sentence for each motion, which tells the user that the motion is ignored in comparisons.
    pub fn sentences(&self) -> Vec<String> {
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

    /// Returns true if at least one of the motions moves the part.
    pub fn moves(&self, part: PartIx) -> bool {
        let mut twists = self.motions.iter().map(|motion| &motion[part.0]);
        twists.any(|(v, w)| v.norm() + w.norm() > 0.0)
    }
}

fn turns_about_a_line((v, w): &Twist) -> bool {
    let turn = w.norm();
    turn > 0.0 && v.dot(w).abs() <= STEADY * turn * v.norm()
}

/// Returns the weights of all parts that rotate about a common line in this motion and have their mass centres on the line. The list is
/// empty if the motion is not such a rotation.
fn weights(
    (dataset, model): (&Dataset, &Model),
    system: &System,
    state: &State,
    motion: &[f64],
) -> Vec<Weight> {
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
    // Returns the position of a marker along the line, if the marker belongs to a moving part and lies on the line.
    let along = |marker: MarkerIx| {
        let own = &model.markers[marker.0];
        let from = state.poses[own.part.0].point(&own.qp) - foot;
        let along = from.dot(&axis);
        let on_line = moving(own.part.0) && (from - along * axis).norm() <= near;
        on_line.then_some(along)
    };
    // Supports of the moving parts: the position along the line, and the marker of the part at rest that carries a moving part there.
    let pairs = model.joints.iter().map(|joint| (joint.i, joint.j));
    let pairs = pairs.chain(model.primitives.iter().map(|own| (own.i, own.j)));
    let pairs = pairs.flat_map(|(i, j)| [(i, j), (j, i)]);
    let part_of = |marker: MarkerIx| model.markers[marker.0].part;
    let mut ends: Vec<(f64, MarkerIx)> = pairs
        .filter(|(_, carrier)| !moving(part_of(*carrier).0))
        .filter_map(|(own, carrier)| Some((along(own)?, carrier)))
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(&(from, a)), Some(&(to, b))) = (ends.first(), ends.last()) else {
        return Vec::new();
    };
    if to - from <= near {
        return Vec::new();
    }
    let id = |marker: MarkerIx| model.markers[marker.0].header.id;
    // A marker at a mass centre may be moved only if no statement except its own part refers to it.
    let is_alone = |centre: &MarkerIx| {
        let all = dataset.statements().iter().flat_map(references);
        let named = |own: &Reference| own.space == "marker" && own.id == id(*centre);
        all.filter(named).count() == 1
    };
    let carrier = |(end, share): (MarkerIx, f64)| {
        let part = &model.parts[part_of(end).0];
        let centre = part.cm.filter(is_alone);
        (part.kind != PartKind::Ground).then(|| Carrier {
            mass: mass(part),
            share,
            places: centre.map(|centre| [id(centre), id(end)]),
        })
    };
    let weight = |part: &Part| {
        let share = (along(part.cm?)? - from) / (to - from);
        Some(Weight {
            part: mass(part),
            carriers: [(a, 1.0 - share), (b, share)]
                .into_iter()
                .filter_map(carrier)
                .collect(),
        })
    };
    model.parts.iter().filter_map(weight).collect()
}

fn mass(part: &Part) -> Address {
    let kind = match part.kind {
        PartKind::PointMass => "POINT_MASS",
        _ => "PART",
    };
    address(kind, part.header.id, "MASS", None)
}

fn address(kind: &str, id: u32, argument: &str, index: Option<usize>) -> Address {
    Address {
        kind: kind.to_string(),
        id: Some(id),
        argument: Some(argument.to_string()),
        index,
    }
}
