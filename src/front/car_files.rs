//! Results of a study in the terms of Adams/Car: a new subsystem file, property files with learned curves, and a list of all changes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::json;

use admire_car::{BushingChange, HardpointMove, NotWritten, OddTerm, Side, Subsystem, WriteBack};
use admire_diagnosis::{
    Cause, Finding, LARGEST_DEFLECTION, LARGEST_RADIAL_DEFLECTION, Outcome, STIFFNESS_RISES,
    spline_terms,
};
use admire_identify::{Fit, LoadedStudy};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{MarkerIx, Model, lower};
use admire_study::CarLink;
use admire_study::deflection::{DeflectionForm, deflection};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use super::car_elements::{CarElement, LearnedTerm};

/// Folder of the files below the output folder.
pub(crate) const FOLDER: &str = "adams_car";

/// List of the changes, inside the folder.
const LIST: &str = "changes.json";

/// Files in the terms of Adams/Car.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct CarFiles {
    /// Paths relative to the output folder, with the bytes of each file.
    pub(crate) files: Vec<(PathBuf, Vec<u8>)>,
    /// Changes as sentences.
    pub(crate) sentences: Vec<String>,
}

/// Returns the names of all files that may be written for a study, relative to the output folder.
pub(crate) fn possible_names(loaded: &LoadedStudy) -> Vec<String> {
    let Some(car) = &loaded.study.car else {
        return Vec::new();
    };
    let name = subsystem_name(&car.subsystem);
    [name, LIST.to_string()]
        .into_iter()
        .chain(WriteBack::file_names(&car.subsystem))
        .map(|name| format!("{FOLDER}/{name}"))
        .collect()
}

/// Returns the results of an identification in the terms of Adams/Car; `None` if the study names no subsystem. `deck` is the text of the deck with
/// the identified numbers.
pub(crate) fn identified(loaded: &LoadedStudy, fit: &Fit, deck: &[u8]) -> Option<CarFiles> {
    let subject = Subject::new(loaded, deck)?;
    let errors = fit
        .parameters
        .iter()
        .flat_map(|parameter| {
            let addresses = std::iter::once(&parameter.address).chain(&parameter.tied);
            addresses.filter_map(move |address| Some((address.as_str(), parameter.std_error?)))
        })
        .collect();
    let mut not_written = Vec::new();
    for parameter in &fit.parameters {
        if !subject.is_of_bushing(&parameter.address) {
            not_written.push(NotWritten {
                what: format!("identified {}", parameter.address),
                why: "it is not a parameter of a bushing".to_string(),
            });
        }
    }
    let bushings = subject.bushings(&errors, &BTreeMap::new(), "identified", &mut not_written);
    Some(subject.files(&[], &bushings, not_written))
}

/// Returns the findings and fitted numbers of a diagnosis in the terms of Adams/Car; `None` if the study names no subsystem. `deck` is the text of
/// the extended deck.
pub(crate) fn diagnosed(
    loaded: &LoadedStudy,
    outcome: &Outcome<'_>,
    deck: &[u8],
) -> Option<CarFiles> {
    let subject = Subject::new(loaded, deck)?;
    let parameters = outcome.diagnosis.parameters.iter();
    let errors = parameters
        .map(|parameter| (parameter.address.as_str(), parameter.std_error))
        .collect();
    let (mut moves, mut not_written) = (Vec::new(), Vec::new());
    let mut laws: BTreeMap<String, Vec<LearnedTerm>> = BTreeMap::new();
    for finding in &outcome.diagnosis.findings {
        let what = format!("{} {}", finding.cause, finding.address);
        let refused = |why: String| NotWritten {
            what: what.clone(),
            why,
        };
        match finding.cause {
            Cause::HardpointError => match subject.moved(finding) {
                Ok(found) => moves.push(found),
                Err(why) => not_written.push(refused(why)),
            },
            Cause::ProgressiveStiffness => match subject.learned(finding, outcome) {
                Some((statement, term)) => laws.entry(statement).or_default().push(term),
                None => {
                    not_written.push(refused("its bushing is not in the subsystem".to_string()));
                }
            },
            // In the extended deck, the offset of a BUSHING is a preload and that of a FIELD an offset. A wrong stiffness is a changed stiffness
            // or scale.
            Cause::AssemblyOffset => {}
            Cause::ElementParameter if subject.is_of_bushing(&finding.address) => {}
            cause if cause.is_reading_fault() => {}
            _ => not_written.push(refused(
                "a subsystem file has no parameter for this cause".to_string(),
            )),
        }
    }
    let bushings = subject.bushings(&errors, &laws, "fitted", &mut not_written);
    Some(subject.files(&moves, &bushings, not_written))
}

