//! Adams/Car property files (`.bus`, `.spr`, `.bum`, `.reb`, `.dpr`) in their TeimOrbit form, as typed curves.
//!
//! The form is that of the page `adams_tire/about.html`: blocks in `[]`, their parts in `()`, tables under `{}`, parameters
//! `NAME = value`, comments from `$` or `!` to the end of the line. Which block holds which curve is what readers in the wild look for
//! (`grammar/NOTES.md`): `FX_CURVE` to `TZ_CURVE` and `DAMPING` in a bushing file, `CURVE` in the others. Knows no elements: what a force law makes of
//! a curve is said where the law is. The newer `.xml` property files are refused by name.

mod block;
mod curve;
mod read;
mod units;

pub(crate) use block::Block;
pub use block::{Cell, Parameter, Table};
pub(crate) use curve::PropertyCurve;
pub(crate) use units::PropertyUnits;

use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::text::{Source, Span};
use crate::units::{Dimension, Units};

/// The elements that property files describe.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum PropertyKind {
    /// `.bus`: force over displacement in x, y, z and torque over angle about them.
    Bushing,
    /// `.spr`: force over displacement; positive in compression.
    Spring,
    /// `.bum` and `.reb`: force over the penetration of a bump or rebound stop.
    Stop,
    /// `.dpr`: force over velocity.
    Damper,
    /// Another one: the word after FILE_TYPE, in lower case.
    Other(String),
}

/// A property file, losslessly: its bytes, what stands in its blocks, and what that means.
#[derive(Clone, Debug)]
pub struct PropertyFile {
    source: Source,
    /// What it describes.
    pub kind: PropertyKind,
    /// FILE_VERSION, if it is given.
    pub version: Option<f64>,
    /// Its units; absent where the file states none.
    pub units: Option<PropertyUnits>,
    /// Every block and sub-block, in the order of the file.
    pub blocks: Vec<Block>,
}

/// The six curves of a bushing file in the order x, y, z, about x, about y, about z.
const BUSHING_CURVES: [&str; 6] = [
    "FX_CURVE", "FY_CURVE", "FZ_CURVE", "TX_CURVE", "TY_CURVE", "TZ_CURVE",
];

impl PropertyFile {
    /// Reads any bytes. Complaints: lines of no known form, rows of other widths than their table, values that cannot be read, a
    /// missing header, unknown units, curves that do not increase.
    pub fn parse(source: Source) -> Checked<Self> {
        let Checked {
            value: blocks,
            mut diagnostics,
        } = read::blocks(&source);
        let header = |name: &str| -> Option<&Parameter> {
            let block = blocks.iter().find(|block| block.name == "MDI_HEADER")?;
            block.parameter(name)
        };
        let kind = if let Some(parameter) = header("FILE_TYPE") {
            kind_of(&parameter.text(&source))
        } else {
            diagnostics.push(no_header(&source));
            kind_of(source.name().rsplit('.').next().unwrap_or_default())
        };
        let version = header("FILE_VERSION").and_then(Parameter::number);
        let units = blocks
            .iter()
            .find(|block| block.name == "UNITS")
            .map(|block| PropertyUnits::read(block, &source, &mut diagnostics));
        let file = Self {
            source,
            kind,
            version,
            units,
            blocks,
        };
        for block in &file.blocks {
            for table in &block.tables {
                if let Some(curve) = PropertyCurve::of(&file.kind, block, table) {
                    curve.check(table, &file.source, &mut diagnostics);
                }
            }
        }
        file.missing(&mut diagnostics);
        diagnostics.sort_by_key(|diagnostic| diagnostic.labels.first().map(|l| l.span.start()));
        Checked {
            value: file,
            diagnostics,
        }
    }

    /// Complains of what a file of its kind is not without: its units, and the curves it is there for.
    fn missing(&self, diagnostics: &mut Vec<Diagnostic>) {
        let Some(header) = self.block("MDI_HEADER") else {
            return;
        };
        let mut complain = |message: String, help: &str| {
            diagnostics.push(
                Diagnostic::warning(Code::MissingArgument, message)
                    .label(self.source.name(), header.heading, "")
                    .help(help),
            );
        };
        if self.units.is_none() {
            complain(
                "the file has no [UNITS]".to_string(),
                "its numbers are taken to be in the units of the model",
            );
        }
        let wanted = match self.kind {
            PropertyKind::Bushing => &BUSHING_CURVES[..],
            PropertyKind::Spring | PropertyKind::Stop | PropertyKind::Damper => &["CURVE"],
            PropertyKind::Other(_) => &[],
        };
        let curves = self.curves();
        // A bushing may be without force in some directions; a file without any curve is of no use.
        let absent = wanted
            .iter()
            .all(|name| curves.iter().all(|curve| curve.block != *name));
        if absent && !wanted.is_empty() {
            complain(
                format!("the file has no {}", wanted.join(", ")),
                "without a curve there is no force",
            );
        }
    }

