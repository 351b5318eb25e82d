use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::car::CarSettings;
use super::kc_curves::KcSettings;
use super::priors::CausePriors;
use super::section::{Key, SchemaRecorder, Section, SpannedText};
use super::settings::{
    ChannelSettings, IdentifySettings, RegressionSettings, SolverSettings, WheelSettings,
};
use super::stated::ToleranceSettings;
use super::table::Table;
use super::target_settings::TargetSettings;
use crate::digest;
use admire_session::file_below;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Readings of the marks of a study: two files, and the noise of their coordinates.
#[derive(Clone, Debug)]
pub struct MarkFiles {
    /// Positions of the marks on their parts: table with the columns part,mark,x,y,z, in the frame of each part.
    pub on_parts: Table,
    /// Measured positions of the marks in each load case: table with the columns case,part,mark,x,y,z, in ground.
    pub measured: Table,
    /// Standard deviation of the mark positions measured on the rig, per coordinate. If it is `None`, it is estimated from the misfit of the
    /// marks to rigid parts.
    pub sigma: Option<f64>,
    /// Standard deviation of the mark positions on their parts, per coordinate, as measured in the first session.
    pub sigma_on_parts: f64,
}

/// Contents of a study folder as described in guide/study.md: settings with their defaults, and the cells of all tables. Names are not yet
/// resolved in the model.
#[derive(Clone, Debug)]
pub struct Study {
    /// Path of the study folder. All files of the study are inside it.
    pub folder: PathBuf,
    /// Text of `study.toml`.
    pub source: Source,
    /// Text of the deck.
    pub deck: Source,
    /// Path of the deck's file.
    pub deck_path: PathBuf,
    /// Settings of section `[solver]`.
    pub solver: SolverSettings,
    /// Table of load cases: column `case`, then one column per load.
    pub loads: Table,
    /// Names of the load columns with the addresses that they drive, in the order of `study.toml`.
    pub columns: Vec<(SpannedText, SpannedText)>,
    /// Section `[marks]`: tables of the mark positions, and their noise.
    pub marks: Option<MarkFiles>,
    /// Section `[wheel]`, and the table of its readings if there is one.
    pub wheel: Option<(WheelSettings, Option<Table>)>,
    /// Section `[readings]`: table of the readings, and the channels.
    pub readings: Option<(Table, Vec<ChannelSettings>)>,
    /// Section `[kc]`, and the table of its readings.
    pub kc: Option<(KcSettings, Table)>,
    /// Table of gradients and loop widths of curves: key `summary` of section `[kc]`.
    pub kc_summary: Option<Table>,
    /// Settings of section `[identify]`.
    pub identify: IdentifySettings,
    /// Settings of section `[regression]`.
    pub regression: RegressionSettings,
    /// Settings of section `[tolerances]`.
    pub tolerances: ToleranceSettings,
    /// Settings of section `[priors]`.
    pub priors: CausePriors,
    /// Labels of cases and names of channels held out of all fits: key `hold_out` of section `[validate]`.
    pub hold_out: Option<Vec<SpannedText>>,
    /// Measurements that the laboratory can add: key `available` of section `[plan]`.
    pub available: Option<Vec<SpannedText>>,
    /// Reference deck of section `[reference]`, used only for reports.
    pub reference: Option<Source>,
    /// Section `[target]`: the goals of a tuning run, and the numbers of the deck that it may change.
    pub target: Option<TargetSettings>,
    /// Section `[car]`: the subsystem of Adams/Car to which results are written back. No fit reads it.
    pub car: Option<CarSettings>,
}

impl Study {
    /// Reads `study.toml` and every file it names.
    ///
    /// Unknown keys are reported as errors. The value is `None` if `study.toml`, the deck or the load cases cannot be read.
    pub fn read(folder: &Path) -> Checked<Option<Self>> {
        let mut out = Vec::new();
        let value = read(folder, &mut out);
        Checked {
            value,
            diagnostics: out,
        }
    }

