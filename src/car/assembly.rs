//! Typed view of an assembly file (`.asy`).

use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::property::PropertyFile;

use crate::hardpoint::{self, Hardpoint};
use crate::parameter::{self, Parameter};

/// Contents of an assembly file.
#[derive(Clone, PartialEq, Debug)]
pub struct Assembly {
    /// Class of the assembly: `suspension`, `full_vehicle`.
    pub class: Option<String>,
    /// Subsystem files as the assembly names them, in the order of the file.
    pub subsystems: Vec<String>,
    /// Test rig.
    pub testrig: Option<String>,
    /// Hardpoints of the test rig.
    pub hardpoints: Vec<Hardpoint>,
    /// Parameters of the test rig.
    pub parameters: Vec<Parameter>,
}

impl Assembly {
    /// Reads the contents of a parsed file. Rows that cannot be read are reported.
    pub fn of(file: &PropertyFile, out: &mut Vec<Diagnostic>) -> Self {
        let source = file.source();
        let texts = |block: &str, key: &str| -> Vec<String> {
            let named = file.blocks.iter().filter(|one| one.name == block);
            named
                .filter_map(|one| Some(one.parameter(key)?.text(source).into_owned()))
                .collect()
        };
        Self {
            class: texts("ASSEMBLY_HEADER", "ASSEMBLY_CLASS")
                .into_iter()
                .next(),
            subsystems: texts("SUBSYSTEM", "USAGE"),
            testrig: texts("TESTRIG", "USAGE").into_iter().next(),
            hardpoints: hardpoint::read(file, out),
            parameters: parameter::read(file, out),
        }
    }
}
