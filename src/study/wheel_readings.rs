//! Readings of section `[wheel]`: the wheel marker, and the position and angles of the wheel in each load case.

use super::measurement::{Grouped, Measurement, Wheel, wheel};
use super::rows::{case_of, point};
use super::section::{SpannedText, did_you_mean};
use super::study::Study;
use super::wheel::WheelReading;
use admire_solver::model::{MarkerIx, Model};
use admire_syntax::diagnostic::{Code, Diagnostic};

pub(super) fn wheel_readings(
    study: &Study,
    model: &Model,
    to: &mut Measurement,
    out: &mut Vec<Diagnostic>,
) {
    let Some((settings, table)) = &study.wheel else {
        return;
    };
    let Some(marker) = marker_of(study, &settings.marker, model, out) else {
        return;
    };
    let resolved: Wheel = wheel(settings, marker, model);
    to.wheel = Some(resolved);
    let Some(table) = table else { return };
    let names = ["case", "x", "y", "z", "camber_deg", "steer_deg"];
    let Some([case, x, y, z, camber, steer]) = table.columns(names, out) else {
        return;
    };
    let mut grouped = Grouped::default();
    for row in table.rows() {
        let Some(label) = table.cell(row, case) else {
            continue;
        };
        let Some(case) = case_of(label, table, to, &mut grouped) else {
            continue;
        };
        let position = point(table, row, [x, y, z], out);
        let angles = [camber, steer].map(|column| table.number(row, column, out));
        let (Some(position), [Some(camber_deg), Some(steer_deg)]) = (position, angles) else {
            grouped.add("wheel row".to_string(), || {
                Diagnostic::warning(
                    Code::BadReading,
                    format!(
                        "the wheel reading of case {} is incomplete and left out",
                        label.text
                    ),
                )
                .label(table.source.name(), table.row_span(row), "")
            });
            continue;
        };
        to.cases[case].wheel = Some(WheelReading {
            position,
            camber_deg,
            steer_deg,
        });
    }
    grouped.finish(out);
}

/// Returns the marker that a study names, or reports that the deck has no such marker.
pub(super) fn marker_of(
    study: &Study,
    name: &SpannedText,
    model: &Model,
    out: &mut Vec<Diagnostic>,
) -> Option<MarkerIx> {
    let found = marker(&name.text, model);
    if found.is_none() {
        let message = format!("the deck has no marker `{}`", name.text);
        let there: Vec<String> = model
            .markers
            .iter()
            .flat_map(|marker| {
                [
                    format!("MARKER/{}", marker.header.id),
                    marker.header.name.clone(),
                ]
            })
            .filter(|name| !name.is_empty())
            .collect();
        let complaint = Diagnostic::error(Code::UnknownTarget, message)
            .label(study.source.name(), name.span, "")
            .help(did_you_mean(&name.text, "the deck", &there));
        // Several curves may name the same marker.
        if !out.contains(&complaint) {
            out.push(complaint);
        }
    }
    found
}

/// Returns the marker with this address (such as `MARKER/20`), id or view name.
fn marker(name: &str, model: &Model) -> Option<MarkerIx> {
    let name = name.trim();
    let id = name.split_once('/').map_or(name, |(_, id)| id).trim();
    match id.parse::<u32>() {
        Ok(id) => model.marker(id),
        Err(_) => model
            .markers
            .iter()
            .position(|marker| marker.header.name == name)
            .map(MarkerIx),
    }
}
