//! Resolution of the names in a study's files to indices of the model and of the load cases.

use std::collections::BTreeMap;

use super::available::Available;
use super::kc_readings::kc_readings;
use super::measurement::{
    Case, Channel, Grouped, MarkReading, MarkedPart, Measurement, PartMark, Reference,
};
use super::part_name::part;
use super::rows::{case_of, label_of, labels, point};
use super::section::{did_you_mean, nearest};
use super::settings::ChannelSettings;
use super::study::{MarkFiles, Study};
use super::summary_readings::summaries;
use super::table::{Cell, Table};
use super::wheel_readings::wheel_readings;
use admire_solver::model::{Model, PartIx};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Returns the measurement of a study, with all names in its files resolved. Readings with unknown names are reported and left out.
pub fn measurement(study: &Study, model: &Model, out: &mut Vec<Diagnostic>) -> Measurement {
    let cases = load_cases(study, out);
    let mut measured = Measurement {
        cases,
        parts: Vec::new(),
        sigma: 0.0,
        sigma_estimated: false,
        sigma_on_parts: 0.0,
        wheel: None,
        channels: Vec::new(),
        available: Available::of(study, model, out),
    };
    if let Some(marks) = &study.marks {
        measured.sigma = marks.sigma.unwrap_or(0.0);
        measured.sigma_estimated = marks.sigma.is_none();
        measured.sigma_on_parts = marks.sigma_on_parts;
        on_parts(marks, model, &mut measured, out);
        mark_readings(marks, model, &mut measured, out);
    }
    wheel_readings(study, model, &mut measured, out);
    if let Some((table, channels)) = &study.readings {
        channel_readings(study, table, channels, &mut measured, out);
    }
    if let Some((settings, table)) = &study.kc {
        kc_readings(study, model, settings, table, &mut measured, out);
    }
    if let (Some((settings, _)), Some(table)) = (&study.kc, &study.kc_summary) {
        summaries(study, model, settings, table, &mut measured, out);
    }
    hold_out(study, &mut measured, out);
    measured
}

fn load_cases(study: &Study, out: &mut Vec<Diagnostic>) -> Vec<Case> {
    let table = &study.loads;
    let file = table.source.name();
    let mut cases: Vec<Case> = Vec::new();
    if study.columns.is_empty() {
        out.push(
            Diagnostic::error(Code::MissingSetting, "`loads.columns` names no load")
                .label(study.source.name(), admire_syntax::text::Span::at(0), "")
                .help("for example columns = { vertical = \"SFORCE/3\" }"),
        );
    }
    let label = table.column("case");
    if label.is_none() && table.has_slip("case") {
        let _ = table.columns(["case"], out);
        return cases;
    }
    if let Some(label) = label {
        table.only(label, out);
    }
    let mut columns = Vec::new();
    for (name, _) in &study.columns {
        let Some(column) = table.column(&name.text) else {
            out.push(
                Diagnostic::error(
                    Code::MissingColumn,
                    format!("the load cases have no column `{}`", name.text),
                )
                .label(study.source.name(), name.span, "asked for here")
                .label(file, table.header_span(), "the header line")
                .help(did_you_mean(&name.text, "the header line", &table.header())),
            );
            return cases;
        };
        table.only(column, out);
        columns.push(column);
    }
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    for (number, row) in table.rows().iter().enumerate() {
        let place = table.row_span(row);
        let Some(label) = label_of(table, row, label, number) else {
            out.push(
                Diagnostic::error(
                    Code::BadReading,
                    "this load case has no label in the column `case`",
                )
                .label(file, place, ""),
            );
            continue;
        };
        let mut loads = Vec::with_capacity(columns.len());
        for &column in &columns {
            let value = table.cell(row, column).and_then(|cell| table.value(cell));
            let Some(value) = value else {
                let cell = table.cell(row, column);
                if cell.is_some_and(|cell| table.complain_of_point(cell, out)) {
                    continue;
                }
                let at = row.get(column).map_or(place, |cell| cell.span);
                out.push(
                    Diagnostic::error(
                        Code::BadReading,
                        format!(
                            "load case `{}` has no number in the column `{}`",
                            label.text,
                            table.header_cells()[column].text
                        ),
                    )
                    .label(file, at, ""),
                );
                continue;
            };
            loads.push(value);
        }
        if loads.len() < columns.len() {
            continue;
        }
        if let Some(&first) = places.get(&label.text) {
            let same = cases[first].loads == loads;
            let what = if same {
                Diagnostic::warning(
                    Code::DuplicateCase,
                    format!(
                        "load case `{}` is listed twice; it is applied once",
                        label.text
                    ),
                )
            } else {
                Diagnostic::error(
                    Code::DuplicateCase,
                    format!(
                        "two load cases are called `{}` and their loads differ",
                        label.text
                    ),
                )
                .help("give every load case its own label, in the load cases and in the readings")
            };
            out.push(what.label(file, place, "the second one").label(
                file,
                cases[first].place,
                "the first one",
            ));
            continue;
        }
        places.insert(label.text.clone(), cases.len());
        cases.push(Case {
            label: label.text.clone(),
            loads,
            marks: Vec::new(),
            wheel: None,
            channels: Vec::new(),
            held_out: false,
            place,
        });
    }
    if cases.is_empty() {
        out.push(
            Diagnostic::error(Code::BadReading, "the file holds no load case").label(
                file,
                table.header_span(),
                "",
            ),
        );
    }
    cases
}

