//! Conversion of the load cases of a study to a load programme for a solver backend.

use super::measurement::Measurement;
use super::section::did_you_mean;
use super::study::Study;
use admire_session::backend::{Load, LoadCase, LoadProgramme};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Address, Dataset};

/// Returns the load programme of a study: the target of each load column in the deck, and the load values of each case of the measurement.
///
/// A column whose target does not exist in the deck is reported as an error. Columns whose names end in `_deg` are in degrees and are converted
/// to radians.
pub fn programme(
    study: &Study,
    dataset: &Dataset,
    measurement: &Measurement,
    out: &mut Vec<Diagnostic>,
) -> LoadProgramme {
    let mut loads = Vec::new();
    let mut factors = Vec::new();
    for (name, target) in &study.columns {
        let found = Address::parse(&target.text, dataset).ok();
        let Some(target) = found.filter(|address| exists(address, dataset)) else {
            let help = suggestion(&target.text, dataset);
            let message = format!("the deck has no `{}` that a load can drive", target.text);
            out.push(
                Diagnostic::error(Code::UnknownTarget, message)
                    .label(study.source.name(), target.span, "")
                    .help(help),
            );
            continue;
        };
        factors.push(if name.text.ends_with("_deg") {
            1f64.to_radians()
        } else {
            1.0
        });
        loads.push(Load {
            name: name.text.clone(),
            target,
        });
    }
    let cases = measurement.cases.iter().map(|case| LoadCase {
        label: case.label.clone(),
        values: case
            .loads
            .iter()
            .zip(&factors)
            .map(|(value, factor)| value * factor)
            .collect(),
    });
    LoadProgramme {
        cases: cases.collect(),
        loads,
    }
}

/// Returns a hint for the user that names valid targets of loads in this deck.
fn suggestion(text: &str, dataset: &Dataset) -> String {
    let driven: Vec<String> = dataset
        .statements()
        .iter()
        .filter(|statement| statement.argument("FUNCTION").is_some())
        .filter_map(|statement| {
            let kind = statement.kind()?;
            let (id, _) = statement.id?;
            (kind != "REQUEST").then(|| format!("{kind}/{id}"))
        })
        .collect();
    let example = "SFORCE/3, GFORCE/1.FX, MOTION/1, VARIABLE/5 or MARKER/19.QP.1";
    if driven.is_empty() {
        return format!("for example {example}");
    }
    let meant = did_you_mean(
        text,
        "among its statements with a FUNCTION, the deck",
        &driven,
    );
    format!("{meant}; a load is for example {example}")
}

fn exists(address: &Address, dataset: &Dataset) -> bool {
    dataset
        .statement(&address.kind, address.id)
        .is_some_and(|statement| match &address.argument {
            Some(argument) => statement.argument(argument).is_some(),
            None => statement.argument("FUNCTION").is_some(),
        })
}
