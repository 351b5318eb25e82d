//! Measurements that the laboratory of a study can add: key `available` of section `[plan]`.

use std::collections::BTreeMap;

use admire_solver::model::{Header, Model, PartIx};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::part_name::part;
use super::section::did_you_mean;
use super::study::Study;

/// Measurements that a laboratory can add to a study.
#[derive(Clone, PartialEq, Debug)]
pub struct Available {
    /// Loads whose range is stated, by the names of their columns.
    pub loads: BTreeMap<String, LoadRange>,
    /// Range of all other loads.
    pub other_loads: LoadRange,
    /// True if load cases can be repeated and loads can be driven in loops.
    pub repeats: bool,
    /// Parts that can carry new marks.
    pub marks: Places<PartIx>,
    /// True if toe, camber and centre of the wheel can be read.
    pub wheel: bool,
    /// Bushings and joints that can carry a load cell, by their addresses: `BUSHING/2`.
    pub load_cells: Places<String>,
}

/// Values that a load can take in a new load case.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum LoadRange {
    /// Only its usual value.
    Fixed,
    /// Values within the range of the study.
    Applied,
    /// Values up to the largest deviation from the usual value in the study, to both sides of the usual value, and values somewhat beyond.
    Beyond,
    /// Values between two limits, in the unit of the study's file.
    Between([f64; 2]),
}

/// Places where an instrument can be mounted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Places<T> {
    /// No place.
    Nowhere,
    /// Every place.
    Everywhere,
    /// These places.
    At(Vec<T>),
}

impl Default for Available {
    /// Returns the default of the key: every measurement except load cells, because a bushing or joint has no room for a load cell.
    fn default() -> Self {
        Self {
            loads: BTreeMap::new(),
            other_loads: LoadRange::Beyond,
            repeats: true,
            marks: Places::Everywhere,
            wheel: true,
            load_cells: Places::Nowhere,
        }
    }
}

impl<T: PartialEq> Places<T> {
    /// Returns true if the instrument can be mounted at a place.
    pub fn holds(&self, place: &T) -> bool {
        match self {
            Self::Nowhere => false,
            Self::Everywhere => true,
            Self::At(places) => places.contains(place),
        }
    }

    fn add(&mut self, place: T) {
        match self {
            Self::Everywhere => {}
            Self::At(places) => places.push(place),
            Self::Nowhere => *self = Self::At(vec![place]),
        }
    }
}

impl Available {
    /// Returns the range of a load, named by its column.
    pub fn load(&self, column: &str) -> LoadRange {
        self.loads.get(column).copied().unwrap_or(self.other_loads)
    }

    /// Reads the key of a study. Entries that match nothing in the deck are reported and left out.
    pub(super) fn of(study: &Study, model: &Model, out: &mut Vec<Diagnostic>) -> Self {
        let Some(entries) = &study.available else {
            return Self::default();
        };
        let mut new = Self {
            loads: BTreeMap::new(),
            other_loads: LoadRange::Fixed,
            repeats: false,
            marks: Places::Nowhere,
            wheel: false,
            load_cells: Places::Nowhere,
        };
        for entry in entries {
            if let Err(wrong) = new.add(entry.text.trim(), study, model) {
                out.push(wrong.label(study.source.name(), entry.span, ""));
            }
        }
        new
    }

    fn add(&mut self, text: &str, study: &Study, model: &Model) -> Result<(), Diagnostic> {
        match text {
            "loads" => self.other_loads = LoadRange::Applied,
            "repeats" => self.repeats = true,
            "marks" => self.marks = Places::Everywhere,
            "wheel" => self.wheel = true,
            "load cells" => self.load_cells = Places::Everywhere,
            _ => {
                if let Some(name) = text.strip_prefix("marks on ") {
                    let found = part(name, model).ok_or_else(|| unknown("part", name, &[]))?;
                    self.marks.add(found);
                } else if let Some(address) = text.strip_prefix("load cell in ") {
                    let all = elements(model);
                    let found = all.iter().find(|known| known.eq_ignore_ascii_case(address));
                    let found = found.ok_or_else(|| unknown("bushing or joint", address, &all))?;
                    self.load_cells.add(found.clone());
                } else if let Some(load) = text.strip_prefix("load ") {
                    let (column, range) = load_range(load, text)?;
                    let all: Vec<String> = study
                        .columns
                        .iter()
                        .map(|(name, _)| name.text.clone())
                        .collect();
                    if !all.iter().any(|name| name == column) {
                        return Err(unknown("load column", column, &all));
                    }
                    self.loads.insert(column.to_string(), range);
                } else {
                    return Err(no_entry(text));
                }
            }
        }
        Ok(())
    }
}

/// Parses `COLUMN` or `COLUMN from LOW to HIGH`. `entry` is the whole entry, for the diagnostic.
fn load_range<'a>(text: &'a str, entry: &str) -> Result<(&'a str, LoadRange), Diagnostic> {
    let Some((column, range)) = text.rsplit_once(" from ") else {
        return Ok((text, LoadRange::Applied));
    };
    let ends = range.split_once(" to ");
    let number = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    };
    let ends = ends.and_then(|(low, high)| Some([number(low)?, number(high)?]));
    match ends.filter(|[low, high]| low < high) {
        Some(ends) => Ok((column.trim(), LoadRange::Between(ends))),
        None => Err(no_entry(entry)),
    }
}

/// Returns the addresses of all bushings, FIELDs and joints.
fn elements(model: &Model) -> Vec<String> {
    let named = |kind: &'static str| move |header: &Header| format!("{kind}/{}", header.id);
    let elastic = model.elastic_pairs();
    let elastic = elastic.map(|pair| format!("{}/{}", pair.kind, pair.header.id));
    let joints = model.joints.iter().map(|joint| &joint.header);
    elastic.chain(joints.map(named("JOINT"))).collect()
}

fn unknown(what: &str, name: &str, known: &[String]) -> Diagnostic {
    let message = format!("`plan.available` names the unknown {what} `{name}`");
    let wrong = Diagnostic::error(Code::UnknownTarget, message);
    if known.is_empty() {
        wrong
    } else {
        wrong.help(did_you_mean(name, "the study", known))
    }
}

fn no_entry(text: &str) -> Diagnostic {
    let message = format!("`{text}` is not an entry of `plan.available`");
    Diagnostic::error(Code::BadSetting, message).help(
        "the possible entries are `loads`, `load COLUMN from LOW to HIGH`, `repeats`, `marks`, `marks on PART`, `wheel`, `load cells`, `load cell in BUSHING/1`",
    )
}
