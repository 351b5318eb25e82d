//! Readings of a kinematics and compliance (K&C) rig. Columns are found by name and unit. Repeated rows of a case are averaged, and their
//! scatter gives the noise.

use super::kc_curves::{CurveSettings, Gauge, KcSettings, column, factor, name_and_unit};
use super::measurement::Grouped;
use super::measurement::{Channel, Measurement, Reference};
use super::rows::{case_of, label_of, labels};
use super::section::{SpannedText, did_you_mean};
use super::study::Study;
use super::table::Table;
use super::wheel_readings::marker_of;
use admire_solver::model::Model;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Minimum number of degrees of freedom of repeated readings from which the noise of a channel is estimated.
const ENOUGH: usize = 4;

/// Column of the file that a channel is read from, with the factor from the unit of the column to the unit of the channel.
struct Source {
    channel: usize,
    column: usize,
    factor: f64,
}

/// Adds the channels of section `[kc]` and their readings to the measurement.
pub(super) fn kc_readings(
    study: &Study,
    model: &Model,
    settings: &KcSettings,
    table: &Table,
    to: &mut Measurement,
    out: &mut Vec<Diagnostic>,
) {
    let first = to.channels.len();
    let (mut sources, mut told) = (Vec::new(), Vec::new());
    for curve in &settings.curves {
        let of = (settings, curve);
        sources.extend(channel(study, model, of, table, (to, &mut told), out));
    }
    if !told.is_empty() {
        let text = format!("curves of the rig: {}", told.join("; "));
        let note = Diagnostic::note(Code::KcCurves, text);
        out.push(note.label(table.source.name(), table.header_span(), ""));
    }
    let count = to.channels.len() - first;
    for case in &mut to.cases {
        case.channels.resize(first + count, None);
    }
    let label = table.column("case");
    for column in label.into_iter().chain(sources.iter().map(|s| s.column)) {
        table.only(column, out);
    }
    if to.cases.is_empty() {
        // Errors in the load cases have been reported already.
        return;
    }
    if label.is_none() && table.rows().len() != to.cases.len() && !table.rows().is_empty() {
        let message = format!(
            "the number of rows ({}) differs from the number of load cases ({}), and there is no column `case`",
            table.rows().len(),
            to.cases.len()
        );
        out.push(
            Diagnostic::error(Code::MissingColumn, message)
                .label(table.source.name(), table.header_span(), "the header line")
                .help("write one row per load case in the order of the load cases, or add a column `case` with their labels"),
        );
        return;
    }
    let mut grouped = Grouped::default();
    let mut read: Vec<Vec<Vec<f64>>> = vec![vec![Vec::new(); to.cases.len()]; sources.len()];
    for (number, row) in table.rows().iter().enumerate() {
        let case = if label.is_some() {
            label_of(table, row, label, number)
                .and_then(|label| case_of(&label, table, to, &mut grouped))
        } else {
            Some(number)
        };
        let Some(case) = case else { continue };
        for (source, read) in sources.iter().zip(&mut read) {
            if let Some(value) = table.number(row, source.column, out) {
                read[case].push(value * source.factor);
            }
        }
    }
    for (source, read) in sources.iter().zip(&read) {
        let (mut squares, mut dof, mut most) = (0.0, 0, 1);
        for (case, values) in read
            .iter()
            .enumerate()
            .filter(|(_, values)| !values.is_empty())
        {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            squares += values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            dof += values.len() - 1;
            most = most.max(values.len());
            to.cases[case].channels[source.channel] = Some(mean);
        }
        let channel = &mut to.channels[source.channel];
        if !channel.sigma_estimated {
            continue;
        }
        if dof >= ENOUGH && squares > 0.0 {
            // The reading is the mean over the repeats, so sigma is the standard deviation of this mean.
            channel.sigma = (squares / (dof * most) as f64).sqrt();
            channel.sigma_estimated = false;
        } else {
            let all: Vec<f64> = read.iter().flatten().copied().collect();
            let square = all.iter().map(|x| x * x).sum::<f64>() / all.len().max(1) as f64;
            channel.sigma = if square > 0.0 {
                0.1 * square.sqrt()
            } else {
                1.0
            };
        }
    }
    grouped.finish(out);
}