/// Study with a subsystem, and its deck after the fit.
struct Subject<'a> {
    loaded: &'a LoadedStudy,
    subsystem: &'a Subsystem,
    link: &'a CarLink,
    /// Model of the deck after the fit.
    after: Model,
}

impl<'a> Subject<'a> {
    fn new(loaded: &'a LoadedStudy, deck: &[u8]) -> Option<Self> {
        let source = Source::new(loaded.study.deck.name(), deck);
        Some(Self {
            loaded,
            subsystem: &loaded.study.car.as_ref()?.subsystem,
            link: loaded.car.as_ref()?,
            after: lower(&Dataset::parse(source).value).value,
        })
    }

    /// Returns the displacement of the hardpoint that a finding names, or the reason why the finding is not a displacement of one hardpoint.
    fn moved(&self, finding: &Finding) -> Result<HardpointMove, String> {
        if finding.form.as_deref() != Some("point") {
            return Err(
                "only one part differs, but a hardpoint of Adams/Car moves all parts that meet there".to_string(),
            );
        }
        let names = std::iter::once(&finding.address).chain(&finding.members);
        let markers: Vec<u32> = names
            .filter_map(|name| name.strip_prefix("MARKER/")?.parse().ok())
            .collect();
        let found: BTreeSet<(usize, Side)> = markers
            .iter()
            .filter_map(|id| self.link.hardpoints.get(id))
            .flatten()
            .copied()
            .collect();
        let (hardpoint, side) = self.only(&found, &markers)?;
        let place = |model: &Model, id: u32| -> Option<Vec3> {
            let marker = model.markers.iter().find(|m| m.header.id == id)?;
            Some(model.parts[marker.part.0].pose.point(&marker.qp))
        };
        let shift = markers
            .first()
            .and_then(|id| Some(place(&self.after, *id)? - place(&self.loaded.model, *id)?));
        let by = shift.ok_or("its marker is not in the deck")?;
        let error = |name: &str| finding.std_error.get(name).copied();
        Ok(HardpointMove {
            hardpoint,
            side,
            by: [by.x, by.y, by.z],
            std_error: ["x", "y", "z"].map(error),
            because: format!("{} {}", finding.cause, finding.address),
        })
    }

    /// Returns the only hardpoint at a place. If several hardpoints coincide, the names of the markers decide.
    fn only(
        &self,
        found: &BTreeSet<(usize, Side)>,
        markers: &[u32],
    ) -> Result<(usize, Side), String> {
        let point = |at: usize| &self.subsystem.hardpoints[at];
        let named: Vec<(usize, Side)> = if found.len() > 1 {
            let names: Vec<String> = self
                .loaded
                .model
                .markers
                .iter()
                .filter(|marker| markers.contains(&marker.header.id))
                .map(|marker| marker.header.name.to_ascii_lowercase())
                .collect();
            let is_named = |at: usize| {
                let own = point(at).name.to_ascii_lowercase();
                names.iter().any(|name| name.contains(&own))
            };
            found
                .iter()
                .copied()
                .filter(|(at, _)| is_named(*at))
                .collect()
        } else {
            found.iter().copied().collect()
        };
        match (named.as_slice(), found.len()) {
            ([one], _) => Ok(*one),
            (_, 0) => Err("the subsystem has no hardpoint at this place".to_string()),
            _ => {
                let names: Vec<String> = found
                    .iter()
                    .map(|(at, side)| point(*at).full_name(*side))
                    .collect();
                Err(format!(
                    "several hardpoints are at this place ({}); name one of them in the table `car.hardpoints` of study.toml",
                    names.join(", ")
                ))
            }
        }
    }