    /// Returns the position of a key in `study.toml`; `keys` holds the components of its name. If the key is absent, the position of the
    /// section that should contain it is returned. If the section is absent too, it is the start of the file.
    pub fn place(&self, keys: &[&str]) -> Span {
        let text = String::from_utf8_lossy(self.source.bytes());
        let (document, _) = DeTable::parse_recoverable(&text);
        let (mut table, mut span) = (Some(document.get_ref()), Span::at(0));
        for key in keys {
            let Some((name, value)) = table.and_then(|table| table.get_key_value(*key)) else {
                break;
            };
            table = value.get_ref().as_table();
            // For a section, this is the position of its name; for any other key, the position of its value.
            span = Span::from(if table.is_some() {
                name.span()
            } else {
                value.span()
            });
        }
        span
    }

    /// Returns the input files of the study that determine its results, each with its name and bytes.
    pub fn sources(&self) -> Vec<&Source> {
        let tables = [
            Some(&self.loads),
            self.marks.as_ref().map(|marks| &marks.on_parts),
        ]
        .into_iter()
        .chain([
            self.marks.as_ref().map(|marks| &marks.measured),
            self.wheel.as_ref().and_then(|(_, table)| table.as_ref()),
            self.readings.as_ref().map(|(table, _)| table),
            self.kc.as_ref().map(|(_, table)| table),
            self.kc_summary.as_ref(),
        ])
        .flatten()
        .map(|table| &table.source);
        [&self.source, &self.deck]
            .into_iter()
            .chain(tables)
            .chain(self.target.iter().flat_map(TargetSettings::sources))
            .collect()
    }

    /// Returns the SHA-256 over all input files, in hexadecimal. Runs with equal values have read the same bytes.
    pub fn inputs_sha256(&self) -> String {
        digest(self.sources().into_iter().map(Source::bytes))
    }
}

/// Returns all keys of `study.toml` that the program reads.
pub(crate) fn study_keys() -> Vec<Key> {
    let source = Source::new("study.toml".to_string(), Vec::new());
    let files = Files {
        folder: Path::new(""),
        study: &source,
    };
    let mut keys: Vec<Key> = Vec::new();
    for texts in [false, true] {
        let inquiry = SchemaRecorder {
            texts,
            ..SchemaRecorder::default()
        };
        // The errors about missing settings are ignored, because only the queried keys matter here.
        let _ = sections(
            &mut Section::inquiring(&source, &inquiry),
            &files,
            &mut Vec::new(),
        );
        for key in inquiry.keys.into_inner() {
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
    }
    keys
}

fn read(folder: &Path, out: &mut Vec<Diagnostic>) -> Option<Study> {
    let folder = if folder.file_name().is_some_and(|name| name == "study.toml") {
        folder
            .parent()
            .map_or_else(|| PathBuf::from("."), Path::to_path_buf)
    } else {
        folder.to_path_buf()
    };
    let path = folder.join("study.toml");
    let source = match Source::read(&path) {
        Ok(source) => source,
        Err(error) => {
            out.push(no_study(&folder, &path, &error));
            return None;
        }
    };
    let text = match source.utf8() {
        Ok(text) => text,
        Err(span) => {
            let message = format!("{} is not UTF-8 text", source.name());
            let diagnostic = Diagnostic::error(Code::StudySyntax, message);
            out.push(diagnostic.label(source.name(), span, ""));
            return None;
        }
    };
    let (document, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let span = error.span().map_or(Span::at(0), Span::from);
        out.push(
            Diagnostic::error(Code::StudySyntax, error.message().to_string()).label(
                source.name(),
                span,
                "",
            ),
        );
    }
    let files = Files {
        folder: &folder,
        study: &source,
    };
    let mut root = Section::root(&source, document.get_ref());
    let parts = sections(&mut root, &files, out);
    root.finish(out);
    let parts = parts?;
    Some(Study {
        source: source.clone(),
        folder,
        ..parts
    })
}

/// Returns the diagnostic for a folder whose `study.toml` cannot be read. Its help explains how to create a study.
fn no_study(folder: &Path, path: &Path, error: &std::io::Error) -> Diagnostic {
    let shown = folder.display();
    let begin = |deck: &str| {
        format!(
            "a study is a folder with a file study.toml; `admire new STUDY --from {deck}` begins one"
        )
    };
    if folder.is_file() {
        let deck = folder
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("adm"));
        let what = if deck { "a deck" } else { "a file" };
        let message = format!("`{shown}` is {what}, not the folder of a study");
        let name = if deck {
            shown.to_string()
        } else {
            "model.adm".to_string()
        };
        return Diagnostic::error(Code::CannotRead, message).help(begin(&name));
    }
    if !folder.exists() {
        let message = format!("there is no folder `{shown}`");
        return Diagnostic::error(Code::CannotRead, message).help(begin("model.adm"));
    }
    if !path.exists() {
        let message = format!("`{shown}` is not a study: it has no file study.toml");
        return Diagnostic::error(Code::CannotRead, message).help(begin("model.adm"));
    }
    let text = format!("{} cannot be read: {error}", path.display());
    Diagnostic::error(Code::CannotRead, text)
}

