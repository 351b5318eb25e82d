//! Typed view of a subsystem file (`.sub`).

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::Source;

use crate::hardpoint::{self, Hardpoint, symmetry_of};
use crate::parameter::{self, Parameter};
use crate::side::Symmetry;

/// One block `[BUSHING_ASSEMBLY]`: all bushings with one name.
#[derive(Clone, PartialEq, Debug)]
pub struct BushingAssembly {
    /// Name of the bushing (USAGE).
    pub usage: String,
    /// Sides on which the bushing exists.
    pub symmetry: Symmetry,
    /// Property file as the block names it, such as `mdids://database/bushings.tbl/soft.bus`.
    pub property_file: Option<String>,
    /// Index of the block among the blocks of the file.
    pub block: usize,
}

/// A subsystem file with its typed contents. All bytes of the file are kept.
#[derive(Clone, Debug)]
pub struct Subsystem {
    /// The file itself.
    pub file: PropertyFile,
    /// Template from which the subsystem was made, as the file names it.
    pub template: Option<String>,
    /// Major role, such as `suspension`.
    pub major_role: Option<String>,
    /// Minor role, such as `front`.
    pub minor_role: Option<String>,
    /// Hardpoints in the order of the file.
    pub hardpoints: Vec<Hardpoint>,
    /// Parameters in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Bushings in the order of the file.
    pub bushings: Vec<BushingAssembly>,
}

impl Subsystem {
    /// Reads a subsystem file from any bytes.
    ///
    /// The diagnostics are those of the file itself, and those of unreadable hardpoints, parameters and bushings.
    pub fn parse(source: Source) -> Checked<Self> {
        let read = PropertyFile::parse(source);
        let mut diagnostics = read.diagnostics;
        let value = Self::of(read.value, &mut diagnostics);
        Checked { value, diagnostics }
    }

    /// Reads the contents of a file that has already been parsed.
    pub(crate) fn of(file: PropertyFile, out: &mut Vec<Diagnostic>) -> Self {
        let source = file.source();
        let header = |name: &str| -> Option<String> {
            let block = file.block("SUBSYSTEM_HEADER")?;
            Some(block.parameter(name)?.text(source).into_owned())
        };
        let (template, major_role, minor_role) = (
            header("TEMPLATE_NAME"),
            header("MAJOR_ROLE"),
            header("MINOR_ROLE"),
        );
        let hardpoints = hardpoint::read(&file, out);
        let parameters = parameter::read(&file, out);
        let bushings = bushings(&file, out);
        Self {
            file,
            template,
            major_role,
            minor_role,
            hardpoints,
            parameters,
            bushings,
        }
    }
}

fn bushings(file: &PropertyFile, out: &mut Vec<Diagnostic>) -> Vec<BushingAssembly> {
    let source = file.source();
    let mut found = Vec::new();
    for (at, block) in file.blocks.iter().enumerate() {
        if block.name != "BUSHING_ASSEMBLY" || block.part.is_some() {
            continue;
        }
        let (Some(usage), Some(symmetry)) = (block.parameter("USAGE"), block.parameter("SYMMETRY"))
        else {
            out.push(
                Diagnostic::warning(
                    Code::MissingArgument,
                    "a [BUSHING_ASSEMBLY] needs USAGE and SYMMETRY",
                )
                .label(source.name(), block.heading, "this bushing is not read"),
            );
            continue;
        };
        let Some(symmetry) = symmetry_of(file, &symmetry.value, out) else {
            continue;
        };
        found.push(BushingAssembly {
            usage: usage.text(source).into_owned(),
            symmetry,
            property_file: block
                .parameter("PROPERTY_FILE")
                .map(|name| name.text(source).into_owned()),
            block: at,
        });
    }
    found
}
