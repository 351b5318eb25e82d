//! Numbers of a deck that a subsystem of Adams/Car states for a bushing. The bushing is a BUSHING, or a FIELD that Adams/Car writes.

use admire_car::{BushingProperty, Curve, OddLaw, OddTerm};
use admire_solver::function::akima_value;
use admire_solver::model::{Bushing, ElasticPair, MarkerIx, Model, PairForce};
use admire_syntax::car_field::{CarAxis, CarField};
use admire_syntax::{Address, FORCE_COMPONENTS};

/// Added terms of a force law along one component.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct LearnedTerm {
    /// Component, 0 to 5.
    pub(super) axis: usize,
    /// Terms that are added to the law of the deck.
    pub(super) terms: Vec<OddTerm>,
    /// Largest deflection of the component in any load case.
    pub(super) range: f64,
}

/// Bushing of a deck with the numbers that a subsystem states. Components are x, y, z, then about x, y, z.
pub(super) struct CarElement<'m> {
    model: &'m Model,
    law: Law<'m>,
    /// Address of the statement: `BUSHING/3` or `FIELD/9`.
    pub(super) statement: String,
    /// View name of the statement.
    pub(super) name: &'m str,
    /// I and J markers.
    pub(super) pair: (MarkerIx, MarkerIx),
    /// Stiffnesses of a BUSHING, or scales of the curves of a FIELD.
    pub(super) stiffness: [f64; 6],
    /// Addresses of these stiffnesses or scales.
    pub(super) addresses: [String; 6],
    /// Preload forces and torques on I.
    pub(super) preload: [f64; 6],
    /// Offsets that are subtracted from the deflections of a FIELD; zero for a BUSHING.
    pub(super) offset: [f64; 6],
}