/// Reads all sections of `study.toml` and the files that they name. The caller must set `source` and `folder` of the result.
fn sections(root: &mut Section<'_>, files: &Files<'_>, out: &mut Vec<Diagnostic>) -> Option<Study> {
    let mut model = root.section("model", out);
    let deck = files.required(&mut model, "deck", out);
    model.finish(out);

    let mut section = root.section("solver", out);
    let solver = SolverSettings::read(&mut section, out);
    files.path(&solver.recordings, out);
    section.finish(out);

    let mut section = root.section("loads", out);
    let loads = if section.is_present() || !root.has("target") {
        files.required(&mut section, "file", out)
    } else {
        // The tests of kc.toml load an axle that has a target.
        Some((Source::new(files.study.name(), Vec::new()), PathBuf::new()))
    };
    let mut inner = section.section("columns", out);
    let columns = inner.all_texts(out);
    section.finish(out);

    let mut section = root.section("marks", out);
    let marks = if section.is_present() {
        let on_parts = files.required(&mut section, "on_parts", out);
        let measured = files.readings(&mut section, "measured", out);
        let sigma = section.deviation("sigma", out);
        let sigma_on_parts = section.number("sigma_on_parts", 0.0, 0.0..=f64::INFINITY, out);
        on_parts
            .zip(measured)
            .map(|((on_parts, _), (measured, _))| MarkFiles {
                on_parts: Table::read(on_parts, out),
                measured: Table::read(measured, out),
                sigma,
                sigma_on_parts,
            })
    } else {
        None
    };
    section.finish(out);

    let mut section = root.section("wheel", out);
    let wheel = if section.is_present() {
        let settings = WheelSettings::read(&mut section, out);
        let table = if section.is_text("measured") {
            files.readings(&mut section, "measured", out)
        } else {
            None
        };
        settings.map(|settings| (settings, table.map(|(source, _)| Table::read(source, out))))
    } else {
        None
    };
    section.finish(out);

    let mut section = root.section("readings", out);
    let readings = if section.is_present() {
        let file = files.readings(&mut section, "file", out);
        let mut channels = Vec::new();
        for (name, mut channel) in section.section("channels", out).all_sections(out) {
            channels.extend(ChannelSettings::read(&name, &mut channel, out));
            channel.finish(out);
        }
        file.map(|(source, _)| (Table::read(source, out), channels))
    } else {
        None
    };
    section.finish(out);

    let mut kc_summary = None;
    let mut section = root.section("kc", out);
    let kc = if section.is_present() {
        let file = files.readings(&mut section, "file", out);
        if section.is_text("summary") {
            kc_summary = files
                .readings(&mut section, "summary", out)
                .map(|(source, _)| Table::read(source, out));
        }
        let settings = KcSettings::read(&mut section, out);
        settings
            .zip(file)
            .map(|(settings, (source, _))| (settings, Table::read(source, out)))
    } else {
        None
    };
    section.finish(out);

    let mut section = root.section("identify", out);
    let identify = IdentifySettings::read(&mut section, out);
    section.finish(out);

    let mut section = root.section("regression", out);
    let regression = RegressionSettings::read(&mut section, out);
    section.finish(out);

    let mut section = root.section("tolerances", out);
    let tolerances = ToleranceSettings::read(&mut section, out);
    section.finish(out);

    let mut section = root.section("priors", out);
    let priors = CausePriors::read(&mut section, out);
    section.finish(out);

    let mut section = root.section("validate", out);
    let hold_out = section.texts("hold_out", out);
    section.finish(out);

    let mut section = root.section("plan", out);
    let available = section.texts("available", out);
    section.finish(out);

    let mut section = root.section("reference", out);
    let reference = files.optional(&mut section, "deck", out);
    section.finish(out);

    let mut section = root.section("target", out);
    let target = if section.is_present() {
        let mut open = |name: &SpannedText, out: &mut Vec<Diagnostic>| {
            files.open(name, out).map(|(source, _)| source)
        };
        TargetSettings::read(&mut section, &mut open, out)
    } else {
        None
    };
    section.finish(out);

    let mut section = root.section("car", out);
    let car = if section.is_present() {
        let file = files.required(&mut section, "subsystem", out);
        CarSettings::read(&mut section, file.map(|(source, _)| source), out)
    } else {
        None
    };
    section.finish(out);

    let (deck, deck_path) = deck?;
    let (loads, _) = loads?;
    Some(Study {
        folder: PathBuf::new(),
        source: files.study.clone(),
        deck,
        deck_path,
        solver,
        loads: Table::read(loads, out),
        columns,
        marks,
        wheel,
        readings,
        kc,
        kc_summary,
        identify,
        regression,
        tolerances,
        priors,
        hold_out,
        available,
        reference: reference.map(|(source, _)| source),
        target,
        car,
    })
}

