//! USER forces that only evaluate an Adams/Car property file, rewritten as functions of its curves.
//!
//! The parameter list of a USER force contains the id of a STRING with the name of the property file. The meaning of the other parameters
//! (preloads, offsets, scales of the instance) is unknown here. A force with such parameters keeps its subroutine unless the user declares
//! that they have no effect.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::Model;
use admire_syntax::car_field::parameters;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::files::Files;
use admire_syntax::property::{PropertyFile, PropertyKind};
use admire_syntax::text::Edit;
use admire_syntax::units::Units;
use admire_syntax::{Address, Dataset, Statement, Value};

/// Result of rewriting the USER forces of a dataset.
#[derive(Clone, Debug, Default)]
pub struct Replacement {
    /// Edits that replace the old statements by the new ones.
    pub edits: Vec<Edit>,
    /// Assumptions made in the rewriting, and the reasons why other forces keep their subroutine.
    pub diagnostics: Vec<Diagnostic>,
}

/// Maximum width of a line of spline values, in characters.
const LINE: usize = 76;
/// Minimum number of points of a curve that is evaluated by AKISPL; shorter curves use INTERP.
const AKIMA: usize = 4;

/// Rewrites GFORCEs that evaluate a `.bus` file and SFORCEs that evaluate a `.spr`, `.bum` or `.reb` file, if the property file was read.
///
/// In the new functions, d is the displacement of I from RM in RM axes, a are the projected angles, c is a curve in units of the model, and
/// L is a length:
/// - bushing: `F = -c(d)`, `T = -c(a)` on I;
/// - spring: `F = c(L - DM)`, with the free length L;
/// - bump stop: `F = c(L - DM)` where `L - DM` is positive, with L the distance at first contact;
/// - rebound stop: `F = -c(DM - L)` where `DM - L` is positive, with L the distance at first contact.
///
/// `lengths` gives L. For a spring without an entry, the FREE_LENGTH of the file is used. Damping terms proportional to the velocities are
/// added to bushings. They have no effect in statics.
///
/// The first parameter may select the subroutine, and one parameter must be the id of the STRING. Any other nonzero parameter can change
/// the force. If the address of a force with such parameters is not in `plain`, the force keeps its subroutine, and a diagnostic lists the
/// parameters.
pub fn replace_user_forces(
    dataset: &Dataset,
    files: &Files,
    lengths: &[(Address, f64)],
    plain: &[Address],
) -> Replacement {
    let units = Model::lower(dataset).value.units;
    let mut work = Work {
        dataset,
        files,
        units,
        lengths,
        plain,
        splines: ids(dataset, "SPLINE").last().copied().unwrap_or(0),
        out: Replacement::default(),
    };
    for statement in dataset.statements() {
        let user = match statement.argument("FUNCTION").map(|a| &a.value) {
            Some(Value::User(span)) => *span,
            _ => continue,
        };
        let (Some(kind @ ("GFORCE" | "SFORCE")), Some(id)) = (statement.kind(), statement.number())
        else {
            continue;
        };
        let address = Address {
            kind: kind.to_string(),
            id: Some(id),
            argument: None,
            index: None,
        };
        match work.functions(statement, &address, &dataset.source().text(user)) {
            Ok((functions, splines)) => work.rewrite(statement, &functions, &splines),
            Err(diagnostic) => {
                let name = dataset.source().name();
                work.out.diagnostics.push(diagnostic.label(name, user, ""));
            }
        }
    }
    work.out
}

/// Names of the force components, each with its function text.
type Functions = Vec<(&'static str, String)>;
type Splines = Vec<String>;

struct Work<'a> {
    dataset: &'a Dataset,
    files: &'a Files,
    units: Units,
    lengths: &'a [(Address, f64)],
    plain: &'a [Address],
    /// Highest SPLINE id in use so far.
    splines: u32,
    out: Replacement,
}

