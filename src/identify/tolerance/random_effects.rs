//! Random effects: small errors of an axle and its rig, expressed as changes of deck parameters.

use super::group::EffectGroup;
use super::point::{ConnectionPoint, points};
use admire_session::backend::{Load, LoadProgramme};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{JointKind, MarkerIx, Model, SpringKind};
use admire_syntax::Address;

/// Change of the deck caused by one unit of a random effect.
#[derive(Clone, PartialEq, Debug)]
pub enum Effect {
    /// Deck parameters change by these amounts in every case.
    Always(Vec<(Address, f64)>),
    /// Deck parameters change by these amounts, one per case, after the loads are set.
    PerCase(Vec<(Address, Vec<f64>)>),
    /// Markers rotate on their parts by one radian, each about its given axis.
    Turn(Vec<(MarkerIx, Vec3)>),
    /// The two sides of a bushing are displaced relative to each other along one axis by a unit length. The preload `FORCE` changes by `K`.
    Offset {
        /// Index of the bushing.
        bushing: usize,
        /// Axis of the displacement: 0, 1, 2 for x, y, z.
        axis: usize,
    },
}

impl Effect {
    /// Returns the case to which the effect is confined; `None` if it acts in several cases.
    pub fn only_case(&self) -> Option<usize> {
        let Self::PerCase(pairs) = self else {
            return None;
        };
        let mut cases = pairs.iter().flat_map(|(_, values)| {
            let each = values.iter().enumerate();
            each.filter(|(_, value)| **value != 0.0)
                .map(|(case, _)| case)
        });
        let first = cases.next()?;
        cases.all(|case| case == first).then_some(first)
    }
}

/// A small error of the axle or its rig, with a Gaussian prior of mean zero.
#[derive(Clone, PartialEq, Debug)]
pub struct RandomEffect {
    /// Group of the effect. The size of the group is the prior standard deviation: in the deck's length unit, in radians, or relative.
    pub group: EffectGroup,
    /// Address of the marker, load, bushing, joint or parameter that the effect belongs to.
    pub address: String,
    /// Axis of the effect: 0, 1, 2 for x, y, z; 0 for an effect without an axis.
    pub axis: usize,
    /// Change of the deck per unit of the random effect.
    pub effect: Effect,
}

/// Inputs from which the random effects of a study are built.
pub struct LayerOf<'a> {
    /// Model of the deck.
    pub model: &'a Model,
    /// Loads and load cases of the study.
    pub programme: &'a LoadProgramme,
    /// True if the loads have errors that vary from case to case.
    pub load_errors: bool,
    /// Function that returns true for the address of an identified parameter.
    pub is_sought: &'a dyn Fn(&Address) -> bool,
    /// Function that returns true if a change of the deck is an identified unknown, such as a hardpoint along an axis. Such a change gets no
    /// random effect.
    pub is_sought_change: &'a dyn Fn(&[(Address, f64)]) -> bool,
}

/// All random effects of a deck and its loads.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RandomEffects {
    /// Random effects in a fixed order.
    pub members: Vec<RandomEffect>,
    /// Hardpoints of the deck. The effects of a hardpoint have the address of its first marker.
    pub points: Vec<ConnectionPoint>,
}

impl RandomEffects {
    /// Builds the random effects of a deck and its loads.
    pub fn of(study: &LayerOf<'_>) -> Self {
        let mut layer = Self {
            members: Vec::new(),
            points: points(study.model),
        };
        layer.hardpoints(study.model);
        layer.loads(study);
        layer.bushings(study);
        layer.fields(study);
        layer.joints(study.model);
        layer.springs(study);
        layer.members.retain(|member| match &member.effect {
            Effect::Always(pairs) => !(study.is_sought_change)(pairs),
            Effect::PerCase(_) | Effect::Turn(_) | Effect::Offset { .. } => true,
        });
        layer.driven(study.programme);
        if study.load_errors {
            layer.load_errors(study);
        }
        layer
    }