/// Access to the files inside the study folder. No other file is opened.
struct Files<'a> {
    folder: &'a Path,
    study: &'a Source,
}

impl Files<'_> {
    fn required(
        &self,
        section: &mut Section<'_>,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<(Source, PathBuf)> {
        let Some(spelled) = section.text(key, out) else {
            let message = format!("a study needs `{}`", section.name(key));
            let mut diagnostic = Diagnostic::error(Code::MissingSetting, message);
            diagnostic = diagnostic.label(self.study.name(), section.span(), "");
            out.push(diagnostic);
            return None;
        };
        self.open(&spelled, out)
    }

    /// Opens the file of readings that a key names. A file that cannot be read is reported and treated as empty, because a virtual rig may
    /// produce it.
    fn readings(
        &self,
        section: &mut Section<'_>,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<(Source, PathBuf)> {
        let count = out.len();
        let text = section.text(key, &mut Vec::new());
        let opened = self.required(section, key, out);
        let unreadable = out[count..]
            .iter()
            .any(|diagnostic| diagnostic.code == Code::CannotRead);
        opened.or_else(|| {
            let path = self.folder.join(&text.filter(|_| unreadable)?.text);
            Some((Source::new(path.display().to_string(), Vec::new()), path))
        })
    }

    fn optional(
        &self,
        section: &mut Section<'_>,
        key: &'static str,
        out: &mut Vec<Diagnostic>,
    ) -> Option<(Source, PathBuf)> {
        let spelled = section.text(key, out)?;
        self.open(&spelled, out)
    }

    /// Returns the path of a file that the study names. The path must be inside the study folder, even if the file does not exist; otherwise it
    /// is reported.
    fn path(&self, spelled: &SpannedText, out: &mut Vec<Diagnostic>) -> Option<PathBuf> {
        let found = file_below(self.folder, &spelled.text, "study");
        let label = |told: Diagnostic| told.label(self.study.name(), spelled.span, "");
        out.extend(found.diagnostics.into_iter().map(label));
        found.value
    }

    fn open(&self, spelled: &SpannedText, out: &mut Vec<Diagnostic>) -> Option<(Source, PathBuf)> {
        let path = self.path(spelled, out)?;
        match Source::read(&path) {
            Ok(source) => Some((source, path)),
            Err(error) => {
                let message = format!("`{}` cannot be read: {error}", spelled.text);
                out.push(Diagnostic::error(Code::CannotRead, message).label(
                    self.study.name(),
                    spelled.span,
                    "",
                ));
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::{Amount, BackendChoice, Initial, Method, Symmetry};
    use super::*;

    fn study(toml: &str) -> (tempfile::TempDir, Checked<Option<Study>>) {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("study.toml", toml);
        write("model.adm", "t\nEND\n");
        write("loads.csv", "case,v\n1,1500\n");
        let checked = Study::read(folder.path());
        (folder, checked)
    }

    const SMALL: &str = "[model]\ndeck = \"model.adm\"\n[loads]\nfile = \"loads.csv\"\ncolumns = { v = \"SFORCE/3\" }\n";

    #[test]
    fn defaults_are_those_of_the_format() {
        let (_folder, checked) = study(SMALL);
        assert!(checked.diagnostics.is_empty(), "{:?}", checked.diagnostics);
        let study = checked.value.unwrap();
        assert_eq!(study.solver.backend, BackendChoice::Native);
        assert_eq!(study.solver.command[3], "i");
        assert_eq!(study.identify.method, Method::GaussNewton);
        assert_eq!(study.identify.symmetry, Symmetry::None);
        assert_eq!(study.identify.prior_log_sd, 3.0);
        assert_eq!(study.identify.offset_sd.length, Amount::Usual(0.5));
        assert_eq!(study.identify.frame_sd.angle_deg, 0.0);
        assert_eq!(study.regression, RegressionSettings::default());
        let initial = Initial::Values {
            translational: Amount::Usual(1e4),
            rotational_per_degree: Amount::Usual(1e4),
        };
        assert_eq!(study.identify.initial, initial);
        assert_eq!(study.columns[0].1.text, "SFORCE/3");
        assert_eq!(study.inputs_sha256().len(), 64);
    }

    #[test]
    fn names_of_a_study_from_windows_are_found_whatever_their_case() {
        let text = SMALL
            .replace("model.adm", ".\\\\MODEL.ADM")
            .replace("loads.csv", "Loads.CSV");
        let (folder, checked) = study(&text);
        let study = checked.value.expect("found");
        assert_eq!(study.loads.source.bytes(), b"case,v\n1,1500\n");
        // On a case-insensitive file system, both spellings name the same file, and nothing is reported.
        if folder.path().join("MODEL.ADM").exists() {
            return;
        }
        let found: Vec<(Code, &str)> = checked
            .diagnostics
            .iter()
            .map(|d| (d.code, &text[d.labels[0].span.range()]))
            .collect();
        let told = |name| (Code::FileNameCase, name);
        assert_eq!(found, [told("\".\\\\MODEL.ADM\""), told("\"Loads.CSV\"")]);
    }

    #[test]
    fn every_complaint_points_at_its_place() {
        let text = format!(
            "{SMALL}[identify]\nmethd = \"direct\"\nloss = 3\n[regression]\nepsilon = -1\n[reference]\ndeck = \"../other.adm\"\n[extra]\n"
        );
        let (_folder, checked) = study(&text);
        let found: Vec<(Code, &str)> = checked
            .diagnostics
            .iter()
            .map(|d| (d.code, &text[d.labels[0].span.range()]))
            .collect();
        for expected in [
            (Code::BadSetting, "3"),
            (Code::UnknownKey, "methd"),
            (Code::BadSetting, "-1"),
            (Code::OutsideStudy, "\"../other.adm\""),
            (Code::UnknownKey, "extra"),
        ] {
            assert!(found.contains(&expected), "{expected:?} in {found:?}");
        }
        let misspelt = checked
            .diagnostics
            .iter()
            .find(|d| d.message.contains("methd"))
            .unwrap();
        assert_eq!(
            misspelt.help.as_deref(),
            Some("did you mean `identify.method`?")
        );
    }

    #[test]
    fn without_a_study_there_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let checked = Study::read(folder.path());
        assert!(checked.value.is_none() && checked.has_errors());
        let (_folder, checked) = study("[model\n");
        assert!(checked.value.is_none() && checked.has_errors());
    }
}
