//! Matching objects of a deck and of a subsystem of Adams/Car.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use admire_car::{BushingName, HARDPOINT_MATCH_MM, Side, bushing_name};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{ElasticPair, Header, Model};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::car::CarSettings;
use super::section::SpannedText;
use super::study::Study;

/// Maximum number of hardpoints that are kept for one marker. Hardpoints may coincide; a malicious file may have thousands at one place.
const MOST_AT_ONE_PLACE: usize = 8;

/// Matching objects of a deck and of a subsystem of Adams/Car.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CarLink {
    /// Hardpoints at each marker, by the id of the marker: index among the hardpoints of the subsystem, and side.
    pub hardpoints: BTreeMap<u32, Vec<(usize, Side)>>,
    /// Bushings of the subsystem by the statement of the deck: `BUSHING/3` or `FIELD/9`.
    pub bushings: BTreeMap<String, BushingName>,
}

impl CarLink {
    /// Compares the subsystem of a study with the model of its deck. Hardpoints are matched by position and bushings by name, unless `study.toml`
    /// states the matches. Returns `None` without a section `[car]`.
    ///
    /// A note states how many objects were matched; it is a warning if no hardpoint was matched. Names in `study.toml` that do not exist are errors.
    pub fn new(study: &Study, model: &Model, out: &mut Vec<Diagnostic>) -> Option<Self> {
        let car = study.car.as_ref()?;
        let mut link = Self::default();
        link.by_place(car, model);
        link.by_name(car, model);
        link.as_stated(study, car, model, out);
        let points: BTreeSet<usize> = link.found().map(|(at, _)| at).collect();
        let [named, counted] = [
            link.bushings.values().collect::<BTreeSet<_>>().len(),
            car.subsystem
                .bushings
                .iter()
                .map(|one| one.symmetry.sides().len())
                .sum(),
        ];
        let all = car.subsystem.hardpoints.len();
        let message = format!(
            "{} of {all} hardpoints and {named} of {counted} bushings of the subsystem are in the deck",
            points.len()
        );
        let found = if points.is_empty() && all > 0 {
            Diagnostic::warning(Code::CarSubsystem, message).help(
                "the positions of hardpoints are compared with those of markers: check the units of the subsystem, and whether it belongs to the deck",
            )
        } else {
            Diagnostic::note(Code::CarSubsystem, message)
        };
        out.push(found.label(study.source.name(), car.section.span, ""));
        Some(link)
    }

