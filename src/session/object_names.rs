use std::collections::BTreeMap;

use admire_syntax::diagnostic::Label;
use admire_syntax::text::Span;
use admire_syntax::{Dataset, Statement};

/// Names that ADAMS prints for the objects of a dataset: `model.hinge`, or `model.link.tip` for a marker. Only objects with an ADAMS/View
/// name are included.
///
/// In messages of ADAMS, every name begins with `model`, whatever the name of the model is.
#[derive(Clone, Debug)]
pub(super) struct ObjectNames {
    file: String,
    /// Spans of the statements and names of their objects, in the order of the file.
    statements: Vec<(Span, String)>,
}

impl ObjectNames {
    /// Collects the names of all objects in a dataset.
    pub(crate) fn of(dataset: &Dataset) -> Self {
        let source = dataset.source();
        let name = |statement: &Statement| statement.view_name.map(|span| source.text(span));
        let mut parts = BTreeMap::new();
        for statement in dataset.statements() {
            if let (Some("PART" | "POINT_MASS" | "FLEX_BODY"), Some(id), Some(name)) =
                (statement.kind(), statement.number(), name(statement))
            {
                parts.insert((statement.kind(), id), name);
            }
        }
        let part_of = |statement: &Statement| {
            let owner = |kind: &'static str| {
                let id = statement.first(kind)?;
                parts.get(&(Some(kind), id as u32))
            };
            let mut owners = ["PART", "POINT_MASS", "FLEX_BODY"].into_iter();
            (statement.kind() == Some("MARKER")).then(|| owners.find_map(owner))?
        };
        let statements = dataset.statements().iter().filter_map(|statement| {
            let part = part_of(statement).map(AsRef::as_ref);
            Some((statement.span, qualified(part, &name(statement)?)))
        });
        Self {
            file: source.name().to_string(),
            statements: statements.collect(),
        }
    }

    /// Returns the name of the object whose statement contains the location of a label.
    pub(crate) fn at(&self, label: &Label) -> Option<&str> {
        if *label.file != *self.file || label.is_about_all() {
            return None;
        }
        let at = label.span.start();
        let after = self
            .statements
            .partition_point(|(span, _)| span.start() <= at);
        let (span, name) = self.statements.get(after.checked_sub(1)?)?;
        (at < span.end()).then_some(name.as_str())
    }
}

/// Returns `model.hinge`, or `model.link.tip` for a marker on the part `link`. A name that contains dots is a full path and gets no part
/// name.
pub(super) fn qualified(part: Option<&str>, name: &str) -> String {
    let bare = name.trim_start_matches('.');
    match part {
        Some(part) if !bare.contains('.') => format!("model.{part}.{bare}"),
        _ => format!("model.{bare}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::Source;

    #[test]
    fn objects_are_named_with_the_model_and_markers_with_their_part() {
        let text = "t\n!adams_view_name='link'\nPART/2, MASS=1\n!adams_view_name='tip'\nMARKER/20, PART=2\n\
            !adams_view_name='TR_Front.arm.tip'\nMARKER/21, PART=2\n!adams_view_name='hinge'\nJOINT/1, FIXED, I=20, J=21\nMARKER/22\n";
        let dataset = Dataset::parse(Source::new("a.adm", text.as_bytes())).value;
        let names = ObjectNames::of(&dataset);
        let at = |word: &str| {
            let span = Span::at(text.find(word).unwrap() + 3);
            let label = Label {
                file: "a.adm".into(),
                span,
                message: String::new(),
            };
            names.at(&label)
        };
        assert_eq!(at("PART/2"), Some("model.link"));
        assert_eq!(at("MARKER/20"), Some("model.link.tip"));
        assert_eq!(at("MARKER/21"), Some("model.TR_Front.arm.tip"));
        assert_eq!(at("JOINT/1"), Some("model.hinge"));
        assert_eq!(at("MARKER/22"), None);
    }
}