    /// Converts effects on parameters that a load drives to per-case effects. Such parameters are set again in every case, so the error must be
    /// added each time.
    fn driven(&mut self, programme: &LoadProgramme) {
        let is_driven =
            |address: &Address| programme.loads.iter().any(|load| load.target == *address);
        for member in &mut self.members {
            if let Effect::Always(pairs) = &member.effect
                && pairs.iter().any(|(address, _)| is_driven(address))
            {
                let every = |(address, factor): &(Address, f64)| {
                    (address.clone(), vec![*factor; programme.cases.len()])
                };
                member.effect = Effect::PerCase(pairs.iter().map(every).collect());
            }
        }
    }

    /// Iterates over the indices of the effects in a group that have the given address.
    pub fn at<'a>(
        &'a self,
        group: EffectGroup,
        address: &'a str,
    ) -> impl Iterator<Item = usize> + 'a {
        let of = move |(_, m): &(usize, &RandomEffect)| m.group == group && m.address == address;
        self.members.iter().enumerate().filter(of).map(|(k, _)| k)
    }

    fn hardpoints(&mut self, model: &Model) {
        for point in &self.points {
            let address = marker_address(model, point.markers[0]);
            for axis in 0..3 {
                let effect = shift(model, &point.markers, &Vec3::ith(axis, 1.0));
                self.members.push(RandomEffect {
                    group: EffectGroup::Hardpoints,
                    address: address.clone(),
                    axis,
                    effect,
                });
            }
        }
    }

    fn loads(&mut self, study: &LayerOf<'_>) {
        let (model, programme) = (study.model, study.programme);
        let mut seen = Vec::new();
        for (k, load) in programme.loads.iter().enumerate() {
            let Some(marker) = acts_at(model, &load.target) else {
                continue;
            };
            if !seen.contains(&marker) {
                seen.push(marker);
                // If a load acts at the marker of a hardpoint, its point already moves with the hardpoint.
                let own = !self
                    .points
                    .iter()
                    .any(|point| point.markers.contains(&marker));
                for axis in (0..3).filter(|_| own) {
                    self.members.push(RandomEffect {
                        group: EffectGroup::LoadPoints,
                        address: marker_address(model, marker),
                        axis,
                        effect: shift(model, &[marker], &Vec3::ith(axis, 1.0)),
                    });
                }
            }
            let values: Vec<f64> = programme.cases.iter().map(|case| case.values[k]).collect();
            if values.iter().all(|value| *value == 0.0) {
                continue;
            }
            let target = load.target.clone();
            self.members.push(RandomEffect {
                group: EffectGroup::LoadGains,
                address: target.to_string(),
                axis: 0,
                effect: Effect::PerCase(vec![(target.clone(), values.clone())]),
            });
            for other in &programme.loads {
                let same = acts_at(model, &other.target) == Some(marker);
                if other.target == target || !same {
                    continue;
                }
                self.members.push(RandomEffect {
                    group: EffectGroup::LoadDirections,
                    address: format!("{}<-{target}", other.target),
                    axis: 0,
                    effect: Effect::PerCase(vec![(other.target.clone(), values.clone())]),
                });
            }
        }
    }

    /// Adds one effect per applied load and case: the error of the load in that case.
    fn load_errors(&mut self, study: &LayerOf<'_>) {
        let cases = study.programme.cases.len();
        for (load, largest) in applied_loads(study.model, study.programme) {
            let target = &study.programme.loads[load].target;
            for (case, at) in study.programme.cases.iter().enumerate() {
                let mut factors = vec![0.0; cases];
                factors[case] = largest;
                self.members.push(RandomEffect {
                    group: if at.values[load] == 0.0 {
                        EffectGroup::IdleLoads
                    } else {
                        EffectGroup::LoadRepeatability
                    },
                    address: target.to_string(),
                    axis: 0,
                    effect: Effect::PerCase(vec![(target.clone(), factors)]),
                });
            }
        }
    }

    fn bushings(&mut self, study: &LayerOf<'_>) {
        for (at, bushing) in study.model.bushings.iter().enumerate() {
            if !bushing.header.active {
                continue;
            }
            let id = bushing.header.id;
            let address = format!("BUSHING/{id}");
            for axis in 0..3 {
                self.members.push(RandomEffect {
                    group: EffectGroup::Offsets,
                    address: address.clone(),
                    axis,
                    effect: Effect::Offset { bushing: at, axis },
                });
                self.axis_error(address.clone(), axis, [bushing.i, bushing.j]);
            }
            for (word, values) in [("K", bushing.k), ("KT", bushing.kt)] {
                for (axis, value) in values.into_iter().enumerate() {
                    let number = Address::of_argument("BUSHING", id, word, Some(axis + 1));
                    self.known(study, EffectGroup::KnownStiffnesses, number, value);
                }
            }
        }
    }

    /// Adds the rotation of both markers of an element about one of their axes.
    fn axis_error(&mut self, address: String, axis: usize, markers: [MarkerIx; 2]) {
        let turn = markers.map(|marker| (marker, Vec3::ith(axis, 1.0)));
        self.members.push(RandomEffect {
            group: EffectGroup::Axes,
            address,
            axis,
            effect: Effect::Turn(turn.to_vec()),
        });
    }

    /// Adds the errors of FIELDs, which are those of bushings.
    fn fields(&mut self, study: &LayerOf<'_>) {
        let model = study.model;
        let fields = model.pair_forces.iter();
        for field in fields.filter(|force| force.is_field() && force.header.active) {
            let address = format!("FIELD/{}", field.header.id);
            for axis in 0..3 {
                if let Some(change) = field.free_position(model, axis) {
                    self.members.push(RandomEffect {
                        group: EffectGroup::Offsets,
                        address: address.clone(),
                        axis,
                        effect: Effect::Always(vec![change]),
                    });
                }
                self.axis_error(address.clone(), axis, [field.i, field.j]);
            }
            for axis in 0..6 {
                let is_sought = field.car.as_ref().is_some_and(|car| {
                    let points = study
                        .model
                        .splines
                        .iter()
                        .find(|s| s.header.id == car.curves[axis]);
                    let count = points.map_or(0, |spline| spline.x.len());
                    (1..=count).any(|k| {
                        let y = Address::of_argument("SPLINE", car.curves[axis], "Y", Some(k));
                        (study.is_sought)(&y)
                    })
                });
                if let Some((number, value)) =
                    field.stiffness_scale(model, axis).filter(|_| !is_sought)
                {
                    self.known(study, EffectGroup::KnownStiffnesses, number, value);
                }
            }
        }
    }

    fn joints(&mut self, model: &Model) {
        for joint in model.joints.iter().filter(|joint| joint.header.active) {
            // The axis of a sliding joint guides its motion, so sliding joints get axis errors but no offsets.
            let slides = matches!(
                joint.kind,
                JointKind::Cylindrical | JointKind::Translational
            );
            for axis in (0..3).filter(|_| !slides) {
                self.members.push(RandomEffect {
                    group: EffectGroup::Offsets,
                    address: format!("JOINT/{}", joint.header.id),
                    axis,
                    effect: shift(model, &[joint.i], &Vec3::ith(axis, 1.0)),
                });
            }
            let has_axis = matches!(
                joint.kind,
                JointKind::Cylindrical | JointKind::Translational | JointKind::Revolute
            );
            for axis in (0..2).filter(|_| has_axis) {
                self.axis_error(
                    format!("JOINT/{}", joint.header.id),
                    axis,
                    [joint.i, joint.j],
                );
            }
        }
    }

    fn springs(&mut self, study: &LayerOf<'_>) {
        let model = study.model;
        for spring in model.springdampers.iter().filter(|s| s.header.active) {
            let id = spring.header.id;
            let place = |marker: MarkerIx| {
                let of = &model.markers[marker.0];
                model.parts[of.part.0].pose.point(&of.qp)
            };
            let length = (place(spring.i) - place(spring.j)).norm();
            let stretch = match spring.kind {
                SpringKind::Translational => length - spring.reference,
                SpringKind::Rotational => 0.0,
            };
            // Spring force in the design position. A spring without load there counts as deflected by at least a tenth of its reference length.
            let force = (spring.preload - spring.stiffness * stretch).abs();
            let force = force.max(0.1 * spring.stiffness * spring.reference.abs());
            let address = match spring.kind {
                SpringKind::Translational => {
                    Address::of_argument("SPRINGDAMPER", id, "FORCE", None)
                }
                SpringKind::Rotational => Address::of_argument("SPRINGDAMPER", id, "TORQUE", None),
            };
            if force > 0.0 && !(study.is_sought)(&address) {
                self.members.push(RandomEffect {
                    group: EffectGroup::Preloads,
                    address: address.to_string(),
                    axis: 0,
                    effect: Effect::Always(vec![(address, force)]),
                });
            }
            let word = match spring.kind {
                SpringKind::Translational => "K",
                SpringKind::Rotational => "KT",
            };
            let rate = Address::of_argument("SPRINGDAMPER", id, word, None);
            self.known(study, EffectGroup::SpringRates, rate, spring.stiffness);
        }
    }

    fn known(&mut self, study: &LayerOf<'_>, group: EffectGroup, address: Address, value: f64) {
        if value > 0.0 && !(study.is_sought)(&address) {
            self.members.push(RandomEffect {
                group,
                address: address.to_string(),
                axis: 0,
                effect: Effect::Always(vec![(address, value)]),
            });
        }
    }
}

