use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use admire_results::{Catalogue, Entity, StepKind, open_any};
use admire_solver::mechanics::{Pose, Vec3, euler313};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::Span;
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units};

/// Equilibria of one mechanism, from one or several results files.
#[derive(Clone, Debug)]
pub struct Record {
    /// Files, each with its states.
    pub runs: Vec<Run>,
    /// Bodies; the first is ground.
    pub bodies: Vec<Body>,
    /// Joints, motions and forces with six components.
    pub elements: Vec<Element>,
    /// Components of requests, by the name of the request and of the component; one value per state.
    pub requests: BTreeMap<String, BTreeMap<String, Vec<f64>>>,
    /// Floating markers: the points at which vector forces act on their J parts.
    pub floating: Vec<FloatingMarker>,
    /// Units of the results.
    pub units: Units,
    /// Title of the model.
    pub title: String,
    /// True if the results hold the design position.
    pub has_design: bool,
}

/// States from one file.
#[derive(Clone, PartialEq, Debug)]
pub struct Run {
    /// Name of the file, without folder and extension.
    pub name: String,
    /// Indices of its states.
    pub states: Range<usize>,
    /// Time of each state, as in the file.
    pub times: Vec<f64>,
}

/// One part: its frame at design and in every state.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the part without the name of the model.
    pub name: String,
    /// Pose in the design position, or in the first state if the results do not hold the design position.
    pub design: Pose,
    /// Pose in every state.
    pub poses: Vec<Pose>,
}

/// One joint, motion or force: its action on its I part, at the I marker, in ground axes.
#[derive(Clone, Debug)]
pub struct Element {
    /// Name without the name of the model.
    pub name: String,
    /// Type name in results files, for example `Joint`.
    pub ent_type: String,
    /// Id of the statement.
    pub id: i64,
    /// Force in every state.
    pub force: Vec<Vec3>,
    /// Torque about the I marker in every state.
    pub torque: Vec<Vec3>,
    /// Angles AX, AY, AZ of I against J in every state, in radians.
    pub angles: Option<Vec<Vec3>>,
}

/// Floating marker of a vector force.
#[derive(Clone, Debug)]
pub struct FloatingMarker {
    /// Full name: `part.marker`.
    pub name: String,
    /// Place in ground axes in every state.
    pub places: Vec<Vec3>,
}

