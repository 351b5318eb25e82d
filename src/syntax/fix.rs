use crate::diagnostic::{Applicability, Diagnostic};
use crate::text::Edit;

/// The edits of all fixes that keep the meaning of a file, for `file` as named by its source. Of fixes that meet at one place
/// the first one is taken; the others can be had when the file is read again.
pub fn safe_fixes(diagnostics: &[Diagnostic], file: &str) -> Vec<Edit> {
    let mut taken: Vec<Edit> = Vec::new();
    for diagnostic in diagnostics {
        let (Some(fix), Some(label)) = (&diagnostic.fix, diagnostic.labels.first()) else {
            continue;
        };
        let apart = |edit: &Edit| {
            taken.iter().all(|other| {
                edit.span.end < other.span.start
                    || other.span.end < edit.span.start
                    || (edit.span.end == other.span.start && !edit.span.is_empty())
                    || (other.span.end == edit.span.start && !other.span.is_empty())
            })
        };
        if fix.applicability == Applicability::Safe
            && &*label.file == file
            && fix.edits.iter().all(apart)
        {
            taken.extend(fix.edits.iter().cloned());
        }
    }
    taken.sort_by_key(|edit| edit.span);
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::Dataset;
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
