use std::collections::BTreeMap;

use crate::diagnostic::{Applicability, Diagnostic};
use crate::text::{Edit, Span};

/// Returns the edits of all fixes that keep the meaning of the file; `file` is the name of its source.
///
/// If fixes overlap, only the first is applied. The problems of the others are found again when the edited file is checked.
pub fn safe_fixes(diagnostics: &[Diagnostic], file: &str) -> Vec<Edit> {
    fixes(diagnostics, file, |how| how == Applicability::Safe)
}

/// Returns the edits of all fixes, including fixes that may change the meaning, such as the correction of a misspelt word.
pub fn all_fixes(diagnostics: &[Diagnostic], file: &str) -> Vec<Edit> {
    fixes(diagnostics, file, |_| true)
}

/// Adds a "did you mean" help with the nearest words. If there is exactly one such word, a fix is added as well.
pub(super) fn did_you_mean(diagnostic: Diagnostic, span: Span, near: &[&str]) -> Diagnostic {
    let asked = diagnostic.help(format!("did you mean {}?", near.join(" or ")));
    match near {
        [one] => asked.fix(
            format!("write {one}"),
            vec![Edit::new(span, *one)],
            Applicability::MaybeIncorrect,
        ),
        _ => asked,
    }
}

fn fixes(
    diagnostics: &[Diagnostic],
    file: &str,
    wanted: impl Fn(Applicability) -> bool,
) -> Vec<Edit> {
    let mut taken: BTreeMap<Span, Edit> = BTreeMap::new();
    for diagnostic in diagnostics {
        let (Some(fix), Some(label)) = (&diagnostic.fix, diagnostic.labels.first()) else {
            continue;
        };
        if wanted(fix.applicability)
            && &*label.file == file
            && fix.edits.iter().all(|edit| fits(&taken, edit.span))
        {
            taken.extend(fix.edits.iter().map(|edit| (edit.span, edit.clone())));
        }
    }
    taken.into_values().collect()
}

/// Returns true if a span overlaps none of the spans in `taken`. The spans are sorted and disjoint, so only the two neighbours are
/// compared.
fn fits(taken: &BTreeMap<Span, Edit>, span: Span) -> bool {
    let apart = |a: Span, b: Span| a.end() < b.start() || (a.end() == b.start() && !a.is_empty());
    let before = taken.range(..=span).next_back();
    let after = taken.range(span..).next();
    before.is_none_or(|(other, _)| apart(*other, span))
        && after.is_none_or(|(other, _)| apart(span, *other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dataset;
    use crate::text::Source;

    #[test]
    fn a_missing_backslash_is_written() {
        let text = "t\nSFORCE/1, I=1, J=2, ROT\n, FUNCTION = 2*TIME\n, ROUTINE = a::b\nEND\n";
        let parsed = Dataset::parse(Source::new("a.adm", text.as_bytes()));
        let edits = safe_fixes(&parsed.diagnostics, "a.adm");
        let fixed = parsed.value.edited(&edits).unwrap();
        assert_eq!(fixed.diagnostics, []);
        assert!(String::from_utf8_lossy(fixed.value.bytes()).contains("2*TIME\\\n, ROUTINE"));
        assert_eq!(safe_fixes(&fixed.diagnostics, "a.adm"), []);
    }
}