    /// Returns true if a number of the deck belongs to a bushing.
    fn is_of_bushing(&self, address: &str) -> bool {
        let elements = CarElement::all(&self.after);
        elements.iter().any(|element| element.owns(address))
    }

    /// Returns the statement of the bushing that a finding names, and the terms of its law.
    fn learned(&self, finding: &Finding, outcome: &Outcome<'_>) -> Option<(String, LearnedTerm)> {
        let deck = &outcome.extended.deck.model;
        let elements = CarElement::all(deck);
        let element = elements.iter().find(|one| one.owns(&finding.address))?;
        let axis = element.component(&finding.address)?;
        self.link.bushings.get(&element.statement)?;
        let terms = learned_terms(&finding.parameters);
        let states = outcome.extended.states.iter();
        let range = states
            .map(|state| deflected(deck, element.pair, &state.poses)[axis].abs())
            .fold(0.0, f64::max);
        let term = LearnedTerm { axis, terms, range };
        (range > 0.0).then(|| (element.statement.clone(), term))
    }

    /// Returns the changes of all bushings of the subsystem. `errors` holds standard errors by address.
    fn bushings(
        &self,
        errors: &BTreeMap<&str, f64>,
        laws: &BTreeMap<String, Vec<LearnedTerm>>,
        how: &str,
        not_written: &mut Vec<NotWritten>,
    ) -> Vec<BushingChange> {
        let mut out = Vec::new();
        let before = CarElement::all(&self.loaded.model);
        for new in CarElement::all(&self.after) {
            let mut olds = before.iter();
            let Some(old) = olds.find(|old| old.statement == new.statement) else {
                continue;
            };
            let because = format!("{how} {}", new.statement);
            let terms = laws.get(&new.statement);
            let other_curves = new.has_other_curves(old);
            let same = new.stiffness == old.stiffness
                && new.preload == old.preload
                && new.offset == old.offset
                && !other_curves;
            if same && terms.is_none() {
                continue;
            }
            let Some(name) = self.link.bushings.get(&new.statement) else {
                not_written.push(NotWritten {
                    what: because,
                    why: format!(
                        "the subsystem has no bushing of its name `{}`; name the bushing in the table `car.bushings` of study.toml",
                        old.name
                    ),
                });
                continue;
            };
            let mut scale = [None; 6];
            for axis in 0..6 {
                let (k, k_old) = (new.stiffness[axis], old.stiffness[axis]);
                if k == k_old {
                    continue;
                }
                let address = new.addresses[axis].as_str();
                if k_old > 0.0 {
                    let error = errors.get(address).map(|error| error / k_old);
                    scale[axis] = Some((k / k_old, error));
                } else if terms.is_none() {
                    not_written.push(NotWritten {
                        what: format!("{how} {address}"),
                        why:
                            "the stiffness in the deck is zero, so no scale factor expresses the change"
                                .to_string(),
                    });
                }
            }
            let is_learned = terms.is_some() || other_curves;
            let terms = terms.map_or(&[][..], Vec::as_slice);
            out.push(BushingChange {
                name: name.clone(),
                scale,
                preload: changed(new.preload, old.preload),
                offset: changed(new.offset, old.offset),
                learned: is_learned.then(|| new.property(terms)),
                because: if terms.is_empty() {
                    because
                } else {
                    format!("progressive-stiffness {}", new.statement)
                },
            });
        }
        out
    }

