use admire_session::backend::LoadProgramme;
use admire_solver::mechanics::{Mat3, Pose, Vec3, psi_theta_phi};
use admire_solver::model::{MarkerIx, Model, PairForce};
use admire_syntax::car_field::CarField;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::{Address, Dataset, NewStatement};

use super::{EffectSpec, HistoryState};

/// Components of a force between two markers, in the words of a GFORCE.
const FORCES: [&str; 6] = admire_syntax::FORCE_COMPONENTS;

/// A fault of the readings, applied to the readings after the equilibria have been solved.
#[derive(Clone, PartialEq, Debug)]
pub enum ReadingFault {
    /// Displacement of the measuring frame in one case: a rigid motion of all mark readings of that case.
    Frame {
        /// Index of the load case.
        case: usize,
        /// Rigid motion that is applied to the mark readings.
        pose: Pose,
        /// Change of the motion from the first mark read to the last, relative to the motion.
        creep: f64,
    },
    /// Wrong reading of a single mark in a single case.
    Mark {
        /// Index of the load case.
        case: usize,
        /// Index of the marked part.
        part: usize,
        /// Index of the mark on the part.
        mark: usize,
        /// Error of the reading, in ground axes.
        shift: Vec3,
    },
    /// Wrong position of a mark on its part.
    Place {
        /// Index of the first case with the displacement. The mark stays displaced in all later cases.
        first: usize,
        /// Index of the marked part.
        part: usize,
        /// Index of the mark on the part.
        mark: usize,
        /// Displacement of the mark in the frame of the part.
        shift: Vec3,
    },
    /// Wrong reading of a channel, `gain * value + offset`, in one case or in all cases.
    Channel {
        /// Index of the channel.
        channel: usize,
        /// Gain of the channel.
        gain: f64,
        /// Offset of the channel, in its unit.
        offset: f64,
        /// Index of the only case with the fault; `None` for all cases.
        case: Option<usize>,
    },
    /// Growth of all mark positions about the ground origin, in proportion to the number of cases already measured.
    Growth {
        /// Relative growth reached in the last case.
        growth: f64,
    },
    /// Exchange of the readings of marks on two parts.
    Exchanged {
        /// Index of the first case with the exchange. The readings stay exchanged in all later cases.
        first: usize,
        /// Indices of the two marked parts.
        parts: [usize; 2],
        /// Pairs of marks that are exchanged: index of the mark on the first part, and index on the second part.
        pairs: Vec<(usize, usize)>,
    },
}

/// A part that carries marks (measured points).
#[derive(Clone, PartialEq, Debug)]
pub struct Marked {
    /// View name of the part.
    pub name: String,
    /// Id of the part.
    pub id: u32,
    /// Labels of the marks on the part.
    pub labels: Vec<String>,
    /// Positions of the marks in the part's own frame.
    pub places: Vec<Vec3>,
    /// Id of the part that actually carries each mark.
    pub carriers: Vec<u32>,
}

/// An element that acts on a part at a marker.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Holder {
    /// Address of the element: a joint, bushing, spring or force.
    pub object: Address,
    /// Argument of the element that names the marker.
    pub argument: &'static str,
    /// Id of the marker on the part.
    pub marker: u32,
    /// Position of the marker on the part.
    pub place: Vec3,
}

/// The ground truth that a virtual rig measures: deck, loads and faults of the readings, with all effects planted.
#[derive(Clone, Debug)]
pub struct GroundTruth {
    /// Deck with the planted changes.
    pub dataset: Dataset,
    /// Loads that actually act.
    pub programme: LoadProgramme,
    /// States of the history-dependent effects.
    pub memories: Vec<HistoryState>,
    /// Faults of the readings.
    pub faults: Vec<ReadingFault>,
    /// Marked parts with their marks.
    pub marks: Vec<Marked>,
    /// Names of the channels (scalar sensors).
    pub channels: Vec<String>,
}

impl GroundTruth {
    /// Returns the model of the current deck.
    pub(crate) fn model(&self) -> Model {
        Model::lower(&self.dataset).value
    }

