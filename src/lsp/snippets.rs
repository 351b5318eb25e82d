//! Snippets of statements, made from the shipped example of each kind of statement, with its values as placeholders.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use admire_syntax::text::{Source, Span};
use admire_syntax::{Argument, CommandFile, Dataset, Statement};

macro_rules! examples {
    ($($file:literal)*) => {
        /// The shipped examples with their file names.
        pub(super) const EXAMPLES: &[(&str, &str)] = &[
            $(($file, include_str!(concat!("../../corpus/statements/", $file))),)*
        ];
    };
}

examples! {
    "accgrav.adm"
    "activate.acf"
    "array.adm"
    "beam.adm"
    "bushing.adm"
    "cbksub.adm"
    "clearance.adm"
    "contact.adm"
    "control.acf"
    "coupler.adm"
    "curve.adm"
    "cvcv.adm"
    "deactivate.acf"
    "debug.adm"
    "diff.adm"
    "end.adm"
    "environment.adm"
    "equilibrium.adm"
    "fe_load.adm"
    "fe_node.adm"
    "fe_part.adm"
    "femdata.adm"
    "field.adm"
    "file.acf"
    "flex_body.adm"
    "friction.adm"
    "gcon.adm"
    "gear.adm"
    "gforce.adm"
    "graphics.adm"
    "gse.adm"
    "help.acf"
    "ic.adm"
    "info.acf"
    "integrator.adm"
    "joint.adm"
    "jprim.adm"
    "kinematics.adm"
    "linear.acf"
    "list.adm"
    "lse.adm"
    "lsolver.adm"
    "marker.adm"
    "material.adm"
    "matrix.adm"
    "menu.acf"
    "mforce.adm"
    "motion.adm"
    "mrequest.adm"
    "nforce.adm"
    "nolist.adm"
    "output.adm"
    "part.adm"
    "pinput.adm"
    "point_mass.adm"
    "poutput.adm"
    "preferences.adm"
    "pstate.adm"
    "ptcv.adm"
    "reload.acf"
    "request.adm"
    "results.adm"
    "save.acf"
    "section.adm"
    "sensor.adm"
    "sforce.adm"
    "show.acf"
    "simulate.acf"
    "spline.adm"
    "springdamper.adm"
    "stop.acf"
    "string.adm"
    "surface.adm"
    "system.adm"
    "tfsiso.adm"
    "time.acf"
    "tire.adm"
    "title.adm"
    "ucon.adm"
    "units.adm"
    "variable.adm"
    "vforce.adm"
    "vtorque.adm"
}

/// Returns the snippet for a kind of statement, with `${1:ID}` in place of its id; `None` for a kind without an example.
pub(super) fn snippet(kind: &str) -> Option<&'static str> {
    static ALL: OnceLock<BTreeMap<String, String>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        EXAMPLES
            .iter()
            .filter_map(|(file, text)| of_example(file, text))
            .collect()
    });
    all.get(kind).map(String::as_str)
}

/// Returns the statement kind of an example and its statement as a snippet.
fn of_example(file: &str, text: &str) -> Option<(String, String)> {
    let (kind, extension) = file.rsplit_once('.')?;
    let kind = kind.to_uppercase();
    let source = Source::new(file, text.as_bytes());
    let is_kind = |statement: &&Statement| statement.kind() == Some(kind.as_str());
    let statements = if extension == "acf" {
        CommandFile::parse(source.clone()).value.commands().to_vec()
    } else {
        Dataset::parse(source.clone()).value.statements().to_vec()
    };
    let statement = statements.iter().find(is_kind)?;
    Some((kind.clone(), with_places(&kind, statement, &source)))
}

/// Returns the text of a statement in which placeholders replace the id and the values.
fn with_places(kind: &str, statement: &Statement, source: &Source) -> String {
    let mut out = kind.to_string();
    let mut at = statement.keyword.end();
    let mut count = 0;
    let mut place = |span: Span, shown: &str, out: &mut String, at: &mut usize| {
        count += 1;
        out.push_str(&escaped(&source.text(Span::new(*at, span.start()))));
        out.push_str(&format!("${{{count}:{}}}", escaped(shown)));
        *at = span.end();
    };
    if let Some((_, span)) = statement.id {
        place(span, "ID", &mut out, &mut at);
    }
    for argument in &statement.arguments {
        let span = Argument::value_span(argument);
        if !span.is_empty() && span.start() >= at {
            place(span, &source.text(span), &mut out, &mut at);
        }
    }
    out.push_str(&escaped(
        &source.text(Span::new(at, statement.span.end().max(at))),
    ));
    out
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\")
        .replace('$', "\\$")
        .replace('}', "\\}")
        .replace('\r', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_example_is_a_snippet() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../corpus/statements");
        let entries = std::fs::read_dir(folder).expect("a folder").flatten();
        let mut there: Vec<String> = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        there.sort();
        let listed: Vec<&str> = EXAMPLES.iter().map(|(file, _)| *file).collect();
        assert_eq!(listed, there);
        let bushing = snippet("BUSHING").expect("there");
        assert!(
            bushing.starts_with(
                "BUSHING/${1:ID}\n, I = ${2:20}\n, J = ${3:10}\n, K = ${4:5350, 5350, 3320}"
            ),
            "{bushing}"
        );
        assert!(snippet("SIMULATE").is_some());
    }
}
