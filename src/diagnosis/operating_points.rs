use super::candidate_effect::Change;
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use admire_identify::global::Row;
use admire_identify::tolerance::{ConnectionPoint, Effect, EffectGroup};
use admire_session::backend::Load;
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{MarkerIx, Model, PartIx};
use admire_solver::system::{Reading, Scratch};
use admire_study::{CausePriors, Measurement};
use admire_syntax::{Address, NewStatement};

/// Attachment point of a part, with the force on the part there.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Attachment {
    /// Marker on the part.
    pub marker: MarkerIx,
    /// Force on the part at the marker in each case, in ground axes.
    pub force: Vec<Vec3>,
}

/// State of every load case at a fit: poses, deflections and forces, and first-order responses of the readings.
pub(super) struct OperatingPoints<'a> {
    /// Model of the study's own deck. Elements added by an extension are not sites for further candidates.
    pub model: &'a Model,
    /// Measurement of the study.
    pub measurement: &'a Measurement,
    pub(super) subject: &'a DiagnosisProblem<'a>,
    pub(super) fitted: &'a FittedModel,
    readings: Vec<(&'static str, u32, Vec<Reading>)>,
}

impl<'a> OperatingPoints<'a> {
    /// Evaluates all force elements and constraints in every case of a fit.
    pub(super) fn new(subject: &'a DiagnosisProblem<'a>, fitted: &'a FittedModel) -> Self {
        let model = subject.problem.model;
        let system = &fitted.deck.prepared.system;
        let mut scratch = Scratch::new(system);
        let elements: Vec<_> = system
            .elements()
            .map(|(ix, name)| (ix, name.clone()))
            .collect();
        let constraints: Vec<_> = system
            .constraints()
            .map(|(ix, name)| (ix, name.clone()))
            .collect();
        let mut readings: Vec<(&'static str, u32, Vec<Reading>)> = elements
            .iter()
            .map(|(_, name)| name)
            .chain(constraints.iter().map(|(_, name)| name))
            .map(|name| (name.kind, name.id, Vec::new()))
            .collect();
        for (theta, state) in fitted.thetas.iter().zip(&fitted.states) {
            let Ok(mut here) = system.evaluate(theta, state, &mut scratch) else {
                continue;
            };
            for (k, (element, _)) in elements.iter().enumerate() {
                if let Ok(reading) = here.read_element(*element) {
                    readings[k].2.push(reading);
                }
            }
            for (k, (constraint, _)) in constraints.iter().enumerate() {
                let reading = here.read_constraint(*constraint);
                readings[elements.len() + k].2.push(reading);
            }
        }
        // Elements that could not be evaluated in every case are not sites for candidates.
        readings.retain(|(_, _, read)| read.len() == fitted.states.len());
        Self {
            model,
            measurement: subject.problem.measurement,
            subject,
            fitted,
            readings,
        }
    }

    /// Returns the section `[priors]` of the study.
    pub(super) fn priors(&self) -> &CausePriors {
        self.subject.problem.priors
    }

    /// Returns the number of load cases.
    pub(super) fn cases(&self) -> usize {
        self.fitted.states.len()
    }

    /// Returns all residual rows.
    pub(super) fn rows(&self) -> &[Row] {
        &self.subject.rows
    }

    /// Returns prediction minus reading of one row, in units of the row's declared noise.
    pub(super) fn residual(&self, row: usize) -> f64 {
        self.fitted.residual[row]
    }

    /// Returns the declared standard deviation of the mark readings, per coordinate and in the deck's length unit.
    pub(super) fn sigma(&self) -> f64 {
        self.subject.sigma
    }

    /// Returns the length of one millimetre in the deck's length unit.
    pub(super) fn millimetre(&self) -> f64 {
        1e-3 / self.model.units.length.si
    }

    /// Returns the force of one newton in the deck's force unit.
    pub(super) fn newton(&self) -> f64 {
        1.0 / self.model.units.force.si
    }

    /// Returns the loads that the study applies.
    pub(super) fn loads(&self) -> &[Load] {
        &self.subject.problem.programme.loads
    }

    /// Returns the values of a load in all cases. They are zero for a load that the study does not apply.
    pub(super) fn load_values(&self, target: &Address) -> Vec<f64> {
        let programme = self.subject.problem.programme;
        let at = programme.loads.iter().position(|l| l.target == *target);
        let value = |values: &[f64]| at.map_or(0.0, |at| values[at]);
        programme.cases.iter().map(|c| value(&c.values)).collect()
    }

    /// Returns the hardpoints of the deck.
    pub(super) fn points(&self) -> &[ConnectionPoint] {
        &self.subject.layer.points
    }

    /// Returns the random effects of a tolerance group at an address, as pairs of index and axis name. Empty if the study switches the group
    /// off.
    pub(super) fn members(&self, group: EffectGroup, address: &str) -> Vec<(usize, String)> {
        let layer = &self.subject.layer;
        if self.subject.sizes.group(group).is_none() {
            return Vec::new();
        }
        let named = |k: usize| {
            (
                k,
                super::candidate_effect::SIX[layer.members[k].axis].to_string(),
            )
        };
        layer.at(group, address).map(named).collect()
    }

    /// Returns the random effects of deck parameters that the study takes as known. Each entry holds the index, the address, the tolerance
    /// group, and the change of the parameter per unit of the random effect.
    pub(super) fn numbers_of_the_deck(&self) -> Vec<(usize, String, EffectGroup, f64)> {
        let known = |group| {
            matches!(
                group,
                EffectGroup::KnownStiffnesses | EffectGroup::SpringRates | EffectGroup::Preloads
            )
        };
        let members = self.subject.layer.members.iter().enumerate();
        members
            .filter(|(_, member)| known(member.group))
            .filter_map(|(k, member)| {
                let Effect::Always(pairs) = &member.effect else {
                    return None;
                };
                Some((k, member.address.clone(), member.group, pairs.first()?.1))
            })
            .collect()
    }

    /// Returns the state of a force element in each case. Empty if the element does not exist.
    pub(super) fn element(&self, kind: &str, id: u32) -> &[Reading] {
        self.readings
            .iter()
            .find(|(k, i, _)| *k == kind && *i == id)
            .map_or(&[], |(_, _, readings)| readings)
    }

    /// Returns the name of every element and joint of the deck, with the magnitude of its force in each case. Elements that apply a load of
    /// the study are left out.
    pub(super) fn forces(&self) -> Vec<(String, Vec<f64>)> {
        let loads = self.loads();
        let driven = |kind: &str, id: u32| {
            loads
                .iter()
                .any(|load| load.target.kind == kind && load.target.id == Some(id))
        };
        self.readings
            .iter()
            .filter(|(kind, id, _)| self.is_of_the_deck(kind, *id) && !driven(kind, *id))
            .map(|(kind, id, readings)| {
                let force = readings.iter().map(|reading| reading.force.norm());
                (format!("{kind}/{id}"), force.collect())
            })
            .collect()
    }

    /// Returns the state of a constraint in each case. Empty if the constraint does not exist.
    pub(super) fn constraint(&self, kind: &str, id: u32) -> &[Reading] {
        self.element(kind, id)
    }

    /// Returns the deflections of a bushing in each case: three translations along the axes of J, then three projected angles.
    pub(super) fn bushing_deflections(&self, bushing: usize) -> Vec<[f64; 6]> {
        self.element("BUSHING", self.model.bushings[bushing].header.id)
            .iter()
            .map(Reading::deflections)
            .collect()
    }

    /// Returns the id of a marker.
    pub(super) fn marker_id(&self, marker: MarkerIx) -> u32 {
        self.model.markers[marker.0].header.id
    }

    /// Returns the pose of a part in a case.
    pub(super) fn pose(&self, case: usize, part: PartIx) -> Pose {
        self.fitted.states[case].poses[part.0]
    }

    /// Returns an id that no statement of this kind uses in the deck of the fit.
    pub(super) fn free_id(&self, kind: &str) -> u32 {
        self.fitted
            .deck
            .dataset
            .statements()
            .iter()
            .filter(|s| s.def.is_some_and(|def| def.name == kind))
            .filter_map(|s| Some(s.id?.0))
            .max()
            .map_or(1, |id| id + 1)
    }

    /// Returns the ADAMS function expression for one component of the displacement of I relative to J, in the axes of J.
    pub(super) fn deflection_function(&self, (i, j): (MarkerIx, MarkerIx), axis: usize) -> String {
        let word = ["DX", "DY", "DZ", "AX", "AY", "AZ"][axis];
        let (i, j) = (self.marker_id(i), self.marker_id(j));
        if axis < 3 {
            format!("{word}({i},{j},{j})")
        } else {
            format!("{word}({i},{j})")
        }
    }

    /// Returns the id of a new GFORCE, with its statement and the statement of its floating marker. `functions` gives its components along
    /// the axes of J: component index and function expression.
    pub(super) fn vector_force(
        &self,
        (i, j): (MarkerIx, MarkerIx),
        functions: &[(usize, &str)],
    ) -> (u32, Vec<NewStatement>) {
        let part = self.model.parts[self.model.markers[j.0].part.0].header.id;
        let pair = [i, j].map(|marker| self.marker_id(marker));
        self.force_between(pair, part, self.free_id("MARKER"), functions)
    }

    /// Returns the id of a new GFORCE between two markers given by id, with its statement. The statement of the floating marker on the part
    /// of J is included.
    pub(super) fn force_between(
        &self,
        [i, j]: [u32; 2],
        part: u32,
        floating: u32,
        functions: &[(usize, &str)],
    ) -> (u32, Vec<NewStatement>) {
        let id = self.free_id("GFORCE");
        let mut arguments = vec![
            ("I", i.to_string()),
            ("JFLOAT", floating.to_string()),
            ("RM", j.to_string()),
        ];
        for (k, word) in admire_syntax::FORCE_COMPONENTS.into_iter().enumerate() {
            let own = functions.iter().find(|(axis, _)| *axis == k);
            let text = own.map_or("0.0", |(_, function)| function);
            // ADAMS separates the components of a GFORCE by a backslash, the continuation character.
            let end = if k < 5 { "\\" } else { "" };
            arguments.push((word, format!("{text}{end}")));
        }
        let mut marker = statement("MARKER", floating, &[("PART", part.to_string())]);
        marker.arguments.push(("FLOATING".to_string(), None));
        (id, vec![marker, statement("GFORCE", id, &arguments)])
    }

    /// Returns the changes that move a marker of a part to a new, massless part. A bushing with translational stiffnesses `stiffness`
    /// connects the two parts. Its position is `place` in the axes of the old part, and its axes are rotated from the old part's by
    /// `angles`. The bushing's id and the ids of its two markers are returned, too.
    pub(super) fn split(
        &self,
        part: u32,
        marker: u32,
        place: Vec3,
        angles: [f64; 3],
        stiffness: [f64; 3],
    ) -> (u32, [u32; 2], Vec<Change>) {
        let (new, first, bushing) = (
            self.free_id("PART"),
            self.free_id("MARKER"),
            self.free_id("BUSHING"),
        );
        let at = self.model.parts.iter().find(|p| p.header.id == part);
        let pose = at.map_or_else(Pose::identity, |part| part.pose);
        let three = |v: [f64; 3]| format!("{:.12}, {:.12}, {:.12}", v[0], v[1], v[2]);
        let turned = |v: [f64; 3]| three(v);
        let qg: [f64; 3] = pose.p.into();
        let body = statement(
            "PART",
            new,
            &[
                ("QG", three(qg)),
                (
                    "REULER",
                    turned(admire_solver::mechanics::psi_theta_phi(&pose.R)),
                ),
            ],
        );
        let qp: [f64; 3] = place.into();
        let end = |id: u32, part: u32| {
            statement(
                "MARKER",
                id,
                &[
                    ("PART", part.to_string()),
                    ("QP", three(qp)),
                    ("REULER", turned(angles)),
                ],
            )
        };
        let rigid =
            crate::settings::RIGID_STIFFNESS_NMM_PER_RAD * self.newton() * self.millimetre();
        let law = statement(
            "BUSHING",
            bushing,
            &[
                ("I", first.to_string()),
                ("J", (first + 1).to_string()),
                ("C", three([0.0; 3])),
                (
                    "K",
                    format!("{:E}, {:E}, {:E}", stiffness[0], stiffness[1], stiffness[2]),
                ),
                ("CT", three([0.0; 3])),
                ("KT", format!("{rigid:E}, {rigid:E}, {rigid:E}")),
            ],
        );
        let whose = Address::of_argument("MARKER", marker, "PART", None);
        let changes = vec![
            Change::Piece(body, part),
            Change::Add(end(first, new)),
            Change::Add(end(first + 1, part)),
            Change::Add(law),
            Change::Text(whose, new.to_string()),
        ];
        (bushing, [first, first + 1], changes)
    }

    /// Returns all points at which elements and joints of the deck attach to a part.
    pub(super) fn attachments(&self, part: PartIx) -> Vec<Attachment> {
        let owner = |marker: MarkerIx| self.model.markers[marker.0].part;
        self.readings
            .iter()
            .filter(|(kind, id, _)| self.is_of_the_deck(kind, *id))
            .filter_map(|(_, _, readings)| {
                let first = readings.first()?;
                let known = |m: MarkerIx| m.0 < self.model.markers.len();
                if !known(first.i) || !known(first.j) {
                    return None;
                }
                let (marker, side) = if owner(first.i) == part {
                    (first.i, 0)
                } else if owner(first.j) == part {
                    (first.j, 1)
                } else {
                    return None;
                };
                Some(Attachment {
                    marker,
                    force: readings
                        .iter()
                        .map(|r| [r.force, r.force_on_j][side])
                        .collect(),
                })
            })
            .collect()
    }

    /// Returns true for elements of the study's deck, false for elements added by an extension.
    fn is_of_the_deck(&self, kind: &str, id: u32) -> bool {
        self.subject
            .problem
            .dataset
            .statement(kind, Some(id))
            .is_some()
    }
}

/// Creates a statement from its kind, id and arguments.
pub(super) fn statement(kind: &str, id: u32, arguments: &[(&str, String)]) -> NewStatement {
    NewStatement {
        kind: kind.to_string(),
        id: Some(id),
        view_name: None,
        arguments: arguments
            .iter()
            .map(|(word, value)| ((*word).to_string(), Some(value.clone())))
            .collect(),
    }
}