    /// Returns the address of an effect, after checking that its element is of one of these kinds.
    ///
    /// A component of a FIELD, `FIELD/9.FX`, has an address here although the statement has no such argument. A bushing of Adams/Car and its
    /// components may also be given by the bushing's name, as in results: `axle.bkl_arm_outer.fx`.
    pub(super) fn object(&self, spec: &EffectSpec, kinds: &[&str]) -> Result<Address, Diagnostic> {
        let address = match self.field(spec.address.trim()) {
            Some(address) => address,
            None => Address::parse(&spec.address, &self.dataset)
                .map_err(|why| spec.refuse(why.message))?,
        };
        if kinds.contains(&address.kind.as_str()) {
            return Ok(address);
        }
        Err(spec.refuse(format!("the address must name a {}", kinds.join(" or "))))
    }

    /// Returns the address of a component of a FIELD, or of a FIELD that is given by the name of its bushing of Adams/Car.
    fn field(&self, text: &str) -> Option<Address> {
        let component = |word: &str| {
            FORCES
                .into_iter()
                .find(|own| own.eq_ignore_ascii_case(word))
        };
        let bushing = |name: &str| {
            let mut all = CarField::all(&self.dataset);
            let is_named =
                |car: &CarField| !name.is_empty() && car.bushing.eq_ignore_ascii_case(name);
            let (field, _) = all.find(|(_, car)| car.as_ref().is_ok_and(is_named))?;
            Address::of(field)
        };
        let split = text.rsplit_once('.');
        if let Some((head, word)) = split.and_then(|(head, word)| Some((head, component(word)?))) {
            let stated = Address::parse(head, &self.dataset).ok();
            let field = stated.filter(|own| own.kind == "FIELD" && own.argument.is_none());
            let argument = Some(word.to_string());
            return field
                .or_else(|| bushing(head))
                .map(|own| Address { argument, ..own });
        }
        bushing(text)
    }

    /// Returns the ids of the I and J markers of the element with this address.
    pub(super) fn pair(
        &self,
        spec: &EffectSpec,
        address: &Address,
    ) -> Result<[u32; 2], Diagnostic> {
        let of = |name: &str| {
            let statement = Address {
                argument: None,
                index: None,
                ..address.clone()
            };
            let value = self.dataset.find(&statement)?.first(name)?;
            Some(value as u32)
        };
        match (of("I"), of("J")) {
            (Some(i), Some(j)) => Ok([i, j]),
            _ => Err(spec.refuse(format!("{address} has no I and J markers"))),
        }
    }

    /// Returns the ids of the I and J markers and the component (0 to 5) for the address of a bushing stiffness, such as `BUSHING/2.K.1`, or of a
    /// component of a FIELD, such as `FIELD/9.FX`.
    pub(super) fn bushing_component(
        &self,
        spec: &EffectSpec,
        address: &Address,
    ) -> Result<([u32; 2], usize), Diagnostic> {
        let word = address.argument.as_deref();
        let index = address.index.filter(|index| (1..=3).contains(index));
        let component = match (address.kind.as_str(), word, index) {
            ("FIELD", Some(word), None) => FORCES.iter().position(|own| *own == word),
            ("FIELD", ..) => None,
            (_, Some("K"), Some(index)) => Some(index - 1),
            (_, Some("KT"), Some(index)) => Some(index + 2),
            _ => None,
        };
        match component {
            Some(component) => Ok((self.pair(spec, address)?, component)),
            None => Err(spec.refuse(
                "the address must name one component, for example BUSHING/2.K.1 or FIELD/9.FX",
            )),
        }
    }

    /// Returns the stiffness of a component that [`Self::bushing_component`] accepts. For a FIELD with curves, it is the slope at zero deflection.
    pub(super) fn stiffness(
        &self,
        spec: &EffectSpec,
        address: &Address,
        component: usize,
    ) -> Result<f64, Diagnostic> {
        let found = if address.kind == "FIELD" {
            let model = self.model();
            let mut fields = model.pair_forces.iter();
            let field = fields.find(|f| f.is_field() && Some(f.header.id) == address.id);
            field.and_then(|field| field_stiffness(&model, field, component))
        } else {
            self.dataset.value_at(address)
        };
        found.ok_or_else(|| spec.refuse(format!("the stiffness of {address} is not known")))
    }

