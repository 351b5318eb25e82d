//! Unknowns of `[[identify.unknown]]` and `[[target.unknown]]`, with their names resolved in the deck.

use std::collections::{BTreeMap, BTreeSet};

use crate::mirror::{Mirror, place};
use crate::smooth_points::smooth_changes;
use crate::tolerance::{Effect, points, shift};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{MarkerIx, Model};
use admire_study::{Quantity, UnknownForm, UnknownSettings};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use admire_syntax::units::Dimension;
use admire_syntax::{Address, Argument, Dataset};

/// A number of the deck that an unknown sets.
#[derive(Clone, PartialEq, Debug)]
pub struct SetNumber {
    /// Address of the number.
    pub address: Address,
    /// Factor of the unknown in this number.
    pub factor: f64,
    /// Value in the deck, angles in radians.
    pub deck: f64,
}

/// An unknown: one coordinate of the search, which sets one or several numbers of the deck.
///
/// With the coordinate `x`, a number is `deck + factor x` for a change, `deck exp(factor x)` for a factor, and `factor x` for a value. Numbers
/// are in the units of the deck, angles in radians.
#[derive(Clone, PartialEq, Debug)]
pub struct DeckUnknown {
    /// Name: the address as the user knows it, with the axis of a hardpoint.
    pub name: String,
    /// Address that names the unknown: the address of its first number, or of the coordinate of a hardpoint.
    pub address: Address,
    /// Form of the unknown: change, factor or value.
    pub form: UnknownForm,
    /// Numbers that the unknown sets.
    pub numbers: Vec<SetNumber>,
    /// Markers that move with a hardpoint; empty for other numbers.
    pub markers: Vec<MarkerIx>,
    /// Dimension of the number.
    pub dimension: Dimension,
    /// Coordinate at which the search begins.
    pub start: f64,
    /// Lower and upper bound of the coordinate; infinite without bounds.
    pub bounds: [f64; 2],
    /// Mean of the prior.
    pub mean: f64,
    /// Standard deviation of the prior; infinite without a prior.
    pub sd: f64,
    /// Unit of the coordinate in a fit. For a point of a smooth change, it is the stated standard deviation of each point; otherwise it
    /// equals `sd`.
    pub unit_sd: f64,
    /// Position of the table in `study.toml`.
    pub span: Span,
}

impl DeckUnknown {
    /// Returns the value of the unknown as the user states it: the change, the factor or the value.
    pub fn shown(&self, x: f64) -> f64 {
        match self.form {
            UnknownForm::Factor => libm::exp(x),
            UnknownForm::Change | UnknownForm::Value => x,
        }
    }

    /// Returns the derivative of [`Self::shown`] with respect to the coordinate.
    pub fn shown_rate(&self, x: f64) -> f64 {
        match self.form {
            UnknownForm::Factor => libm::exp(x),
            UnknownForm::Change | UnknownForm::Value => 1.0,
        }
    }

    /// Returns the coordinate at which the deck is unchanged. For a value, it is the coordinate of the first number.
    pub fn deck(&self) -> f64 {
        match self.form {
            UnknownForm::Change | UnknownForm::Factor => 0.0,
            UnknownForm::Value => self.numbers[0].deck / self.numbers[0].factor,
        }
    }

    /// Returns the change of each number from its value in the deck.
    fn change(&self, number: &SetNumber, x: f64) -> f64 {
        match self.form {
            UnknownForm::Change => number.factor * x,
            UnknownForm::Factor => number.deck * libm::expm1(number.factor * x),
            UnknownForm::Value => number.factor * x - number.deck,
        }
    }

    /// Returns the derivative of each number with respect to the coordinate, with the address of the number.
    pub fn rates(&self, x: f64) -> Vec<(Address, f64)> {
        let rate = |number: &SetNumber| match self.form {
            UnknownForm::Change | UnknownForm::Value => number.factor,
            UnknownForm::Factor => number.factor * number.deck * libm::exp(number.factor * x),
        };
        let each = self.numbers.iter();
        each.map(|number| (number.address.clone(), rate(number)))
            .collect()
    }
}