fn resolve_part(
    cell: &Cell,
    table: &Table,
    model: &Model,
    grouped: &mut Grouped,
) -> Option<PartIx> {
    let found = part(&cell.text, model);
    if found.is_none() {
        grouped.add(format!("part {}", cell.text), || {
            let message = format!("the deck has no part `{}`", cell.text);
            let diagnostic = Diagnostic::error(Code::UnknownPart, message).label(
                table.source.name(),
                cell.span,
                "",
            );
            let names = model.parts.iter().map(|part| part.header.name.as_str());
            match nearest(&cell.text, names) {
                Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
                None => diagnostic
                    .help("name a part by its id (4), its address (PART/4) or its Adams/View name"),
            }
        });
    }
    found
}

fn on_parts(marks: &MarkFiles, model: &Model, to: &mut Measurement, out: &mut Vec<Diagnostic>) {
    let table = &marks.on_parts;
    let Some([part, mark, x, y, z]) = table.columns(["part", "mark", "x", "y", "z"], out) else {
        return;
    };
    let mut grouped = Grouped::default();
    for row in table.rows() {
        let (Some(part), Some(mark)) = (table.cell(row, part), table.cell(row, mark)) else {
            continue;
        };
        let Some(found) = resolve_part(part, table, model, &mut grouped) else {
            continue;
        };
        let Some(p) = point(table, row, [x, y, z], out) else {
            continue;
        };
        let at = to.parts.iter().position(|marked| marked.part == found);
        let at = at.unwrap_or_else(|| {
            let header = &model.parts[found.0].header;
            to.parts.push(MarkedPart {
                part: found,
                id: header.id,
                name: header.name.clone(),
                marks: Vec::new(),
            });
            to.parts.len() - 1
        });
        let marks = &mut to.parts[at].marks;
        if let Some(first) = marks.iter().find(|first| first.label == mark.text) {
            let message = format!("mark {} of {} is listed twice", mark.text, part.text);
            let diagnostic = if first.p == p {
                Diagnostic::warning(Code::DuplicateReading, message)
            } else {
                Diagnostic::error(
                    Code::DuplicateReading,
                    message + " with different coordinates",
                )
            };
            out.push(diagnostic.label(table.source.name(), table.row_span(row), ""));
            continue;
        }
        marks.push(PartMark {
            label: mark.text.clone(),
            p,
        });
    }
    grouped.finish(out);
}

fn mark_readings(
    marks: &MarkFiles,
    model: &Model,
    to: &mut Measurement,
    out: &mut Vec<Diagnostic>,
) {
    let table = &marks.measured;
    let names = ["case", "part", "mark", "x", "y", "z"];
    let Some([case, part, mark, x, y, z]) = table.columns(names, out) else {
        return;
    };
    let file = table.source.name();
    let mut grouped = Grouped::default();
    let mut read: BTreeMap<(usize, usize, usize), MarkReading> = BTreeMap::new();
    let mut spoilt = Vec::new();
    for row in table.rows() {
        let cells = [case, part, mark].map(|column| table.cell(row, column));
        let [Some(case), Some(part), Some(mark)] = cells else {
            out.push(
                Diagnostic::warning(
                    Code::BadReading,
                    "a reading without case, part or mark is left out",
                )
                .label(file, table.row_span(row), ""),
            );
            continue;
        };
        let Some(case) = case_of(case, table, to, &mut grouped) else {
            continue;
        };
        let Some(found) = resolve_part(part, table, model, &mut grouped) else {
            continue;
        };
        let marked = to.parts.iter().position(|marked| marked.part == found);
        let known = marked.and_then(|at| {
            let label = |m: &PartMark| m.label == mark.text;
            Some((at, to.parts[at].marks.iter().position(label)?))
        });
        let Some((part_at, mark_at)) = known else {
            grouped.add(format!("mark {} {}", part.text, mark.text), || {
                let message = format!(
                    "mark `{}` of {} is not in the table of marks on parts; its readings are left out",
                    mark.text, part.text
                );
                Diagnostic::warning(Code::UnknownMark, message).label(file, mark.span, "")
            });
            continue;
        };
        let Some(x) = point(table, row, [x, y, z], out) else {
            continue;
        };
        let place = table.row_span(row);
        let reading = MarkReading {
            part: part_at,
            mark: mark_at,
            x,
            place,
        };
        let key = (case, part_at, mark_at);
        let Some(first) = read.get(&key).copied() else {
            read.insert(key, reading);
            continue;
        };
        let same = first.x == x;
        if !same {
            spoilt.push(key);
        }
        let message = format!(
            "mark {} of {} is read twice in case {}; {}",
            mark.text,
            part.text,
            to.cases[case].label,
            if same {
                "the second reading is left out"
            } else {
                "both readings are left out"
            }
        );
        out.push(
            Diagnostic::warning(Code::DuplicateReading, message)
                .label(file, place, "the second reading")
                .label(file, first.place, "the first reading"),
        );
    }
    for key in spoilt {
        read.remove(&key);
    }
    for ((case, ..), reading) in read {
        to.cases[case].marks.push(reading);
    }
    grouped.finish(out);
}