    /// Sets a parameter of the deck.
    pub(super) fn set(&mut self, address: &Address, value: f64) -> Result<(), Diagnostic> {
        let edits = self.dataset.set(address, value)?;
        self.edit(&edits);
        Ok(())
    }

    /// Adds a statement to the deck and returns its id.
    pub(super) fn add(&mut self, kind: &str, arguments: &[(&str, Option<String>)]) -> u32 {
        let same = self
            .dataset
            .statements()
            .iter()
            .filter(|s| s.kind() == Some(kind));
        let id = same
            .filter_map(admire_syntax::Statement::number)
            .max()
            .unwrap_or(0)
            + 1;
        let edits = self.dataset.add(&NewStatement {
            kind: kind.to_string(),
            id: Some(id),
            view_name: None,
            arguments: arguments
                .iter()
                .map(|(name, value)| ((*name).to_string(), value.clone()))
                .collect(),
        });
        self.edit(&edits);
        id
    }

    fn edit(&mut self, edits: &[admire_syntax::text::Edit]) {
        let edited = self.dataset.edited(edits);
        self.dataset = edited.expect("edits of one statement do not overlap").value;
    }

    /// Adds a marker with the given frame to a part and returns its id. `frame` is relative to the part.
    pub(super) fn add_marker(&mut self, part: u32, frame: &Pose) -> u32 {
        let list = |values: [f64; 3]| {
            let words: Vec<String> = values.iter().map(|value| format!("{value:.15e}")).collect();
            Some(words.join(", "))
        };
        let angles = psi_theta_phi(&frame.R);
        self.add(
            "MARKER",
            &[
                ("PART", Some(part.to_string())),
                ("QP", list(frame.p.into())),
                ("REULER", list(angles)),
            ],
        )
    }

    /// Returns the model of the current deck, the index of the marker with this id, and the frame of the marker on its part.
    pub(super) fn marker(
        &self,
        spec: &EffectSpec,
        id: u32,
    ) -> Result<(Model, MarkerIx, Pose), Diagnostic> {
        let model = self.model();
        let Some(at) = model.marker(id) else {
            return Err(spec.refuse(format!("the deck has no MARKER/{id}")));
        };
        let frame = &model.markers[at.0];
        let pose = Pose {
            p: frame.qp,
            R: frame.R,
        };
        Ok((model, at, pose))
    }

    /// Adds a massless part with the same frame as `part` and returns its id. A marker that is moved from one of the two parts to the other
    /// keeps its coordinates.
    pub(super) fn twin(&mut self, part: u32) -> u32 {
        let model = self.model();
        let own = model.parts.iter().find(|other| other.header.id == part);
        let pose = own.map_or_else(Pose::identity, |own| own.pose);
        let list = |values: [f64; 3]| {
            let words: Vec<String> = values.iter().map(|value| format!("{value:.15e}")).collect();
            Some(words.join(", "))
        };
        let frame = [
            ("QG", list(pose.p.into())),
            ("REULER", list(psi_theta_phi(&pose.R))),
        ];
        self.add("PART", &frame)
    }

    /// Returns all joints, bushings, FIELDs, springs and forces that act on a part.
    pub(super) fn attachments(&self, part: u32) -> Vec<Holder> {
        let model = self.model();
        let joints = model
            .joints
            .iter()
            .map(|o| ("JOINT", o.header.id, o.i, Some(o.j)));
        let elastic = model.elastic_pairs();
        let elastic = elastic.map(|e| (e.kind, e.header.id, e.i, Some(e.j)));
        let springs = model
            .springdampers
            .iter()
            .map(|o| ("SPRINGDAMPER", o.header.id, o.i, Some(o.j)));
        let forces = model
            .sforces
            .iter()
            .map(|o| ("SFORCE", o.header.id, o.i, None));
        let mut found = Vec::new();
        for (kind, id, i, j) in joints.chain(elastic).chain(springs).chain(forces) {
            for (argument, marker) in [("I", Some(i)), ("J", j)] {
                let Some(marker) = marker else { continue };
                let frame = &model.markers[marker.0];
                if model.parts[frame.part.0].header.id == part {
                    let object = Address {
                        kind: kind.to_string(),
                        id: Some(id),
                        argument: None,
                        index: None,
                    };
                    found.push(Holder {
                        object,
                        argument,
                        marker: frame.header.id,
                        place: frame.qp,
                    });
                }
            }
        }
        found
    }

