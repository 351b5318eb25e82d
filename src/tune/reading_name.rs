//! Names of forces, positions and readings in goals, in addition to the characteristics of an axle.

use std::cell::Cell;

use admire_kc::{Unit, shown};
use admire_solver::mechanics::{Mat3, Vec3};
use admire_solver::model::{Header, Marker, MarkerIx, Model, Orientation, PartIx, Relative};
use admire_solver::statics::{FORCE_COMPONENTS, Probe};
use admire_solver::system::System;
use admire_study::{Measurement, did_you_mean, part};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset};

/// Components of a marker: its position in ground, and the rotation of its part from the design position about the ground axes.
const OF_MARKER: [&str; 6] = ["X", "Y", "Z", "AX", "AY", "AZ"];
/// Readings of the wheel, named like the columns of `wheel.csv`.
const OF_WHEEL: [&str; 5] = ["x", "y", "z", "camber_deg", "steer_deg"];

/// Force, position or reading that a goal names.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Named {
    pub probe: Probe,
    /// Unit of the probe's value; `None` for a channel, because its function may have any unit.
    pub unit: Option<Unit>,
    /// Unit of a channel as stated in the study; empty for other quantities.
    pub stated_unit: String,
    /// Index of the channel among the channels of the study; `None` for other quantities.
    pub channel: Option<usize>,
}

impl Named {
    fn of(probe: Probe, unit: Unit) -> Self {
        Self {
            probe,
            unit: Some(unit),
            stated_unit: String::new(),
            channel: None,
        }
    }

    /// Returns the factor that converts the probe's value to the goal's value, and the unit of the goal.
    pub(crate) fn shown(&self, units: &Units) -> (f64, String) {
        match self.unit {
            Some(unit) => shown(1.0, unit, units),
            None => (1.0, self.stated_unit.clone()),
        }
    }
}

/// Names that goals may use.
pub(crate) struct Names<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
    /// Readings of the study; `None` for goals that read tests.
    measurement: Option<&'a Measurement>,
    /// Force elements and constraints of the deck, by keyword and id.
    elements: Vec<(&'static str, u32)>,
    /// Next id of an auxiliary marker. These ids count down from the largest id, because the ids of the rig and of the wheel gauge count up
    /// from the ids of the deck.
    next_id: Cell<u32>,
}

impl<'a> Names<'a> {
    pub(crate) fn new(
        dataset: &'a Dataset,
        model: &'a Model,
        measurement: Option<&'a Measurement>,
    ) -> Self {
        let system = System::compile(model).value;
        let elements = system.elements().map(|(_, name)| (name.kind, name.id));
        let constraints = system.constraints().map(|(_, name)| (name.kind, name.id));
        let nforces = model.nforces.iter().map(|own| ("NFORCE", own.header.id));
        Self {
            dataset,
            model,
            measurement,
            elements: elements.chain(constraints).chain(nforces).collect(),
            next_id: Cell::new(u32::MAX),
        }
    }

    /// Resolves a name. Returns `None` if it names neither an object of the deck nor a reading; it may then be a characteristic.
    pub(crate) fn named(&self, of: &str) -> Option<Result<Named, Box<Diagnostic>>> {
        let found = self.reading(of).or_else(|| self.wheel(of));
        if let Some(found) = found.or_else(|| self.mark(of)) {
            return Some(Ok(found));
        }
        let (object, component) = of.rsplit_once('.').unwrap_or((of, ""));
        match Address::parse(object, self.dataset) {
            Ok(address) if address.argument.is_none() => Some(self.component(&address, component)),
            Ok(_) => Some(Err(self.unknown(of))),
            Err(why) if object.contains('/') => {
                // A misspelt keyword is compared with the objects of the deck.
                let meant = did_you_mean(object, "the deck", &self.objects());
                let is_near = meant.starts_with("did you mean");
                Some(Err(Box::new(if is_near { why.help(meant) } else { why })))
            }
            Err(_) => None,
        }
    }

    /// Returns the diagnostic for a name that refers to nothing that a goal can read.
    pub(crate) fn unknown(&self, of: &str) -> Box<Diagnostic> {
        let message = format!("`{of}` is not a force, position or reading of this study");
        let help = did_you_mean(of, "the study", &self.all());
        Box::new(Diagnostic::error(Code::BadSetting, message).help(help))
    }

