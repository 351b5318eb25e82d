//! Adams/Car property files (`.bus`, `.spr`, `.bum`, `.reb`, `.dpr`) in TeimOrbit format, as typed curves.
//!
//! The format is described on the page `adams_tire/about.html`: blocks `[NAME]`, parts of blocks `(PART)`, tables under headings in `{}`,
//! and parameters `NAME = value`. Comments extend from `$` or `!` to the end of the line.
//!
//! The names of the blocks with curves are the names that existing readers expect (`grammar/NOTES.md`): `FX_CURVE` to `TZ_CURVE` and
//! `DAMPING` in a bushing file, `CURVE` in the other files.
//!
//! The module contains no force laws; each law documents how it uses a curve. The newer XML property files are rejected with a message that
//! names their format.

mod block;
mod curve;
mod read;
mod units;

pub use block::{Block, Cell, Parameter, Table};
pub use curve::PropertyCurve;
pub use units::PropertyUnits;

use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::text::{Source, Span};
use crate::units::{Dimension, Units};

/// The kind of element that a property file describes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum PropertyKind {
    /// `.bus`: force against displacement along x, y and z, and torque against rotation angle about x, y and z.
    Bushing,
    /// `.spr`: force against displacement; positive in compression.
    Spring,
    /// `.bum` and `.reb`: force against the penetration into a bump stop or rebound stop.
    Stop,
    /// `.dpr`: force against the velocity of the damper.
    Damper,
    /// Another kind of element: the value of FILE_TYPE, in lower case.
    Other(String),
}

/// A property file. All of its bytes are kept, together with the content of its blocks and the interpretation of its header.
#[derive(Clone, Debug)]
pub struct PropertyFile {
    source: Source,
    /// Kind of element that the file describes.
    pub kind: PropertyKind,
    /// Value of FILE_VERSION, if the file gives one.
    pub version: Option<f64>,
    /// Units in which the file gives its numbers; `None` if the file does not state them.
    pub units: Option<PropertyUnits>,
    /// All blocks and parts of blocks, in the order of the file.
    pub blocks: Vec<Block>,
}

/// Block names of the six curves in a bushing file: forces along x, y, z and torques about x, y, z.
const BUSHING_CURVES: [&str; 6] = [
    "FX_CURVE", "FY_CURVE", "FZ_CURVE", "TX_CURVE", "TY_CURVE", "TZ_CURVE",
];

impl PropertyFile {
    /// Reads a property file from any bytes.
    ///
    /// Diagnostics report lines of unknown form, rows whose width differs from their table, unreadable values, a missing header, unknown
    /// units, and curves whose x values do not increase.
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
                // A table of two columns need not be a curve: [SHAPE] of a tyre file lists the outline of its section.
                if let Some(curve) = PropertyCurve::of(&file.kind, block, table)
                    && curve.dimensions.is_some()
                {
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

    /// Reports missing content: the units, and the curves if the file contains none of the curves of its kind.
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
                "the file has no [UNITS] block".to_string(),
                "its values are assumed to be in the units of the model",
            );
        }
        let wanted = match self.kind {
            PropertyKind::Bushing => &BUSHING_CURVES[..],
            PropertyKind::Spring | PropertyKind::Stop | PropertyKind::Damper => &["CURVE"],
            PropertyKind::Other(_) => &[],
        };
        let curves = self.curves();
        // Single curves of a bushing may be absent, because a bushing may have no force in some directions. A file without any curve is
        // reported.
        let absent = wanted
            .iter()
            .all(|name| curves.iter().all(|curve| curve.block != *name));
        if absent && !wanted.is_empty() {
            complain(
                format!("the file has no block {}", wanted.join(" or ")),
                "without a curve, the element exerts no force",
            );
        }
    }

    /// Returns true if the bytes look like a TeimOrbit file: the first line that is neither blank nor a comment is `[MDI_HEADER]`.
    pub fn is_one(bytes: &[u8]) -> bool {
        let start = &bytes[..bytes.len().min(4096)];
        start
            .split(|byte| matches!(byte, b'\n' | b'\r'))
            .map(<[u8]>::trim_ascii)
            .find(|line| !(line.is_empty() || matches!(line[0], b'$' | b'!')))
            .is_some_and(|line| line.to_ascii_uppercase().starts_with(b"[MDI_HEADER]"))
    }

    /// Returns the source file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns the first block with this name in capitals; parts of blocks are not considered.
    pub fn block(&self, name: &str) -> Option<&Block> {
        self.blocks
            .iter()
            .find(|block| block.name == name && block.part.is_none())
    }

    /// Returns a parameter of a block, or of one of its parts, in units of the file: for example `FX_DAMPING` in `DAMPING`, or
    /// `FREE_LENGTH` in `SPRING_DATA`.
    pub fn number(&self, block: &str, name: &str) -> Option<f64> {
        self.blocks
            .iter()
            .filter(|one| one.name == block)
            .find_map(|one| one.parameter(name)?.number())
    }

    /// Returns all tables with two columns of numbers as curves, in the order of the file.
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

    /// Returns the curve in the block with this name, such as `FX_CURVE` or `CURVE`; case is ignored.
    pub fn curve(&self, block: &str) -> Option<PropertyCurve> {
        let block = block.to_ascii_uppercase();
        self.curves().into_iter().find(|curve| curve.block == block)
    }

    /// Returns the six curves of a bushing in the units of a model, with angles in radians: forces along x, y, z, then torques about x, y,
    /// z.
    ///
    /// A curve is a function of the deformation of I relative to J. The elastic force on the I side of the bushing is the negative of the
    /// curve.
    pub fn bushing_curves(&self, units: &Units) -> [Option<(Vec<f64>, Vec<f64>)>; 6] {
        BUSHING_CURVES.map(|name| Some(self.curve(name)?.in_units(self.units.as_ref(), units)))
    }

    /// Returns the six damping coefficients of a bushing in the units of a model: along x, y, z, then about x, y, z. Coefficients that the
    /// file does not give are zero.
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

    /// Returns the free length of a spring in the units of a model, if the file gives it.
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
            "the file has no [MDI_HEADER] block with a FILE_TYPE",
            "a property file begins with [MDI_HEADER], FILE_TYPE = 'bus'",
        )
    };
    Diagnostic::error(Code::SyntaxError, message)
        .label(source.name(), Span::at(0), "")
        .help(help)
}

#[cfg(test)]
mod tests;