/// Returns the numbers of the deck for the coordinates `x` of the unknowns, each with its address. If several unknowns change the same number,
/// the changes add up. This happens for a hardpoint whose marker is rotated relative to ground.
pub fn written_numbers(unknowns: &[DeckUnknown], x: &[f64]) -> Vec<(Address, f64)> {
    let mut all: BTreeMap<&Address, f64> = BTreeMap::new();
    for (unknown, x) in unknowns.iter().zip(x) {
        for number in &unknown.numbers {
            *all.entry(&number.address).or_insert(number.deck) += unknown.change(number, *x);
        }
    }
    all.into_iter()
        .map(|(address, value)| (address.clone(), value))
        .collect()
}

/// A coordinate of a hardpoint, or a single number, before factors and bounds.
struct Found {
    name: String,
    address: Address,
    numbers: Vec<(Address, f64)>,
    markers: Vec<MarkerIx>,
    dimension: Dimension,
}

impl Found {
    /// Returns the axis of a hardpoint; empty for other numbers.
    fn axis(&self) -> String {
        if self.markers.is_empty() {
            String::new()
        } else {
            self.name.rsplit(' ').next().unwrap_or_default().to_string()
        }
    }

    /// Returns the key by which two coordinates are recognised as the same: the axis and the numbers that the coordinate sets.
    fn key(&self) -> (String, Vec<Address>) {
        let mut addresses: Vec<Address> = self.numbers.iter().map(|one| one.0.clone()).collect();
        addresses.sort();
        (self.axis(), addresses)
    }
}

/// The deck in which names are resolved.
struct Deck<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
    study: &'a Source,
    mirror: Mirror,
    /// Markers that define a hardpoint although no parts are joined there, such as those of a steer axis.
    further: &'a [MarkerIx],
}

/// Resolves the unknowns of a study in its deck.
///
/// The address of a marker's QP denotes the hardpoint at that marker: all markers at this position in which connections end move together, in
/// ground axes. `further` lists markers that move with a hardpoint although no connection ends at them. Names that cannot be resolved are
/// reported in `out`, with their position in `study.toml`.
pub fn resolved(
    settings: &[UnknownSettings],
    (dataset, model): (&Dataset, &Model),
    study: &Source,
    (mirror, further): (Mirror, &[MarkerIx]),
    out: &mut Vec<Diagnostic>,
) -> Vec<DeckUnknown> {
    let deck = Deck {
        dataset,
        model,
        study,
        mirror,
        further,
    };
    let mut all = Vec::new();
    let mut taken = BTreeSet::new();
    for own in settings {
        match deck.unknowns(own, &mut taken) {
            Ok(found) => all.extend(found),
            Err(wrong) => out.push(*wrong),
        }
    }
    all
}