/// Adds the channel of one curve to the measurement, and returns the column to read. If the file has no such column, the channel is added
/// without readings, because a virtual rig may produce them.
fn channel(
    study: &Study,
    model: &Model,
    (settings, curve): (&KcSettings, &CurveSettings),
    table: &Table,
    (to, told): (&mut Measurement, &mut Vec<String>),
    out: &mut Vec<Diagnostic>,
) -> Option<Source> {
    let marker = marker_of(
        study,
        curve.marker.as_ref().unwrap_or(&settings.marker),
        model,
        out,
    )?;
    let Some(gauge) = Gauge::new(model, marker, settings.axis, settings.forward) else {
        let message = "the deck does not fix the position of this marker, so the wheel cannot be measured there".to_string();
        let span = settings.marker.span;
        out.push(Diagnostic::error(Code::UnknownTarget, message).label(
            study.source.name(),
            span,
            "",
        ));
        return None;
    };
    let relative_to = curve.relative_to.as_ref().or(settings.relative_to.as_ref());
    let relative_to = relative_to.and_then(|label| zero(study, label, to, out));
    let angle = curve.curve.is_angle();
    let at = column(table, curve);
    if at.is_none() && !table.header().is_empty() {
        let asked = curve.column.as_ref().unwrap_or(&curve.name);
        let message = format!("the K&C file has no column for `{}`", asked.text);
        out.push(
            Diagnostic::error(Code::MissingColumn, message)
                .label(study.source.name(), asked.span, "")
                .label(table.source.name(), table.header_span(), "the header line")
                .help(format!(
                    "{}; state the column as `{} = {{ column = \"...\" }}`, or remove the curve from [kc.curves]",
                    did_you_mean(&asked.text, "the header line", &table.header()),
                    curve.name.text
                )),
        );
    }
    let asked = &curve.column.as_ref().unwrap_or(&curve.name).text;
    let header = at.map_or_else(|| asked.clone(), |at| table.header()[at].clone());
    let spelled = name_and_unit(&header).1;
    let unit = curve
        .unit
        .as_ref()
        .map(|unit| unit.text.as_str())
        .or(spelled);
    let millimetre = if angle {
        1.0
    } else {
        1e-3 / model.units.length.si
    };
    let factor = match unit.map(|unit| factor(unit, angle)) {
        Some(Some(factor)) => factor * millimetre,
        Some(None) => {
            let what = if angle {
                "angle: write deg, min, rad or mrad"
            } else {
                "length: write mm, cm, m or in"
            };
            let message = format!("`{}` is not a unit of {what}", unit.unwrap_or_default());
            let place = curve.unit.as_ref().unwrap_or(&curve.name).span;
            out.push(Diagnostic::error(Code::BadSetting, message).label(
                study.source.name(),
                place,
                "",
            ));
            return None;
        }
        None => 1.0,
    };
    let factor = if curve.reversed { -factor } else { factor };
    let channel = to.channels.len();
    to.channels.push(Channel {
        name: curve.name.text.clone(),
        column: (header.clone(), factor),
        function: gauge.function(curve.curve),
        helpers: gauge.helpers().to_vec(),
        sigma: curve.sigma.map_or(1.0, |sigma| sigma * factor.abs()),
        sigma_estimated: curve.sigma.is_none(),
        unit: Some(
            if angle {
                "deg"
            } else {
                model.units.length.word
            }
            .to_string(),
        ),
        relative_to,
        summary: None,
        held_out: false,
    });
    let at = at?;
    let shown = match unit {
        Some(unit) => unit,
        None if angle => "deg",
        None => "the deck's length unit",
    };
    let name = &curve.name.text;
    let reversed = if curve.reversed {
        " once its sign is changed"
    } else {
        ""
    };
    told.push(format!(
        "{name} from `{header}` in {shown}, {}{reversed}",
        curve.curve.sign_convention()
    ));
    Some(Source {
        channel,
        column: at,
        factor,
    })
}

/// Returns the case that serves as zero reference of a curve, or reports that `label` names no case.
fn zero(
    study: &Study,
    label: &SpannedText,
    to: &Measurement,
    out: &mut Vec<Diagnostic>,
) -> Option<Reference> {
    let found = to.case(&label.text).map(Reference::Case);
    if found.is_none() {
        let message = format!("there is no load case `{}`", label.text);
        out.push(
            Diagnostic::error(Code::UnknownCase, message)
                .label(study.source.name(), label.span, "")
                .help(did_you_mean(
                    &label.text,
                    "the file of load cases",
                    &labels(to),
                )),
        );
    }
    found
}