impl Record {
    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.bodies.first().map_or(0, |ground| ground.poses.len())
    }

    /// Returns the record of only the first `count` files.
    pub(crate) fn first_runs(&self, count: usize) -> Self {
        let runs = self.runs[..count.min(self.runs.len())].to_vec();
        let states = runs.last().map_or(0, |run| run.states.end);
        let mut record = Self {
            runs,
            ..self.clone()
        };
        for body in &mut record.bodies {
            body.poses.truncate(states);
        }
        for element in &mut record.elements {
            element.force.truncate(states);
            element.torque.truncate(states);
            if let Some(angles) = &mut element.angles {
                angles.truncate(states);
            }
        }
        for values in record.requests.values_mut().flat_map(BTreeMap::values_mut) {
            values.truncate(states);
        }
        for marker in &mut record.floating {
            marker.places.truncate(states);
        }
        record
    }

    /// Reads the equilibria of all files. Objects that are missing in a later file are left out and reported.
    ///
    /// If the value has no bodies, the diagnostics contain errors.
    pub fn read(paths: &[&Path]) -> Checked<Self> {
        let mut diagnostics = Vec::new();
        let mut tables = Vec::new();
        for path in paths {
            match Table::read(path, &mut diagnostics) {
                Ok(table) => tables.push(table),
                Err(diagnostic) => diagnostics.push(*diagnostic),
            }
        }
        let record = Self::joined(&tables, &mut diagnostics);
        Checked {
            value: record,
            diagnostics,
        }
    }

    fn joined(tables: &[Table], diagnostics: &mut Vec<Diagnostic>) -> Self {
        let mut record = Self {
            runs: Vec::new(),
            bodies: Vec::new(),
            elements: Vec::new(),
            requests: BTreeMap::new(),
            floating: Vec::new(),
            units: Units::default(),
            title: String::new(),
            has_design: false,
        };
        let Some(first) = tables.first() else {
            return record;
        };
        record.units = first.units();
        record.title.clone_from(&first.title);
        let total: usize = tables.iter().map(|table| table.rows.len()).sum();
        record.bodies.push(Body {
            name: "ground".to_string(),
            design: Pose::identity(),
            poses: vec![Pose::identity(); total],
        });
        for table in tables {
            let begin = record.runs.last().map_or(0, |run| run.states.end);
            record.runs.push(Run {
                name: table.name.clone(),
                states: begin..begin + table.rows.len(),
                times: table.rows.iter().map(|row| row[0]).collect(),
            });
        }
        record.has_design = first.design.is_some();
        for entity in &first.catalogue.entities {
            record.add(entity, tables, diagnostics);
        }
        record
    }

    fn add(&mut self, entity: &Entity, tables: &[Table], diagnostics: &mut Vec<Diagnostic>) {
        let kind = entity.ent_type.as_deref().unwrap_or_default();
        let name = full_name(entity).to_string();
        let wanted: Vec<&str> = match kind {
            "Part" | "Flexible_Body" | "Floating_Marker" => {
                vec!["X", "Y", "Z", "PSI", "THETA", "PHI"]
            }
            "Request" => entity.components.iter().map(|c| c.name.as_str()).collect(),
            _ => vec!["FX", "FY", "FZ", "TX", "TY", "TZ"],
        };
        if wanted.iter().any(|name| entity.component(name).is_none()) {
            return;
        }
        let mut series: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
        for table in tables {
            let found = table.same(entity);
            let ids: Option<Vec<usize>> = found.and_then(|found| {
                let id = |name: &&str| Some(found.component(name)?.id - 1);
                wanted.iter().map(id).collect()
            });
            let Some(ids) = ids else {
                let message = format!("`{name}` is not in this file and is left out");
                let note = Diagnostic::warning(Code::MissingColumn, message);
                diagnostics.push(note.label(&*table.file, Span::at(0), ""));
                return;
            };
            for (values, id) in series.iter_mut().zip(ids) {
                values.extend(table.rows.iter().map(|row| row[id]));
            }
        }
        let vector = |from: usize, state: usize| {
            Vec3::new(
                series[from][state],
                series[from + 1][state],
                series[from + 2][state],
            )
        };
        let states = series.first().map_or(0, Vec::len);
        match kind {
            "Part" | "Flexible_Body" => {
                let angle = tables[0].angle_unit;
                let pose = |x: Vec3, a: Vec3| Pose {
                    p: x,
                    R: euler313(a.x * angle, a.y * angle, a.z * angle),
                };
                let poses: Vec<Pose> = (0..states)
                    .map(|state| pose(vector(0, state), vector(3, state)))
                    .collect();
                let design = tables[0].design.as_ref().map(|row| {
                    let value = |name: &str| row[entity.component(name).map_or(0, |c| c.id - 1)];
                    pose(
                        Vec3::new(value("X"), value("Y"), value("Z")),
                        Vec3::new(value("PSI"), value("THETA"), value("PHI")),
                    )
                });
                let design = design.or_else(|| poses.first().copied());
                self.bodies.push(Body {
                    name,
                    design: design.unwrap_or_else(Pose::identity),
                    poses,
                });
            }
            "Floating_Marker" => self.floating.push(FloatingMarker {
                name,
                places: (0..states).map(|state| vector(0, state)).collect(),
            }),
            "Request" => {
                let columns = wanted.iter().map(|column| column.to_ascii_lowercase());
                let components = columns.zip(series).collect();
                self.requests.insert(entity.name.clone(), components);
            }
            _ => {
                let force = (0..states).map(|state| vector(0, state)).collect();
                let torque = (0..states).map(|state| vector(3, state)).collect();
                let angles = self.angles_of(entity, tables);
                self.elements.push(Element {
                    name,
                    ent_type: kind.to_string(),
                    id: entity.object_id.unwrap_or(0),
                    force,
                    torque,
                    angles,
                });
            }
        }
    }

    fn angles_of(&self, entity: &Entity, tables: &[Table]) -> Option<Vec<Vec3>> {
        let mut angles = Vec::new();
        for table in tables {
            let found = table.same(entity)?;
            let id = |name: &str| Some(found.component(name)?.id - 1);
            let ids = [id("ANGX")?, id("ANGY")?, id("ANGZ")?];
            let unit = table.angle_unit;
            angles.extend(
                table
                    .rows
                    .iter()
                    .map(|row| Vec3::from(ids.map(|k| row[k] * unit))),
            );
        }
        Some(angles)
    }
}

/// Returns the name of an object without the name of the model.
fn full_name(entity: &Entity) -> &str {
    entity.entity.as_deref().unwrap_or(&entity.name)
}