impl Work<'_> {
    fn functions(
        &mut self,
        statement: &Statement,
        address: &Address,
        user: &str,
    ) -> Result<(Functions, Splines), Diagnostic> {
        let stays = |why: String| {
            Diagnostic::warning(
                Code::UserSubroutine,
                format!("{address} keeps its subroutine: {why}"),
            )
        };
        let (name, file) = self.property_file(user).map_err(stays)?;
        let others = self.others(user, &name);
        if !others.is_empty() && !self.plain.contains(address) {
            let message = format!(
                "its parameters contain {} besides the id of `{name}`; these may include a preload, an offset or a scale",
                others.join(", ")
            );
            let help = format!(
                "if they do not change the force, use --plain {address}; otherwise add them to the function that replaces it"
            );
            return Err(stays(message).help(help));
        }
        match (statement.kind(), &file.kind) {
            (Some("GFORCE"), PropertyKind::Bushing) => {
                self.bushing(statement, &file, &name).map_err(stays)
            }
            (Some("SFORCE"), PropertyKind::Spring | PropertyKind::Stop)
                if statement.has("TRANSLATIONAL") && !statement.has("ACTIONONLY") =>
            {
                let given = self.lengths.iter().find(|(a, _)| a == address);
                let length = match (given, file.free_length(&self.units)) {
                    (Some((_, length)), _) => *length,
                    (None, Some(length)) if file.kind == PropertyKind::Spring => length,
                    _ => {
                        return Err(stays(format!(
                            "`{name}` does not state the length at which the force begins"
                        ))
                        .help(format!("state the length with --length {address}=VALUE")));
                    }
                };
                self.spring(statement, &file, &name, length).map_err(stays)
            }
            (Some(kind), _) => Err(stays(format!("`{name}` does not describe a {kind}"))),
            (None, _) => unreachable!("only forces of known kind are looked at"),
        }
    }

    /// Returns the nonzero parameters other than the first one (which selects the subroutine) and other than the id of the STRING that
    /// names the file.
    fn others(&self, user: &str, name: &str) -> Vec<String> {
        let is_file = |number: f64| {
            let id = (number >= 1.0 && number.fract() == 0.0).then_some(number as u32);
            let string = id.and_then(|id| self.dataset.statement("STRING", Some(id)));
            let text = string.and_then(|s| s.text("STRING", self.dataset.source()));
            text.is_some_and(|text| text.trim() == name)
        };
        let numbers = parameters(user).enumerate();
        let others = numbers.filter(|(k, n)| *n != 0.0 && !is_file(*n) && *k > 0);
        others.map(|(_, number)| format!("{number}")).collect()
    }

    /// Returns the single property file that the parameters of a USER call refer to.
    fn property_file(&self, user: &str) -> Result<(String, PropertyFile), String> {
        let numbers = parameters(user);
        let mut found: Option<(String, PropertyFile)> = None;
        let mut seen = BTreeSet::new();
        for number in numbers.filter(|n| *n >= 1.0 && n.fract() == 0.0) {
            let id = Some(number as u32);
            let Some(string) = self.dataset.statement("STRING", id) else {
                continue;
            };
            let text = string.text("STRING", self.dataset.source());
            let name = text.unwrap_or_default().trim().to_string();
            let Some(source) = self.files.get(&name) else {
                continue;
            };
            if !PropertyFile::is_one(source.bytes()) || !seen.insert(name.clone()) {
                continue;
            }
            if let Some((other, _)) = &found {
                return Err(format!(
                    "it reads two property files, `{other}` and `{name}`"
                ));
            }
            found = Some((name, PropertyFile::parse(source.clone()).value));
        }
        found.ok_or_else(|| {
            "none of its parameters refers to a property file that was read".to_string()
        })
    }

    fn bushing(
        &mut self,
        statement: &Statement,
        file: &PropertyFile,
        name: &str,
    ) -> Result<(Functions, Splines), String> {
        const COMPONENTS: [&str; 6] = admire_syntax::FORCE_COMPONENTS;
        const DISPLACEMENTS: [&str; 6] = ["DX", "DY", "DZ", "AX", "AY", "AZ"];
        const RATES: [&str; 6] = ["VX", "VY", "VZ", "WX", "WY", "WZ"];
        let marker = |argument: &str| statement.first(argument).unwrap_or(0.0) as u32;
        let (i, rm) = (marker("I"), marker("RM"));
        if self.part_of(rm).is_none() || self.part_of(rm) != self.part_of(marker("JFLOAT")) {
            return Err(
                "RM is not on the same part as JFLOAT, so the deformation cannot be measured"
                    .into(),
            );
        }
        let curves = file.bushing_curves(&self.units);
        let damping = file.bushing_damping(&self.units);
        let (mut functions, mut splines) = (Vec::new(), Vec::new());
        for k in 0..6 {
            let mut terms = String::new();
            let (frame, from) = if k < 3 {
                (format!("({i},{rm},{rm})"), format!("({i},{rm},{rm},{rm})"))
            } else {
                (format!("({i},{rm})"), format!("({i},{rm},{rm})"))
            };
            if let Some((x, y)) = &curves[k] {
                let at = format!("{}{frame}", DISPLACEMENTS[k]);
                let comment = format!("{} of {name}", file_block(k));
                let (call, spline) = self.curve(&at, (x, y), &comment)?;
                splines.push(spline);
                _ = write!(terms, "-{call}");
            }
            if damping[k] != 0.0 {
                _ = write!(terms, "-{}*{}{from}", damping[k], RATES[k]);
            }
            if !terms.is_empty() {
                functions.push((COMPONENTS[k], terms));
            }
        }
        Ok((functions, splines))
    }

    fn spring(
        &mut self,
        statement: &Statement,
        file: &PropertyFile,
        name: &str,
        length: f64,
    ) -> Result<(Functions, Splines), String> {
        let marker = |argument: &str| statement.first(argument).unwrap_or(0.0) as u32;
        let distance = format!("DM({},{})", marker("I"), marker("J"));
        let Some(curve) = file.curves().into_iter().next() else {
            return Err(format!("`{name}` has no curve"));
        };
        let read = ["MDI_HEADER", "UNITS", "SPRING_DATA", curve.block.as_str()];
        let other = file.blocks.iter().find(|block| {
            let empty = block.parameters.is_empty() && block.tables.is_empty();
            !empty && !read.contains(&block.name.as_str())
        });
        if let Some(other) = other {
            let block = &other.name;
            return Err(format!(
                "`{name}` has a block [{block}], whose effect on the force is unknown"
            ));
        }
        let (x, y) = curve.in_units(file.units.as_ref(), &self.units);
        let rebound = name.to_ascii_lowercase().ends_with(".reb");
        let (at, sign) = if rebound {
            (format!("{distance}-{length}"), "-")
        } else {
            (format!("{length}-{distance}"), "")
        };
        let comment = format!("{} of {name}", curve.block);
        let (call, spline) = self.curve(&at, (&x, &y), &comment)?;
        let function = if file.kind == PropertyKind::Stop {
            format!("IF({at}: 0, 0, {sign}{call})")
        } else {
            call
        };
        Ok((vec![("FUNCTION", function)], vec![spline]))
    }

    /// Returns the function call that evaluates a curve, and the text of the SPLINE that holds the curve.
    fn curve(
        &mut self,
        at: &str,
        (x, y): (&[f64], &[f64]),
        comment: &str,
    ) -> Result<(String, String), String> {
        if x.len() < 2 || x.windows(2).any(|pair| pair[1] <= pair[0]) {
            return Err(format!("the x values of {comment} do not increase"));
        }
        self.splines += 1;
        let id = self.splines;
        let call = if x.len() < AKIMA {
            format!("INTERP({at}, 1, {id})")
        } else {
            format!("AKISPL({at}, 0, {id})")
        };
        let mut spline = format!("! {comment}\nSPLINE/{id}");
        for (argument, values) in [("X", x), ("Y", y)] {
            _ = write!(spline, "\n, {argument} =");
            let mut width = 5;
            for (k, value) in values.iter().enumerate() {
                let word = format!("{value}");
                if width + word.len() + 2 > LINE {
                    spline += "\n";
                    width = 0;
                }
                // Within a list, a comma at the start of a line also acts as separator.
                spline += if k == 0 { " " } else { ", " };
                spline += &word;
                width += word.len() + 2;
            }
        }
        Ok((call, spline))
    }

    fn part_of(&self, marker: u32) -> Option<u32> {
        let marker = self.dataset.statement("MARKER", Some(marker))?;
        marker.first("PART").map(|part| part as u32)
    }

    fn rewrite(&mut self, statement: &Statement, functions: &Functions, splines: &Splines) {
        let source = self.dataset.source();
        let newline = if source
            .slice(admire_syntax::text::Span::new(0, source.bytes().len()))
            .windows(2)
            .any(|w| w == b"\r\n")
        {
            "\r\n"
        } else {
            "\n"
        };
        let head_end = statement
            .id
            .map_or(statement.keyword.end(), |(_, span)| span.end());
        let head = source.text(admire_syntax::text::Span::new(
            statement.keyword.start(),
            head_end,
        ));
        let mut lines = vec![head.into_owned()];
        for argument in &statement.arguments {
            if !matches!(argument.kind(), Some("FUNCTION" | "ROUTINE")) {
                lines.push(format!(", {}", source.text(argument.span)));
            }
        }
        let last = functions.len().saturating_sub(1);
        for (k, (component, function)) in functions.iter().enumerate() {
            let more = if k < last { "\\" } else { "" };
            lines.push(format!(", {component} = {function}{more}"));
        }
        for spline in splines {
            lines.extend(spline.lines().map(str::to_string));
        }
        self.out
            .edits
            .push(Edit::new(statement.span, lines.join(newline)));
    }
}

/// Returns the block name of the k-th curve of a bushing file.
fn file_block(k: usize) -> &'static str {
    [
        "FX_CURVE", "FY_CURVE", "FZ_CURVE", "TX_CURVE", "TY_CURVE", "TZ_CURVE",
    ][k]
}

/// Returns the ids of one kind of statement in ascending order.
fn ids(dataset: &Dataset, kind: &str) -> Vec<u32> {
    let all = dataset
        .statements()
        .iter()
        .filter(|s| s.kind() == Some(kind));
    let mut ids: Vec<u32> = all.filter_map(Statement::number).collect();
    ids.sort_unstable();
    ids
}