fn channel_readings(
    study: &Study,
    table: &Table,
    channels: &[ChannelSettings],
    to: &mut Measurement,
    out: &mut Vec<Diagnostic>,
) {
    // A channel is added even if its readings are missing, because a virtual rig may produce them.
    let label = table.columns(["case"], out);
    let mut columns = Vec::new();
    for settings in channels {
        let column = table.column(&settings.name);
        if let Some(column) = column {
            table.only(column, out);
        }
        if column.is_none() && label.is_some() {
            out.push(
                Diagnostic::error(
                    Code::MissingColumn,
                    format!("the readings have no column `{}`", settings.name),
                )
                .label(table.source.name(), table.header_span(), "the header line")
                .help(did_you_mean(
                    &settings.name,
                    "the header line",
                    &table.header(),
                )),
            );
        }
        let mut relative_to = None;
        if let Some(label) = &settings.relative_to {
            relative_to = to.case(&label.text).map(Reference::Case);
            if relative_to.is_none() && label.text == "previous" {
                relative_to = Some(Reference::Previous);
            }
            if relative_to.is_none() {
                out.push(
                    Diagnostic::error(
                        Code::UnknownCase,
                        format!("there is no load case `{}`", label.text),
                    )
                    .label(study.source.name(), label.span, "")
                    .help(did_you_mean(
                        &label.text,
                        "the file of load cases",
                        &labels(to),
                    )),
                );
            }
        }
        columns.push(column);
        to.channels.push(Channel {
            name: settings.name.clone(),
            column: (settings.name.clone(), 1.0),
            function: settings.function.text.clone(),
            helpers: Vec::new(),
            sigma: settings.sigma.unwrap_or(1.0),
            sigma_estimated: settings.sigma.is_none(),
            unit: settings.unit.clone(),
            relative_to,
            summary: None,
            held_out: false,
        });
    }
    for case in &mut to.cases {
        case.channels = vec![None; columns.len()];
    }
    let Some([case]) = label else {
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
        for (channel, column) in columns.iter().enumerate() {
            to.cases[case].channels[channel] =
                column.and_then(|column| table.number(row, column, out));
            let counts_from = to.channels[channel].relative_to;
            if case == 0 && counts_from == Some(Reference::Previous) {
                to.cases[case].channels[channel] = None;
                grouped.add(format!("first case {channel}"), || {
                    let name = &to.channels[channel].name;
                    Diagnostic::warning(
                        Code::BadReading,
                        format!("channel `{name}` is relative to the previous case, but the first case has none"),
                    )
                    .label(table.source.name(), table.row_span(row), "this reading is left out")
                });
            }
        }
    }
    for (k, channel) in to.channels.iter_mut().enumerate() {
        let readings = to.cases.iter().filter_map(|case| case.channels[k]);
        let (count, sum) = readings.fold((0, 0.0), |(n, sum), x| (n + 1, sum + x * x));
        if channel.sigma_estimated && sum > 0.0 {
            channel.sigma = 0.1 * (sum / f64::from(count)).sqrt();
        }
    }
    grouped.finish(out);
}

fn hold_out(study: &Study, to: &mut Measurement, out: &mut Vec<Diagnostic>) {
    for label in study.hold_out.iter().flatten() {
        let curve = to
            .channels
            .iter()
            .position(|channel| channel.name == label.text);
        match (to.case(&label.text), curve) {
            (Some(case), _) => to.cases[case].held_out = true,
            (None, Some(channel)) => to.channels[channel].held_out = true,
            (None, None) => {
                let mut known = labels(to);
                known.extend(to.channels.iter().map(|channel| channel.name.clone()));
                let message = format!(
                    "`{}` cannot be held out: it is neither a load case nor a channel",
                    label.text
                );
                let warning = Diagnostic::warning(Code::UnknownCase, message);
                let found = did_you_mean(&label.text, "the study", &known);
                out.push(
                    warning
                        .label(study.source.name(), label.span, "")
                        .help(found),
                );
            }
        }
    }
}