/// Equilibria of one file.
struct Table {
    file: String,
    name: String,
    title: String,
    catalogue: Catalogue,
    angle_unit: f64,
    words: [String; 3],
    design: Option<Vec<f64>>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(path: &Path, diagnostics: &mut Vec<Diagnostic>) -> Result<Self, Box<Diagnostic>> {
        let file = path.display().to_string();
        let located = |diagnostic: Diagnostic| {
            if diagnostic.labels.is_empty() {
                return Box::new(diagnostic.label(&*file, Span::at(0), ""));
            }
            Box::new(diagnostic)
        };
        let opened = open_any(path).map_err(|error| located(error.into_diagnostic()))?;
        diagnostics.extend(opened.diagnostics);
        let mut reader = opened.value;
        let header = reader.header().clone();
        let mut table = Self {
            name: path
                .file_stem()
                .map_or_else(|| file.clone(), |stem| stem.to_string_lossy().into_owned()),
            file: file.clone(),
            title: header.title.clone(),
            catalogue: reader.catalogue().clone(),
            angle_unit: if header.units.angle.starts_with("deg") {
                std::f64::consts::PI / 180.0
            } else {
                1.0
            },
            words: [header.units.length, header.units.mass, header.units.time],
            design: None,
            rows: Vec::new(),
        };
        let mut other = 0;
        loop {
            let step = reader
                .next_step()
                .map_err(|error| located(error.into_diagnostic()))?;
            let Some(step) = step else { break };
            let mut values = Vec::new();
            step.values(&mut values)
                .map_err(|error| located(error.into_diagnostic()))?;
            match step.kind {
                StepKind::Input => table.design = Some(values),
                StepKind::Static | StepKind::QuasiStatic | StepKind::Equilibrium => {
                    table.rows.push(values);
                }
                _ => other += 1,
            }
        }
        diagnostics.extend(reader.diagnostics().iter().cloned());
        if other > 0 {
            let message = match other {
                1 => "one step that is not an equilibrium is left out".to_string(),
                _ => format!("{other} steps that are not equilibria are left out"),
            };
            diagnostics.push(*located(Diagnostic::note(Code::MissingColumn, message)));
        }
        table.complete().map_err(located)?;
        Ok(table)
    }

    /// Checks that the file contains everything that a rebuild requires.
    fn complete(&self) -> Result<(), Diagnostic> {
        let kinds = |wanted: &str| {
            let mut entities = self.catalogue.entities.iter();
            entities.any(|e| e.ent_type.as_deref() == Some(wanted) && e.component("PSI").is_some())
        };
        let forces = self
            .catalogue
            .entities
            .iter()
            .any(|e| e.component("FX").is_some());
        let error = |message: &str, help: &str| {
            Err(Diagnostic::error(Code::MissingColumn, message).help(help))
        };
        if self.rows.len() < 2 {
            return error(
                "the file holds fewer than two static equilibria",
                "a rebuild compares equilibria under different loads: simulate quasi-static states",
            );
        }
        if !kinds("Part") {
            return error(
                "the file holds no positions of parts",
                "write results in the XRF form, without NODISPLACEMENTS in RESULTS",
            );
        }
        if !forces {
            return error(
                "the file holds no forces of joints, bushings or springs",
                "write results without NOREACTIONFORCES and NOAPPLIEDFORCES in RESULTS",
            );
        }
        Ok(())
    }

    /// Returns the entity of this file that corresponds to an entity of another file.
    fn same(&self, entity: &Entity) -> Option<&Entity> {
        let mut entities = self.catalogue.entities.iter();
        entities.find(|other| {
            other.ent_type == entity.ent_type
                && full_name(other) == full_name(entity)
                && other.name == entity.name
        })
    }

    /// Returns the units of the file. The force unit is the unit of its force columns.
    fn units(&self) -> Units {
        let find = |units: &[Unit], word: &str| {
            let mut all = units.iter();
            let found = all.find(|u| u.word == word || u.keyword.eq_ignore_ascii_case(word));
            found.copied().unwrap_or(units[0])
        };
        let mut columns = self.catalogue.columns();
        let force = columns.find(|column| column.component.name == "FX");
        let force = force.and_then(|column| column.component.units.as_deref());
        let [length, mass, time] = &self.words;
        let length = match length.as_str() {
            "m" => "meter",
            other => other,
        };
        Units::new(
            find(FORCE_UNITS, force.unwrap_or("newton")),
            find(MASS_UNITS, mass),
            find(LENGTH_UNITS, length),
            find(TIME_UNITS, time),
        )
    }
}
