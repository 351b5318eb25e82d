//! Differences between two files, value by value and independent of layout.

use std::collections::HashMap;

use admire_syntax::diff::{DiffKind, DiffTolerance, Difference};
use admire_syntax::property::{Cell, PropertyFile};

use crate::entry::{Entry, entries};

/// Returns the differences between two files. The differences of the values in `before` come first, in their order. Values that only `after`
/// contains follow. Comments, layout, the case of names and the spelling of numbers make no difference.
pub fn diff(
    before: &PropertyFile,
    after: &PropertyFile,
    tolerance: DiffTolerance,
) -> Vec<Difference> {
    let (old, new) = (entries(before), entries(after));
    let key = |entry: &Entry| entry.address.to_ascii_lowercase();
    let theirs: HashMap<String, &Entry> = new.iter().map(|entry| (key(entry), entry)).collect();
    let ours: HashMap<String, &Entry> = old.iter().map(|entry| (key(entry), entry)).collect();
    let differs = |address: &str, change| Difference {
        address: address.to_string(),
        name: None,
        change,
    };
    let mut found = Vec::new();
    for entry in &old {
        let was = entry.text(before.source());
        let Some(other) = theirs.get(&key(entry)) else {
            found.push(differs(
                &entry.address,
                DiffKind::Text {
                    before: Some(was.into_owned()),
                    after: None,
                },
            ));
            continue;
        };
        let is = other.text(after.source());
        let change = match (&entry.cell, &other.cell) {
            (Cell::Number(a), Cell::Number(b)) => {
                (!tolerance.same(a.value, b.value)).then(|| DiffKind::Number {
                    before: a.value,
                    after: b.value,
                    written: [was.into_owned(), is.into_owned()],
                })
            }
            _ => (was != is).then(|| DiffKind::Text {
                before: Some(was.into_owned()),
                after: Some(is.into_owned()),
            }),
        };
        found.extend(change.map(|change| differs(&entry.address, change)));
    }
    for entry in new.iter().filter(|entry| !ours.contains_key(&key(entry))) {
        found.push(differs(
            &entry.address,
            DiffKind::Text {
                before: None,
                after: Some(entry.text(after.source()).into_owned()),
            },
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::Source;

    #[test]
    fn values_differ_and_layout_does_not() {
        let read = |text: &str| PropertyFile::parse(Source::new("a", text)).value;
        let a = read("$ one\n[A]\nX = 1.0\nY = 'a  '\n[T]\n{n v}\n'p' 1\n'q' 2\n");
        let b = read("[A]\r\n  X=1 ! same\r\n  Y='b'\r\n[T]\r\n{N V}\r\n'q' 2.5\r\n'r' 3\r\n");
        let lines: Vec<String> = diff(&a, &b, DiffTolerance::default())
            .iter()
            .map(|d| match &d.change {
                DiffKind::Number { written, .. } => format!("{} {written:?}", d.address),
                DiffKind::Text { before, after } => format!("{} {before:?} {after:?}", d.address),
                _ => d.address.clone(),
            })
            .collect();
        assert_eq!(
            lines,
            [
                "A.Y Some(\"a\") Some(\"b\")",
                "T/p.n Some(\"p\") None",
                "T/p.v Some(\"1\") None",
                "T/q.v [\"2\", \"2.5\"]",
                "T/r.n None Some(\"r\")",
                "T/r.v None Some(\"3\")",
            ]
        );
        let loose = DiffTolerance {
            absolute: 1.0,
            relative: 0.0,
        };
        assert_eq!(diff(&a, &b, loose).len(), 5);
    }
}