    /// Writes the results into the subsystem, and lists the changes.
    fn files(
        &self,
        moves: &[HardpointMove],
        bushings: &[BushingChange],
        mut not_written: Vec<NotWritten>,
    ) -> CarFiles {
        let in_deck = self.link.found().collect();
        let named = self.link.bushings.values();
        let sides = named.map(|name| (name.usage.clone(), name.side)).collect();
        let units = &self.loaded.model.units;
        let written = WriteBack::new(self.subsystem, units, &in_deck, moves, &sides, bushings);
        not_written.extend(written.not_written);
        let name = subsystem_name(self.subsystem);
        let list = json!({
            "subsystem": name,
            "changes": written.changes,
            "property_files": written.files.iter().map(|file| &file.name).collect::<Vec<_>>(),
            "not_written": not_written,
        });
        let list = serde_json::to_string_pretty(&list).expect("names and numbers print") + "\n";
        let path = |name: &str| Path::new(FOLDER).join(name);
        let mut sentences: Vec<String> = written
            .changes
            .iter()
            .map(|word| {
                let unit = if word.unit.is_empty() {
                    String::new()
                } else {
                    format!(" {}", word.unit)
                };
                format!(
                    "{name}: {}.{} ({}) from {} to {}{unit}: {}",
                    word.element, word.factor, word.symmetry, word.before, word.after, word.because
                )
            })
            .collect();
        sentences.extend(
            not_written
                .iter()
                .map(|one| format!("not written to {name}: {} ({})", one.what, one.why)),
        );
        let mut files = vec![
            (path(&name), written.bytes),
            (path(LIST), list.into_bytes()),
        ];
        let learned = written.files.into_iter();
        files.extend(learned.map(|file| (path(&file.name), file.text.into_bytes())));
        CarFiles { files, sentences }
    }
}