    /// Attaches marks of `part` to the part `with`, if their positions on `part` satisfy `which`.
    pub(super) fn carry_marks(&mut self, part: u32, with: u32, which: impl Fn(&Vec3) -> bool) {
        for marked in self.marks.iter_mut().filter(|marked| marked.id == part) {
            for (carrier, place) in marked.carriers.iter_mut().zip(&marked.places) {
                if which(place) {
                    *carrier = with;
                }
            }
        }
    }

    /// Returns the index of the part with marks that has this name, id or address.
    pub(super) fn marked(&self, spec: &EffectSpec, text: &str) -> Result<usize, Diagnostic> {
        let text = text.trim();
        let id = text.rsplit('/').next().and_then(|id| id.parse().ok());
        let found = |marked: &Marked| marked.name == text || Some(marked.id) == id;
        let at = self.marks.iter().position(found);
        at.ok_or_else(|| spec.refuse(format!("no part `{text}` carries marks")))
    }

    /// Moves a marker on its part by `shift`, given in the axes of the part. Its orientation does not change.
    pub(super) fn shift_marker(
        &mut self,
        spec: &EffectSpec,
        address: &Address,
        shift: &Vec3,
    ) -> Result<(), Diagnostic> {
        let (model, at, _) = self.marker(spec, address.id.unwrap_or(0))?;
        let shift = model.markers[at.0].as_written(shift);
        for k in (0..3).filter(|k| shift[*k] != 0.0) {
            let number = Address {
                argument: Some("QP".to_string()),
                index: Some(k + 1),
                ..address.clone()
            };
            let old = self.dataset.value_at(&number).unwrap_or(0.0);
            self.set(&number, old + shift[k])?;
        }
        Ok(())
    }

    /// Moves one object from its marker to a displaced and rotated copy of that marker, and returns the copy's id. The displacement is in
    /// the marker's own axes. The copy lies on `part`, or on the marker's own part if `part` is `None`. Other objects at the old marker stay
    /// where they are.
    pub(super) fn rehang(
        &mut self,
        spec: &EffectSpec,
        object: &Address,
        argument: &str,
        part: Option<u32>,
        displacement: &Pose,
    ) -> Result<u32, Diagnostic> {
        let number = Address {
            argument: Some(argument.to_string()),
            index: None,
            ..object.clone()
        };
        let old = self.dataset.value_at(&number).unwrap_or(0.0) as u32;
        let (model, at, frame) = self.marker(spec, old)?;
        let own = model.parts[model.markers[at.0].part.0].header.id;
        let moved = frame.compose(displacement);
        let new = self.add_marker(part.unwrap_or(own), &moved);
        self.set(&number, f64::from(new))?;
        Ok(new)
    }

    /// Adds forces or torques on I along or about axes of J, with their reactions on J. `forces` holds pairs of component (0 to 5) and ADAMS
    /// function. Terms of the same component are summed.
    pub(super) fn add_component_force(
        &mut self,
        spec: &EffectSpec,
        [i, j]: [u32; 2],
        forces: &[(usize, String)],
    ) -> Result<(), Diagnostic> {
        let (model, at, _) = self.marker(spec, j)?;
        let part = model.parts[model.markers[at.0].part.0].header.id;
        let floating = self.add(
            "MARKER",
            &[("PART", Some(part.to_string())), ("FLOATING", None)],
        );
        let of = |k: usize| {
            let terms: Vec<&str> = forces
                .iter()
                .filter(|(axis, _)| *axis == k)
                .map(|(_, text)| text.as_str())
                .collect();
            // A GFORCE needs all six components. Each of them except the last ends with a backslash.
            let text = if terms.is_empty() {
                "0.0".to_string()
            } else {
                terms.join("")
            };
            if k < 5 { text + "\\" } else { text }
        };
        let mut arguments = vec![
            ("I", Some(i.to_string())),
            ("JFLOAT", Some(floating.to_string())),
            ("RM", Some(j.to_string())),
        ];
        for (k, name) in FORCES.into_iter().enumerate() {
            arguments.push((name, Some(of(k))));
        }
        self.add("GFORCE", &arguments);
        Ok(())
    }