enum Law<'m> {
    Bushing(&'m Bushing),
    Field(&'m CarField, Box<[CarAxis; 6]>),
}

impl<'m> CarElement<'m> {
    /// Returns all BUSHINGs and all FIELDs of Adams/Car.
    pub(super) fn all(model: &'m Model) -> Vec<Self> {
        model
            .elastic_pairs()
            .filter_map(|pair| Self::new(model, &pair))
            .collect()
    }

    fn new(model: &'m Model, pair: &ElasticPair<'m>) -> Option<Self> {
        let id = pair.header.id;
        let new = |law, stiffness, addresses: [Address; 6], preload, offset| Self {
            model,
            law,
            statement: format!("{}/{id}", pair.kind),
            name: &pair.header.name,
            pair: (pair.i, pair.j),
            stiffness,
            addresses: addresses.map(|address| address.to_string()),
            preload,
            offset,
        };
        if pair.kind == "BUSHING" {
            let own = model.bushings.iter().find(|b| b.header.id == id)?;
            let number =
                |k: usize| Address::of_argument("BUSHING", id, ["K", "KT"][k / 3], Some(k % 3 + 1));
            return Some(new(
                Law::Bushing(own),
                six(own.k, own.kt),
                std::array::from_fn(number),
                six(own.force, own.torque),
                [0.0; 6],
            ));
        }
        let is_own = |field: &&PairForce| field.is_field() && field.header.id == id;
        let field = model.pair_forces.iter().find(is_own)?;
        let car = field.car.as_ref()?;
        let axes: Option<Vec<CarAxis>> = (0..6).map(|axis| field.car_axis(model, axis)).collect();
        let axes: [CarAxis; 6] = axes?.try_into().ok()?;
        Some(new(
            Law::Field(car, Box::new(axes)),
            axes.map(|axis| axis.scale),
            std::array::from_fn(|axis| car.parameter(axis, CarAxis::SCALE)),
            axes.map(|axis| axis.preload),
            axes.map(|axis| axis.offset),
        ))
    }

    /// Returns true if a number of the deck belongs to this bushing: one of its arguments, its arrays or its curves.
    pub(super) fn owns(&self, address: &str) -> bool {
        let object = address.split('.').next().unwrap_or(address);
        let mut owned = vec![self.statement.clone()];
        if let Law::Field(car, _) = &self.law {
            owned.extend(car.arrays.iter().map(|id| format!("ARRAY/{id}")));
            owned.extend(car.curves.iter().map(|id| format!("SPLINE/{id}")));
        }
        owned.iter().any(|own| own == object)
    }

    /// Returns the component (0 to 5) of an address in a diagnosis, such as `BUSHING/3.K.2` or `FIELD/9.FY`.
    pub(super) fn component(&self, address: &str) -> Option<usize> {
        let word = address.strip_prefix(&self.statement)?.strip_prefix('.')?;
        let words = match self.law {
            Law::Bushing(_) => ["K.1", "K.2", "K.3", "KT.1", "KT.2", "KT.3"],
            Law::Field(..) => FORCE_COMPONENTS,
        };
        words.iter().position(|own| *own == word)
    }

    /// Returns true if a curve of this FIELD differs from that of `old`, the same FIELD in another deck.
    pub(super) fn has_other_curves(&self, old: &Self) -> bool {
        (0..6).any(|axis| self.points(axis) != old.points(axis))
    }

    /// Returns the points of the SPLINE of an axis of a FIELD.
    fn points(&self, axis: usize) -> Option<(&[f64], &[f64])> {
        let Law::Field(car, _) = &self.law else {
            return None;
        };
        let mut splines = self.model.splines.iter();
        let curve = splines.find(|spline| spline.header.id == car.curves[axis])?;
        Some((&curve.x, curve.y.first()?))
    }

    /// Returns the contents of a property file with this law and the added terms. Scales are included in the curves; preloads and offsets are not.
    pub(super) fn property(&self, learned: &[LearnedTerm]) -> BushingProperty {
        let curves = std::array::from_fn(|axis| {
            let own = learned.iter().filter(|term| term.axis == axis);
            let added = OddLaw {
                stiffness: 0.0,
                terms: own.clone().flat_map(|term| term.terms.clone()).collect(),
            };
            let range = own.map(|term| term.range).fold(0.0, f64::max);
            match &self.law {
                Law::Bushing(_) => self.odd_curve(axis, added, range),
                Law::Field(_, axes) => self.scaled_curve(axis, &axes[axis], &added, range),
            }
        });
        let damping = match &self.law {
            Law::Bushing(own) => six(own.c, own.ct),
            Law::Field(_, axes) => axes.map(|axis| axis.damping),
        };
        BushingProperty { curves, damping }
    }

    /// Returns the curve of one component of a BUSHING; `None` if it has no force. Without learned terms, the curve ends at one millimetre or
    /// degree.
    fn odd_curve(&self, axis: usize, added: OddLaw, range: f64) -> Option<Curve> {
        let usual = if axis < 3 {
            1e-3 / self.model.units.length.si
        } else {
            1f64.to_radians()
        };
        let law = OddLaw {
            stiffness: self.stiffness[axis],
            ..added
        };
        let acts = law.stiffness != 0.0 || !law.terms.is_empty();
        acts.then(|| law.curve(if range > 0.0 { range } else { usual }))
    }

    /// Returns the curve of one component of a FIELD, as a function of the scaled deflection less the offset. With added terms, points within
    /// the range of deflections are added to those of the SPLINE.
    fn scaled_curve(
        &self,
        axis: usize,
        own: &CarAxis,
        added: &OddLaw,
        range: f64,
    ) -> Option<Curve> {
        let (points, _) = self.points(axis)?;
        let mut x = points.to_vec();
        if !added.terms.is_empty() {
            // A curve of the added terms alone has its points at the deflections where they matter.
            let within = added.curve(range).x;
            x.extend(within.iter().map(|d| own.stretch * d - own.offset));
            x.sort_by(f64::total_cmp);
            let near = f64::EPSILON.sqrt() * range * own.stretch.abs();
            x.dedup_by(|b, a| (*b - *a).abs() <= near);
        }
        let Law::Field(car, _) = &self.law else {
            return None;
        };
        let mut splines = self.model.splines.iter();
        let spline = splines.find(|spline| spline.header.id == car.curves[axis])?;
        let force = |q: &f64| {
            let deflection = (q + own.offset) / own.stretch;
            Some(own.scale * akima_value(spline, *q)? + added.force(deflection))
        };
        let y: Option<Vec<f64>> = x.iter().map(force).collect();
        Some(Curve { y: y?, x })
    }
}

fn six(first: [f64; 3], second: [f64; 3]) -> [f64; 6] {
    std::array::from_fn(|k| if k < 3 { first[k] } else { second[k - 3] })
}