/// Returns the effect of moving all `markers` together by `direction`, given in ground axes in the design position. The markers may belong to
/// several parts. A marker that is defined relative to another marker of the list moves with that marker and is left out.
pub fn shift(model: &Model, markers: &[MarkerIx], direction: &Vec3) -> Effect {
    let of = |marker: &MarkerIx| {
        let own = &model.markers[marker.0];
        let local = own.as_written(&(model.parts[own.part.0].pose.R.transpose() * direction));
        let id = own.header.id;
        (0..3)
            .filter(|k| local[*k] != 0.0)
            .map(|k| {
                (
                    Address::of_argument("MARKER", id, "QP", Some(k + 1)),
                    local[k],
                )
            })
            .collect::<Vec<_>>()
    };
    let first = |marker: &&MarkerIx| !model.moves_with(**marker, markers);
    Effect::Always(markers.iter().filter(first).flat_map(of).collect())
}

/// Returns the indices of the loads that are nonzero forces or torques, each with its largest magnitude over the cases.
pub fn applied_loads(model: &Model, programme: &LoadProgramme) -> Vec<(usize, f64)> {
    let loads = programme.loads.iter().enumerate();
    let of = |(k, load): (usize, &Load)| {
        acts_at(model, &load.target)?;
        let values = programme.cases.iter().map(|case| case.values[k].abs());
        let largest = values.fold(0.0, f64::max);
        (largest > 0.0).then_some((k, largest))
    };
    loads.filter_map(of).collect()
}

/// Returns the marker at which the force with this address acts; `None` if the address is no force.
pub fn acts_at(model: &Model, target: &Address) -> Option<MarkerIx> {
    let id = target.id?;
    match target.kind.as_str() {
        "SFORCE" => model
            .sforces
            .iter()
            .find(|f| f.header.id == id)
            .map(|f| f.i),
        "GFORCE" | "VFORCE" | "VTORQUE" => {
            let found = model.vector_forces.iter().find(|f| f.header.id == id);
            found.map(|f| f.i)
        }
        _ => None,
    }
}

fn marker_address(model: &Model, marker: MarkerIx) -> String {
    format!("MARKER/{}", model.markers[marker.0].header.id)
}