    /// Iterates over the hardpoints that are in the deck, each with its side. A hardpoint with several markers is returned several times.
    pub fn found(&self) -> impl Iterator<Item = (usize, Side)> + '_ {
        self.hardpoints.values().flatten().copied()
    }

    fn by_place(&mut self, car: &CarSettings, model: &Model) {
        let near = HARDPOINT_MATCH_MM * 1e-3 / model.units.length.si;
        let cell =
            |place: &Vec3| -> [i64; 3] { [0, 1, 2].map(|k| (place[k] / near).floor() as i64) };
        let mut grid: HashMap<[i64; 3], Vec<(Vec3, usize, Side)>> = HashMap::new();
        for (at, point) in car.subsystem.hardpoints.iter().enumerate() {
            for side in point.symmetry.sides() {
                let place = point.place_in(&car.subsystem.file, *side, &model.units);
                let place = Vec3::from(place.unwrap_or_default());
                let there = grid.entry(cell(&place)).or_default();
                if there.len() < MOST_AT_ONE_PLACE {
                    there.push((place, at, *side));
                }
            }
        }
        for marker in model.markers.iter().filter(|marker| !marker.floating) {
            let place = model.parts[marker.part.0].pose.point(&marker.qp);
            let [x, y, z] = cell(&place);
            let mut found: Vec<(usize, Side)> = Vec::new();
            for k in 0..27_i64 {
                let key = [
                    x.saturating_add(k % 3 - 1),
                    y.saturating_add(k / 3 % 3 - 1),
                    z.saturating_add(k / 9 - 1),
                ];
                let there = grid.get(&key).into_iter().flatten();
                let close = there.filter(|(other, ..)| (other - place).norm() <= near);
                found.extend(close.map(|(_, at, side)| (*at, *side)));
            }
            found.sort_unstable();
            found.dedup();
            if !found.is_empty() {
                self.hardpoints.insert(marker.header.id, found);
            }
        }
    }

    fn by_name(&mut self, car: &CarSettings, model: &Model) {
        let known: BTreeSet<(String, Side)> = car
            .subsystem
            .bushings
            .iter()
            .flat_map(|one| {
                let usage = one.usage.to_ascii_lowercase();
                let sides = one.symmetry.sides().iter();
                sides.map(move |side| (usage.clone(), *side))
            })
            .collect();
        for bushing in model.elastic_pairs() {
            let named = bushing_name(&bushing.header.name);
            let named = named.filter(|name| known.contains(&(name.usage.clone(), name.side)));
            if let Some(name) = named {
                self.bushings.insert(statement(&bushing), name);
            }
        }
    }

    /// Applies the tables `hardpoints` and `bushings` of the section.
    fn as_stated(
        &mut self,
        study: &Study,
        car: &CarSettings,
        model: &Model,
        out: &mut Vec<Diagnostic>,
    ) {
        let mut wrong = |place: &SpannedText, message: String| {
            out.push(Diagnostic::error(Code::UnknownTarget, message).label(
                study.source.name(),
                place.span,
                "",
            ));
        };
        for (marker, name) in &car.hardpoints {
            let header = object(
                model.markers.iter().map(|m| &m.header),
                "MARKER",
                &marker.text,
            );
            let points = car.subsystem.hardpoints.iter().enumerate();
            let point = points
                .flat_map(|(at, point)| point.symmetry.sides().iter().map(move |s| (at, point, *s)))
                .find(|(_, point, side)| {
                    point
                        .full_name(*side)
                        .eq_ignore_ascii_case(name.text.trim())
                });
            match (header, point) {
                (Some(header), Some((at, _, side))) => {
                    self.hardpoints.insert(header.id, vec![(at, side)]);
                }
                (None, _) => wrong(marker, format!("the deck has no marker `{}`", marker.text)),
                (_, None) => wrong(
                    name,
                    format!(
                        "the subsystem has no hardpoint `{}`; names of hardpoints begin with hpl_, hpr_ or hps_",
                        name.text
                    ),
                ),
            }
        }
        for (bushing, name) in &car.bushings {
            let found = ["BUSHING", "FIELD"].into_iter().find_map(|kind| {
                let own = || model.elastic_pairs().filter(move |pair| pair.kind == kind);
                let header = object(own().map(|pair| pair.header), kind, &bushing.text)?;
                own().find(|pair| pair.header.id == header.id)
            });
            let named = bushing_name(&name.text).filter(|named| {
                car.subsystem.bushings.iter().any(|one| {
                    one.usage.eq_ignore_ascii_case(&named.usage)
                        && one.symmetry.sides().contains(&named.side)
                })
            });
            match (found, named) {
                (Some(found), Some(named)) => {
                    self.bushings.insert(statement(&found), named);
                }
                (None, _) => wrong(
                    bushing,
                    format!("the deck has no bushing `{}`", bushing.text),
                ),
                (_, None) => wrong(
                    name,
                    format!(
                        "the subsystem has no bushing `{}`; names of bushings begin with bkl_, bkr_ or bks_",
                        name.text
                    ),
                ),
            }
        }
    }
}

/// Returns the address of a bushing or FIELD.
fn statement(pair: &ElasticPair<'_>) -> String {
    format!("{}/{}", pair.kind, pair.header.id)
}

/// Returns the object with an address such as `MARKER/7`, or with a view name.
fn object<'m>(
    mut headers: impl Iterator<Item = &'m Header>,
    kind: &str,
    text: &str,
) -> Option<&'m Header> {
    let id = text.split_once('/').and_then(|(word, id)| {
        let is_kind = word.trim().eq_ignore_ascii_case(kind);
        id.trim().parse::<u32>().ok().filter(|_| is_kind)
    });
    headers.find(|header| match id {
        Some(id) => header.id == id,
        None => header.name.eq_ignore_ascii_case(text.trim()),
    })
}