impl Deck<'_> {
    fn complain(&self, span: Span, code: Code, message: String) -> Box<Diagnostic> {
        Box::new(Diagnostic::error(code, message).label(self.study.name(), span, ""))
    }

    fn unknowns(
        &self,
        settings: &UnknownSettings,
        taken: &mut BTreeSet<(String, Vec<Address>)>,
    ) -> Result<Vec<DeckUnknown>, Box<Diagnostic>> {
        let mut found: Vec<Found> = Vec::new();
        for text in &settings.numbers {
            let refuse = |mut why: Diagnostic| {
                why.labels.clear();
                Box::new(why.label(self.study.name(), text.span, ""))
            };
            let addresses = Address::matching(&text.text, self.dataset).map_err(refuse)?;
            for address in addresses
                .iter()
                .flat_map(|address| every_number(address, self.dataset))
            {
                let own = self.find(&address, settings, text.span)?;
                // A hardpoint named by two of its markers, or by its mirror image as well, is one unknown.
                if taken.insert(own.key()) {
                    found.push(own);
                }
            }
        }
        if settings.smooth.is_some() {
            return self.smooth(settings, found);
        }
        let factors = match &settings.factors {
            None => vec![1.0; found.len()],
            Some(factors) if settings.together && factors.len() == found.len() => factors.clone(),
            Some(factors) => {
                let message = if settings.together {
                    format!(
                        "`factors` must have one entry per number (factors: {}, numbers: {})",
                        factors.len(),
                        found.len()
                    )
                } else {
                    "`factors` applies only to an unknown that changes several numbers together: add together = true"
                        .to_string()
                };
                return Err(self.complain(settings.span, Code::BadSetting, message));
            }
        };
        let groups: Vec<Vec<(Found, f64)>> = if settings.together {
            self.joined(found.into_iter().zip(factors))
        } else {
            found.into_iter().map(|one| vec![(one, 1.0)]).collect()
        };
        groups
            .into_iter()
            .map(|group| self.unknown(settings, group))
            .collect()
    }

    /// Creates the unknowns for points of SPLINEs whose change is smooth along x.
    fn smooth(
        &self,
        settings: &UnknownSettings,
        found: Vec<Found>,
    ) -> Result<Vec<DeckUnknown>, Box<Diagnostic>> {
        let refuse = |message: String| self.complain(settings.span, Code::BadSetting, message);
        let others = [
            ("form", settings.form != UnknownForm::Change),
            ("together", settings.together),
            ("factors", settings.factors.is_some()),
            ("symmetric", settings.symmetric),
            ("start", settings.start.is_some()),
            ("mean", settings.mean.is_some()),
        ];
        if let Some((key, _)) = others.iter().find(|(_, is_set)| *is_set) {
            return Err(refuse(format!("`smooth` cannot be combined with `{key}`")));
        }
        if settings.sd.is_none() {
            let message = "`smooth` needs `sd`, the standard deviation of each point".to_string();
            return Err(refuse(message));
        }
        let mut splines: BTreeMap<Option<u32>, (Vec<f64>, Vec<Found>)> = BTreeMap::new();
        for point in found {
            let Some(x) = self.spline_x(&point.address) else {
                let message = format!("{} is not a point of a curve of a SPLINE", point.address);
                return Err(refuse(message));
            };
            let (places, points) = splines.entry(point.address.id).or_default();
            places.push(x);
            points.push(point);
        }
        let mut all = Vec::new();
        for (x, points) in splines.into_values() {
            for own in smooth_changes(&x, settings.smooth.unwrap_or(f64::INFINITY)) {
                let named = &points[own.point];
                let numbers = points.iter().zip(&own.factors);
                let change = Found {
                    name: named.name.clone(),
                    address: named.address.clone(),
                    numbers: numbers
                        .filter(|(_, factor)| **factor != 0.0)
                        .map(|(point, factor)| (point.address.clone(), *factor))
                        .collect(),
                    markers: Vec::new(),
                    dimension: named.dimension,
                };
                let mut unknown = self.unknown(settings, vec![(change, 1.0)])?;
                unknown.sd *= own.share;
                all.push(unknown);
            }
        }
        Ok(all)
    }

    /// Returns the x value of the point whose y value has this address. Returns `None` if the address is not a y value of a curve.
    fn spline_x(&self, address: &Address) -> Option<f64> {
        if address.kind != "SPLINE" || address.argument.as_deref() != Some("Y") {
            return None;
        }
        let statement = self.dataset.find(address)?;
        let values = |name: &str| -> Vec<f64> {
            let all = statement.all(name).flat_map(Argument::numbers);
            all.map(|number| number.value).collect()
        };
        let x = values("X");
        let is_curve = values("Y").len() == x.len();
        x.get(address.index? - 1).copied().filter(|_| is_curve)
    }

    /// Groups the numbers of a table into unknowns: all numbers together, or for hardpoints one group per axis.
    fn joined(&self, found: impl Iterator<Item = (Found, f64)>) -> Vec<Vec<(Found, f64)>> {
        let mut groups: BTreeMap<String, Vec<(Found, f64)>> = BTreeMap::new();
        for (one, factor) in found {
            let axis = one.axis();
            groups.entry(axis).or_default().push((one, factor));
        }
        groups.into_values().collect()
    }

    fn find(
        &self,
        address: &Address,
        settings: &UnknownSettings,
        span: Span,
    ) -> Result<Found, Box<Diagnostic>> {
        let is_point = address.kind == "MARKER" && address.argument.as_deref() == Some("QP");
        if is_point && !settings.alone {
            return self.hardpoint(address, settings, span);
        }
        let no_number = || {
            let message = format!("{address} is not a number of the deck");
            self.complain(span, Code::WrongType, message)
        };
        self.dataset.value_at(address).ok_or_else(no_number)?;
        let mut numbers = vec![(address.clone(), 1.0)];
        if settings.symmetric {
            let partner = self.mirror.partner(address, self.dataset, self.model);
            let signed = matches!(address.argument.as_deref(), Some("FORCE" | "TORQUE"))
                && address.index.is_some();
            let message = match &partner {
                None => Some(format!(
                    "the element of {address} has no mirror image in the deck"
                )),
                Some(_) if signed => Some(format!(
                    "the sign of {address} on the other side depends on the axes of the markers"
                )),
                Some(_) => None,
            };
            if let Some(message) = message {
                let mut wrong = self.complain(span, Code::BadSetting, message);
                wrong.help = Some(
                    "write both numbers, with together = true and factors = [1, -1]".to_string(),
                );
                return Err(wrong);
            }
            numbers.extend(partner.map(|partner| (partner, 1.0)));
        }
        Ok(Found {
            name: address.to_string(),
            address: address.clone(),
            numbers,
            markers: Vec::new(),
            dimension: address.dimension(),
        })
    }

    /// Returns a coordinate of the hardpoint of a marker, with its mirror image.
    fn hardpoint(
        &self,
        address: &Address,
        settings: &UnknownSettings,
        span: Span,
    ) -> Result<Found, Box<Diagnostic>> {
        let axis = address.index.unwrap_or(1) - 1;
        let missing = || {
            let message = format!("{address} is not a coordinate of a marker with a position");
            self.complain(span, Code::WrongType, message)
        };
        let marker = address.id.and_then(|id| self.model.marker(id));
        let marker = marker.filter(|_| axis < 3).ok_or_else(missing)?;
        if settings.form != UnknownForm::Change {
            let message = format!(
                "{address} is a hardpoint, which can only be displaced: use form = \"change\", or alone = true for this marker alone"
            );
            return Err(self.complain(span, Code::BadSetting, message));
        }
        let all = points(self.model);
        let at = |here: &Vec3| -> Vec<MarkerIx> {
            let near = |there: Vec3| (there - here).norm() * self.model.units.length.si < 1e-6;
            let point = all.iter().find(|point| near(point.place));
            let mut markers = point.map_or_else(Vec::new, |point| point.markers.clone());
            let beside = self.further.iter().copied();
            markers.extend(beside.filter(|marker| near(place(self.model, *marker))));
            markers.sort_by_key(|marker| marker.0);
            markers.dedup();
            markers
        };
        let here = place(self.model, marker);
        let mut markers = at(&here);
        if !markers.contains(&marker) {
            markers.push(marker);
        }
        let direction = Vec3::ith(axis, 1.0);
        let mut numbers = self.moved(&markers, &direction, &address.to_string(), span)?;
        if settings.symmetric {
            let image = self.mirror.image(&here);
            let turned = self.mirror.image(&direction);
            let own = self.mirror.are_images(&here, &here, self.model);
            let others = all
                .iter()
                .find(|point| self.mirror.are_images(&here, &point.place, self.model));
            let mut other = others.map_or_else(|| at(&image), |point| at(&point.place));
            if own {
                if turned != direction {
                    let message = format!(
                        "the hardpoint of {address} lies in the centre plane of the vehicle, so it cannot move sideways with symmetric = true"
                    );
                    return Err(self.complain(span, Code::BadSetting, message));
                }
                other.clear();
            } else if other.is_empty() {
                let message = format!("the hardpoint of {address} has no mirror image in the deck");
                return Err(self.complain(span, Code::BadSetting, message));
            }
            numbers.extend(self.moved(&other, &turned, &address.to_string(), span)?);
            markers.extend(other);
        }
        let axes = ["x", "y", "z"];
        Ok(Found {
            name: format!("MARKER/{} {}", address.id.unwrap_or_default(), axes[axis]),
            address: address.clone(),
            numbers,
            markers,
            dimension: Dimension::LENGTH,
        })
    }

    /// Returns the numbers that move markers along a direction, with their changes.
    fn moved(
        &self,
        markers: &[MarkerIx],
        direction: &Vec3,
        name: &str,
        span: Span,
    ) -> Result<Vec<(Address, f64)>, Box<Diagnostic>> {
        let Effect::Always(pairs) = shift(self.model, markers, direction) else {
            return Ok(Vec::new());
        };
        let missing = pairs
            .iter()
            .find(|(address, _)| self.dataset.value_at(address).is_none());
        match missing {
            None => Ok(pairs),
            Some((address, _)) => {
                let message =
                    format!("`{name}` cannot move: {address} is not a number of the deck");
                Err(self.complain(span, Code::WrongType, message))
            }
        }
    }

    /// Creates one unknown from numbers with their factors.
    fn unknown(
        &self,
        settings: &UnknownSettings,
        group: Vec<(Found, f64)>,
    ) -> Result<DeckUnknown, Box<Diagnostic>> {
        let (first, _) = &group[0];
        let (form, dimension) = (settings.form, first.dimension);
        let name = match group.len() {
            1 => first.name.clone(),
            count => format!("{} and {} more", first.name, count - 1),
        };
        let mut numbers = Vec::new();
        for (one, factor) in &group {
            for (address, own) in &one.numbers {
                let deck = self.dataset.value_at(address).unwrap_or_default();
                if form == UnknownForm::Factor && deck == 0.0 {
                    // A factor leaves a zero among several numbers as it is, such as the origin of a curve.
                    if settings.together {
                        continue;
                    }
                    let message = format!("{address} is 0, so a factor cannot change it");
                    return Err(self.complain(settings.span, Code::BadSetting, message));
                }
                numbers.push(SetNumber {
                    address: address.clone(),
                    factor: own * factor,
                    deck,
                });
            }
        }
        if numbers.is_empty() {
            let message = format!("all numbers of {name} are 0, so a factor cannot change them");
            return Err(self.complain(settings.span, Code::BadSetting, message));
        }
        if numbers.iter().any(|number| number.factor == 0.0) {
            let message = "a factor must not be 0".to_string();
            return Err(self.complain(settings.span, Code::BadSetting, message));
        }
        let units = &self.model.units;
        let plain = |quantity: &Quantity| match form {
            UnknownForm::Factor => quantity.plain(self.study),
            UnknownForm::Change | UnknownForm::Value => {
                quantity.in_units(dimension, units, self.study)
            }
        };
        let coordinate = |quantity: &Quantity| -> Result<f64, Box<Diagnostic>> {
            let value = plain(quantity)?;
            if form == UnknownForm::Factor {
                if value <= 0.0 {
                    let message = "a factor must be more than 0".to_string();
                    return Err(self.complain(quantity.spelled.span, Code::BadSetting, message));
                }
                return Ok(libm::log(value));
            }
            Ok(value)
        };
        let mut unknown = DeckUnknown {
            name,
            address: first.address.clone(),
            form,
            numbers,
            markers: group
                .iter()
                .flat_map(|(one, _)| one.markers.clone())
                .collect(),
            dimension,
            start: 0.0,
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
            mean: 0.0,
            sd: f64::INFINITY,
            unit_sd: f64::INFINITY,
            span: settings.span,
        };
        unknown.start = unknown.deck();
        if let Some(start) = &settings.start {
            unknown.start = coordinate(start)?;
        }
        if let Some([least, most]) = &settings.bounds {
            unknown.bounds = [coordinate(least)?, coordinate(most)?];
            if unknown.bounds[0] >= unknown.bounds[1] {
                let message = "the lower bound must be below the upper bound".to_string();
                return Err(self.complain(least.spelled.span, Code::BadSetting, message));
            }
            if !(unknown.bounds[0]..=unknown.bounds[1]).contains(&unknown.start) {
                let message = format!(
                    "{} starts outside of its bounds: give `start`",
                    unknown.name
                );
                return Err(self.complain(least.spelled.span, Code::BadSetting, message));
            }
        }
        unknown.mean = match &settings.mean {
            Some(mean) => coordinate(mean)?,
            None => unknown.deck(),
        };
        // The standard deviation of a factor refers to its logarithm. If it is small, it equals the relative standard deviation.
        if let Some(sd) = &settings.sd {
            unknown.sd = plain(sd)?;
            unknown.unit_sd = unknown.sd;
        }
        Ok(unknown)
    }
}

/// Returns the addresses of all numbers of an argument.
fn every_number(address: &Address, dataset: &Dataset) -> Vec<Address> {
    let (Some(name), None) = (&address.argument, address.index) else {
        return vec![address.clone()];
    };
    let is_point = address.kind == "MARKER" && name == "QP";
    let count = if is_point {
        3
    } else {
        dataset.find(address).map_or(0, |statement| {
            statement.all(name).flat_map(Argument::numbers).count()
        })
    };
    if count < 2 {
        return vec![address.clone()];
    }
    let place = |index| Address {
        index: Some(index),
        ..address.clone()
    };
    (1..=count).map(place).collect()
}