    /// True if the bytes look like a TeimOrbit file: the first line that is no comment is `[MDI_HEADER]`.
    pub fn is_one(bytes: &[u8]) -> bool {
        let start = &bytes[..bytes.len().min(4096)];
        start
            .split(|byte| matches!(byte, b'\n' | b'\r'))
            .map(<[u8]>::trim_ascii)
            .find(|line| !(line.is_empty() || matches!(line[0], b'$' | b'!')))
            .is_some_and(|line| line.to_ascii_uppercase().starts_with(b"[MDI_HEADER]"))
    }

    /// The file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The first block of this name in capitals, sub-blocks not among them.
    pub(crate) fn block(&self, name: &str) -> Option<&Block> {
        self.blocks
            .iter()
            .find(|block| block.name == name && block.part.is_none())
    }

    /// A number of a block, such as `DAMPING`, `FX_DAMPING` or `SPRING_DATA`, `FREE_LENGTH`, in units of the file.
    pub(crate) fn number(&self, block: &str, name: &str) -> Option<f64> {
        self.blocks
            .iter()
            .filter(|one| one.name == block)
            .find_map(|one| one.parameter(name)?.number())
    }

    /// Every table of two columns of numbers, in the order of the file.
    pub fn curves(&self) -> Vec<PropertyCurve> {
        self.blocks
            .iter()
            .flat_map(|block| {
                block
                    .tables
                    .iter()
                    .filter_map(|table| PropertyCurve::of(&self.kind, block, table))
            })
            .collect()
    }

    /// The curve of a block, such as `FX_CURVE` or `CURVE`; the case of letters does not matter.
    pub fn curve(&self, block: &str) -> Option<PropertyCurve> {
        let block = block.to_ascii_uppercase();
        self.curves().into_iter().find(|curve| curve.block == block)
    }

    /// The six curves of a bushing in the units of a model: x, y, z, about x, about y, about z, whose angles are radians. The
    /// elastic force of the bushing on its I side is the negative of the curve at the deformation of I from J.
    pub fn bushing_curves(&self, units: &Units) -> [Option<(Vec<f64>, Vec<f64>)>; 6] {
        BUSHING_CURVES.map(|name| Some(self.curve(name)?.in_units(self.units.as_ref(), units)))
    }

    /// The six damping rates of a bushing in the units of a model; zero where the file gives none.
    pub fn bushing_damping(&self, units: &Units) -> [f64; 6] {
        std::array::from_fn(|k| {
            let name = BUSHING_CURVES[k].replace("CURVE", "DAMPING");
            let rate = self.number("DAMPING", &name).unwrap_or(0.0);
            let dimension = if k < 3 {
                Dimension::new(1, 0, -1, 1, 0)
            } else {
                Dimension::new(1, 0, 1, 1, -1)
            };
            match &self.units {
                Some(own) => rate * own.factor(dimension, units),
                None => rate,
            }
        })
    }

    /// The free length of a spring in the units of a model.
    pub fn free_length(&self, units: &Units) -> Option<f64> {
        let length = self.number("SPRING_DATA", "FREE_LENGTH")?;
        Some(match &self.units {
            Some(own) => length * own.factor(Dimension::LENGTH, units),
            None => length,
        })
    }
}

fn kind_of(word: &str) -> PropertyKind {
    match word.to_ascii_lowercase().as_str() {
        "bus" => PropertyKind::Bushing,
        "spr" => PropertyKind::Spring,
        "bum" | "reb" => PropertyKind::Stop,
        "dpr" => PropertyKind::Damper,
        other => PropertyKind::Other(other.to_string()),
    }
}

fn no_header(source: &Source) -> Diagnostic {
    let xml = source.bytes().trim_ascii_start().starts_with(b"<");
    let (message, help) = if xml {
        (
            "this is an XML property file; only the TeimOrbit form is read",
            "save it in the TeimOrbit form in Adams/Car",
        )
    } else {
        (
            "the file has no [MDI_HEADER] with a FILE_TYPE",
            "a property file begins with [MDI_HEADER], FILE_TYPE = 'bus'",
        )
    };
    Diagnostic::error(Code::SyntaxError, message)
        .label(source.name(), Span::at(0), "")
        .help(help)
}

#[cfg(test)]
mod tests;