/// Returns the file name of a subsystem without its path.
fn subsystem_name(subsystem: &Subsystem) -> String {
    let path = Path::new(subsystem.file.source().name());
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Returns the values that differ from the old ones.
fn changed(new: [f64; 6], old: [f64; 6]) -> [Option<f64>; 6] {
    std::array::from_fn(|axis| (new[axis] != old[axis]).then_some(new[axis]))
}

/// Returns the terms of a progressive law from the parameters of its finding.
fn learned_terms(parameters: &BTreeMap<String, f64>) -> Vec<OddTerm> {
    let of = |name: &str| parameters.get(name).copied();
    let largest = of(LARGEST_DEFLECTION).or(of(LARGEST_RADIAL_DEFLECTION));
    if let Some(largest) = largest {
        let rises = STIFFNESS_RISES.map(|name| of(name).unwrap_or(0.0));
        return spline_terms(largest, rises)
            .map(|[from, coefficient]| OddTerm {
                from,
                power: 2,
                coefficient,
            })
            .to_vec();
    }
    let powers = [("quadratic", 2), ("cubic", 3)].into_iter();
    powers
        .filter_map(|(name, power)| Some(OddTerm::power(power, of(name)?)))
        .collect()
}

/// Returns the deflection of a bushing at these poses of the parts.
fn deflected(model: &Model, (i, j): (MarkerIx, MarkerIx), poses: &[Pose]) -> [f64; 6] {
    let frame = |marker: MarkerIx| {
        let marker = &model.markers[marker.0];
        let part = poses
            .get(marker.part.0)
            .copied()
            .unwrap_or(model.parts[marker.part.0].pose);
        (
            part,
            Pose {
                p: marker.qp,
                R: marker.R,
            },
        )
    };
    let ((part_i, i), (part_j, j)) = (frame(i), frame(j));
    deflection(&part_i, &i, &part_j, &j, DeflectionForm::Corrected).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::Address;

    /// Reads the shipped study with the shipped subsystem.
    fn study(added: &str) -> (tempfile::TempDir, LoadedStudy) {
        let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
        let folder = tempfile::tempdir().unwrap();
        for entry in std::fs::read_dir(corpus.join("pseudo-mcpherson")).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
        let sub = std::fs::read_to_string(corpus.join("adams-car/front.sub")).unwrap();
        // A second hardpoint at the inner end of the tie rod.
        let row =
            " 'tierod_inner                '  'left/right'      130.0      -345.0       232.0\n";
        let twice = format!("{row}{}", row.replace("tierod_inner", "rack_end    "));
        std::fs::write(folder.path().join("front.sub"), sub.replace(row, &twice)).unwrap();
        let toml = folder.path().join("study.toml");
        let text = std::fs::read_to_string(&toml).unwrap();
        let car = format!("{text}\n[car]\nsubsystem = \"front.sub\"\n{added}");
        std::fs::write(&toml, car).unwrap();
        let read = LoadedStudy::read(folder.path());
        (folder, read.value.expect("a study"))
    }

    fn finding(form: &str, markers: &[u32]) -> Finding {
        let names: Vec<String> = markers.iter().map(|id| format!("MARKER/{id}")).collect();
        Finding {
            cause: Cause::HardpointError,
            address: names[0].clone(),
            form: Some(form.to_string()),
            members: names,
            probability: 0.9,
            group_probability: 0.9,
            parameters: BTreeMap::from([("y".to_string(), -2.5)]),
            std_error: BTreeMap::from([("y".to_string(), 0.2)]),
            minor: false,
            evidence: admire_diagnosis::Evidence {
                statistic: "evidence",
                value: 10.0,
                p_value: 0.0,
                bic_gain: 10.0,
            },
            indistinguishable_from: Vec::new(),
            gain: admire_diagnosis::Gain::default(),
        }
    }

    /// Returns the text of the deck with moved markers. Each entry of `markers` holds the id of a marker, a component of QP (from 1), and its
    /// change.
    fn with_moved(loaded: &LoadedStudy, markers: &[(u32, usize, f64)]) -> Vec<u8> {
        let mut deck = loaded.dataset.clone();
        for (id, axis, by) in markers {
            let address = Address::parse(&format!("MARKER/{id}.QP.{axis}"), &deck).expect("QP");
            let value = deck.value_at(&address).expect("a number");
            let edits = deck.set(&address, value + by).expect("a number");
            deck = deck.edited(&edits).expect("one place").value;
        }
        deck.bytes().to_vec()
    }

    #[test]
    fn a_displaced_hardpoint_is_one_changed_line() {
        let (folder, loaded) = study("");
        // MARKER/8 is the front ball joint on the knuckle. It moves along ground axes.
        let knuckle = loaded.model.markers.iter().find(|m| m.header.id == 8);
        let part = &loaded.model.parts[knuckle.expect("MARKER/8").part.0];
        let along = part.pose.R.transpose() * Vec3::new(0.0, -2.5, 0.0);
        let moves: Vec<(u32, usize, f64)> = (0..3).map(|k| (8, k + 1, along[k])).collect();
        let deck = with_moved(&loaded, &moves);
        let subject = Subject::new(&loaded, &deck).expect("a subsystem");
        let moved = subject
            .moved(&finding("point", &[8, 7]))
            .expect("a hardpoint");
        let written = subject.files(&[moved], &[], Vec::new());
        let old = std::fs::read_to_string(folder.path().join("front.sub")).unwrap();
        let row = "-25.0      -700.0       185.0";
        assert_eq!(old.matches(row).count(), 1);
        let expected = old.replace(row, "-25.0      -702.5       185.0");
        assert_eq!(String::from_utf8_lossy(&written.files[0].1), expected);
        let list: serde_json::Value = serde_json::from_slice(&written.files[1].1).unwrap();
        assert_eq!(list["changes"][0]["element"], "hpl_ball_joint_front");
        assert_eq!(list["changes"][0]["std_error"], 0.2);
        assert_eq!(list["changes"].as_array().map(Vec::len), Some(1));
        let again = Subsystem::parse(Source::new("a.sub", written.files[0].1.as_slice()));
        assert_eq!(again.diagnostics, []);
    }

    #[test]
    fn what_is_no_displacement_of_one_hardpoint_is_said() {
        let (_folder, loaded) = study("");
        let subject = Subject::new(&loaded, loaded.dataset.bytes()).expect("a subsystem");
        let refused =
            |form: &str, markers: &[u32]| subject.moved(&finding(form, markers)).unwrap_err();
        assert!(refused("part", &[7]).contains("only one part"));
        assert!(refused("point", &[19]).contains("no hardpoint"));
        let two = refused("point", &[15, 16]);
        assert!(two.contains("hpl_tierod_inner, hpl_rack_end"), "{two}");
        let (_folder, loaded) = study(
            "[car.hardpoints]\n\"MARKER/15\" = \"hpl_rack_end\"\n\"MARKER/16\" = \"hpl_rack_end\"\n",
        );
        let subject = Subject::new(&loaded, loaded.dataset.bytes()).expect("a subsystem");
        let moved = subject
            .moved(&finding("point", &[15, 16]))
            .expect("as stated");
        assert_eq!(
            subject.subsystem.hardpoints[moved.hardpoint].name,
            "rack_end"
        );
    }
}