    /// Returns the addresses of all elements and markers.
    fn objects(&self) -> Vec<String> {
        let elements = self.elements.iter();
        let elements = elements.map(|(kind, id)| format!("{kind}/{id}"));
        let markers = self.model.markers.iter();
        let markers = markers.map(|marker| format!("MARKER/{}", marker.header.id));
        elements.chain(markers).collect()
    }

    /// Returns the names of all elements, markers, marks and readings, one name each.
    fn all(&self) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        if let Some(measurement) = self.measurement {
            all.extend(measurement.channels.iter().map(|own| own.name.clone()));
            if measurement.wheel.is_some() {
                all.extend(OF_WHEEL.map(|word| format!("wheel.{word}")));
            }
            for marked in &measurement.parts {
                let marks = marked.marks.iter();
                all.extend(marks.map(|mark| format!("{} {}.X", marked.name, mark.label)));
            }
        }
        let objects = self.objects().into_iter();
        all.extend(objects.map(|object| {
            let is_marker = object.starts_with("MARKER/");
            object + if is_marker { ".X" } else { ".FX" }
        }));
        all
    }

    fn component(&self, address: &Address, component: &str) -> Result<Named, Box<Diagnostic>> {
        let complain = |message: String, help: String| {
            Box::new(Diagnostic::error(Code::BadSetting, message).help(help))
        };
        let Some(id) = address.id else {
            return Err(self.unknown(&address.to_string()));
        };
        let upper = component.to_ascii_uppercase();
        let unknown = |known: &[&str]| {
            let known: Vec<String> = known.iter().map(|word| (*word).to_string()).collect();
            let message = if component.is_empty() {
                format!("`{address}` needs a component")
            } else {
                format!("`{component}` is not a component of {address}")
            };
            complain(message, did_you_mean(&upper, &address.to_string(), &known))
        };
        if address.kind == "MARKER" {
            let marker = self.model.marker(id);
            let marker = marker.ok_or_else(|| self.unknown(&address.to_string()))?;
            let known = OF_MARKER.iter().position(|word| *word == upper);
            let k = known.ok_or_else(|| unknown(&OF_MARKER))?;
            return Ok(match k {
                0..3 => Named::of(place(id, k, Vec::new()), Unit::Length),
                _ => Named::of(self.rotation(marker, k - 3), Unit::Angle),
            });
        }
        let is_known = |own: &&(&'static str, u32)| own.0 == address.kind && own.1 == id;
        let Some((kind, _)) = self.elements.iter().find(is_known) else {
            let message = format!("{address} exerts no force");
            let elements = self.elements.iter();
            let all: Vec<String> = elements.map(|(kind, id)| format!("{kind}/{id}")).collect();
            let help = did_you_mean(&address.to_string(), "the deck", &all);
            return Err(complain(message, help));
        };
        if address.kind == "NFORCE" {
            return self
                .of_nforce(id, &upper)
                .ok_or_else(|| unknown(&FORCE_COMPONENTS));
        }
        let known = FORCE_COMPONENTS.iter().position(|word| *word == upper);
        let component = known.ok_or_else(|| unknown(&FORCE_COMPONENTS))?;
        let probe = Probe::Force {
            kind: (*kind).to_string(),
            id,
            component,
        };
        Ok(Named::of(probe, unit_of(component)))
    }

    /// Returns the force of an NFORCE at its first I marker, or at the second with a name such as `FX_2`. Result files use the same names.
    fn of_nforce(&self, id: u32, word: &str) -> Option<Named> {
        let (word, number) = word.split_once('_').unwrap_or((word, "1"));
        let component = FORCE_COMPONENTS.iter().position(|own| *own == word)?;
        let mut all = self.model.nforces.iter();
        let own = all.find(|own| own.header.id == id)?;
        let number = number.parse::<usize>().ok()?.checked_sub(1)?;
        let at = self.model.markers[own.i.get(number)?.0].header.id;
        let probe = Probe::Function {
            text: format!("NFORCE({id},{at},{},0)", component + 1),
            markers: Vec::new(),
        };
        Some(Named::of(probe, unit_of(component)))
    }

    /// Returns the channel of the study with this name.
    fn reading(&self, of: &str) -> Option<Named> {
        let channels = &self.measurement?.channels;
        let k = channels.iter().position(|own| own.name == of)?;
        let own = &channels[k];
        let markers = own.helpers.iter().filter_map(|helper| {
            let beside = &self.model.markers[self.model.marker(helper.beside)?.0];
            let mut marker = self.helper(beside.part, helper.place, beside.R, None);
            marker.header.id = helper.id;
            Some(marker)
        });
        Some(Named {
            probe: Probe::Function {
                text: own.function.clone(),
                markers: markers.collect(),
            },
            unit: None,
            stated_unit: own.unit.clone().unwrap_or_default(),
            channel: Some(k),
        })
    }

    /// Returns the reading of the wheel with this name, such as `wheel.x` or `wheel.camber_deg`. The names are those of the columns of
    /// `wheel.csv`.
    fn wheel(&self, of: &str) -> Option<Named> {
        let wheel = self.measurement?.wheel.as_ref()?;
        let word = of.strip_prefix("wheel.")?;
        let k = OF_WHEEL.iter().position(|own| *own == word)?;
        let id = self.model.markers[wheel.marker.0].header.id;
        if k < 3 {
            return Some(Named::of(place(id, k, Vec::new()), Unit::Length));
        }
        // The second marker is one unit of length along the spin axis.
        let own = &self.model.markers[wheel.marker.0];
        let offset = Vec3::ith(wheel.spin.axis, wheel.spin.sense);
        let relative = Relative {
            rm: wheel.marker,
            qp: offset,
            orientation: Orientation::Points,
            R: Mat3::identity(),
        };
        let end = self.helper(own.part, own.qp + own.R * offset, own.R, Some(relative));
        let [x, y, z] = ["X", "Y", "Z"].map(|axis| format!("D{axis}({},{id})", end.header.id));
        let s0 = wheel.spin.s0;
        let text = if k == 3 {
            format!("{:.15e}-ASIN({z})", libm::asin(s0.z.clamp(-1.0, 1.0)))
        } else {
            // The angle from the design direction, so that it does not jump at 180 degrees of the direction itself.
            let across = libm::hypot(s0.x, s0.y);
            let [c, s] = [s0.x, s0.y].map(|own| format!("({:.15e})", own / across));
            format!("ATAN2({c}*{y}-{s}*{x},{c}*{x}+{s}*{y})")
        };
        let probe = Probe::Function {
            text,
            markers: vec![end],
        };
        Some(Named::of(probe, Unit::Angle))
    }

    /// Returns a coordinate of a mark in ground, given by a name such as `KNUCKLE 3.X`.
    fn mark(&self, of: &str) -> Option<Named> {
        let (object, component) = of.rsplit_once('.')?;
        let (name, label) = object.trim().rsplit_once(' ')?;
        let own = part(name, self.model)?;
        let component = component.to_ascii_uppercase();
        let k = OF_MARKER[..3].iter().position(|word| *word == component)?;
        let mut parts = self.measurement?.parts.iter();
        let marked = parts.find(|marked| marked.part == own)?;
        let mark = marked.marks.iter().find(|mark| mark.label == label)?;
        let marker = self.helper(own, mark.p, Mat3::identity(), None);
        let id = marker.header.id;
        Some(Named::of(place(id, k, vec![marker]), Unit::Length))
    }

    /// Returns the rotation of a marker's part from the design position about ground axis `k`.
    fn rotation(&self, marker: MarkerIx, k: usize) -> Probe {
        let own = self.model.markers[marker.0].part;
        let upright = self.model.parts[own.0].pose.R.transpose();
        let marker = self.helper(own, Vec3::zeros(), upright, None);
        let axis = ["X", "Y", "Z"][k];
        Probe::Function {
            text: format!("A{axis}({})", marker.header.id),
            markers: vec![marker],
        }
    }

    /// Creates an auxiliary marker on a part. No marker of the deck has its id.
    fn helper(&self, part: PartIx, qp: Vec3, R: Mat3, relative: Option<Relative>) -> Marker {
        let taken = |id: &u32| self.model.marker(*id).is_some();
        let mut down = (0..=self.next_id.get()).rev().skip_while(taken);
        let id = down
            .next()
            .expect("a deck has fewer markers than there are ids");
        self.next_id.set(id - 1);
        Marker {
            header: Header {
                id,
                origin: usize::MAX,
                ..Header::default()
            },
            part,
            qp,
            orientation: Orientation::Points,
            R,
            floating: false,
            relative,
        }
    }
}

/// Returns coordinate `k` (0 to 2) of a marker's position in ground.
fn place(id: u32, k: usize, markers: Vec<Marker>) -> Probe {
    Probe::Function {
        text: format!("D{}({id})", ["X", "Y", "Z"][k]),
        markers,
    }
}

fn unit_of(component: usize) -> Unit {
    if component < 4 {
        Unit::Force
    } else {
        Unit::Torque
    }
}
