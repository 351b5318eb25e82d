//! Diagnostics of any file in TeimOrbit format.

use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::property::{PropertyFile, PropertyKind};
use admire_syntax::text::Source;

use crate::assembly::Assembly;
use crate::subsystem::Subsystem;

/// Returns the diagnostics of a file in the order of their places: those of its format, and those of the typed view for its kind. For a file of
/// another kind, only the format is checked.
pub fn check(source: Source) -> Vec<Diagnostic> {
    let read = PropertyFile::parse(source);
    let mut out = read.diagnostics;
    if let PropertyKind::Other(word) = read.value.kind.clone() {
        match word.as_str() {
            "sub" => {
                Subsystem::of(read.value, &mut out);
            }
            "asy" => {
                Assembly::of(&read.value, &mut out);
            }
            _ => {}
        }
    }
    out.sort_by_key(|found| found.labels.first().map(|label| label.span.start()));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::diagnostic::Code;

    #[test]
    fn a_subsystem_is_checked_row_by_row() {
        let text = "[MDI_HEADER]\nFILE_TYPE='sub'\n[UNITS]\nLENGTH='mm'\n[HARDPOINT]\n{hardpoint_name symmetry x_value y_value z_value}\n\
            'a' 'left/right' 1 2 3\n'b' 'both' 1 2 3\n'c' 'single' 1 two 3\n'A' 'right' 4 5 6\n\
            [PARAMETER]\n{parameter_name symmetry type value}\n'p' 'single' 'integer' 1.5\n'q' 'single' 'string' 'yes'\n\
            [BUSHING_ASSEMBLY]\nUSAGE='x'\n";
        let found: Vec<(Code, usize)> = check(Source::new("a.sub", text))
            .iter()
            .map(|d| {
                let at = d.labels[0].span.start();
                (d.code, text[..at].lines().count())
            })
            .collect();
        assert_eq!(
            found,
            [
                (Code::WrongType, 8),
                (Code::BadNumber, 9),
                (Code::DuplicateId, 10),
                (Code::WrongType, 13),
                (Code::MissingArgument, 14),
            ]
        );
    }
}