    /// Adds a cubic term to a linear spring along one axis of J, so its force becomes `F = k u (1 + (k u / rated)^2)`.
    pub(super) fn stiffen(
        &mut self,
        spec: &EffectSpec,
        pair: [u32; 2],
        axis: usize,
        stiffness: f64,
        rated: f64,
    ) -> Result<(), Diagnostic> {
        if !(rated > 0.0) {
            return Err(spec.refuse("rated must be above zero"));
        }
        // The spring already provides the linear term.
        let cubic = stiffness.powi(3) / (rated * rated);
        let force = format!("-{cubic:e}*({})**3", displacement(pair, axis));
        self.add_component_force(spec, pair, &[(axis, force)])
    }

    /// Returns the fraction of a load-dependent error that acts in each case. With `law=constant`, the fraction is 1. With `law=growing`, it
    /// rises from 0.5 at zero load to 1 at the largest load.
    pub(super) fn course(&self, spec: &EffectSpec, load: usize) -> Result<Vec<f64>, Diagnostic> {
        let law = spec.word("law", &["constant", "growing"])?;
        let sizes = self.programme.cases.iter().map(|c| c.values[load].abs());
        let most = sizes.clone().fold(f64::MIN_POSITIVE, f64::max);
        let share = |size: f64| match law {
            "constant" => 1.0,
            _ => 0.5 + 0.5 * size / most,
        };
        Ok(sizes.map(share).collect())
    }

    /// Returns the index of the load case with this label.
    pub(super) fn case(&self, spec: &EffectSpec, label: &str) -> Result<usize, Diagnostic> {
        let mut cases = self.programme.cases.iter();
        cases
            .position(|case| case.label == label)
            .ok_or_else(|| spec.refuse(format!("there is no load case `{label}`")))
    }

    /// Returns the index of the load that has this name or drives this address.
    pub(super) fn load(&self, spec: &EffectSpec, text: &str) -> Result<usize, Diagnostic> {
        let text = text.trim();
        let address = Address::parse(text, &self.dataset).ok();
        let mut loads = self.programme.loads.iter();
        loads
            .position(|load| Some(&load.target) == address.as_ref() || load.name == text)
            .ok_or_else(|| spec.refuse(format!("`{text}` is not a load of the study")))
    }
}

/// Returns the stiffness of a FIELD along one component at zero deflection.
fn field_stiffness(model: &Model, field: &PairForce, component: usize) -> Option<f64> {
    let (_, scale) = field.stiffness_scale(model, component)?;
    let Some(car) = &field.car else {
        return Some(scale);
    };
    let mut splines = model.splines.iter();
    let curve = splines.find(|s| s.header.id == car.curves[component])?;
    let y = curve.y.first()?;
    let after = curve.x.iter().position(|x| *x > 0.0)?;
    let before = curve.x.iter().rposition(|x| *x < 0.0)?;
    let slope = (y[after] - y[before]) / (curve.x[after] - curve.x[before]);
    Some(scale * slope * field.car_axis(model, component)?.stretch)
}

/// Returns a rotation matrix whose third column, the z axis, is the given unit vector.
pub(super) fn along(z: &Vec3) -> Mat3 {
    let across = if z.x.abs() < 0.7 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let x = z.cross(&across).normalize();
    Mat3::from_columns(&[x, z.cross(&x), *z])
}

/// Returns the ADAMS function of one component of the displacement of I from J in J axes: 0 to 2 for DX, DY, DZ, and 3 to 5 for AX, AY, AZ.
pub(super) fn displacement([i, j]: [u32; 2], component: usize) -> String {
    match component {
        0..3 => format!("{}({i},{j},{j})", ["DX", "DY", "DZ"][component]),
        _ => format!("{}({i},{j})", ["AX", "AY", "AZ"][component - 3]),
    }
}
