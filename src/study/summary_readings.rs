//! The table of gradients and loop widths of a study. Its rows become channels of the measurement; a virtual rig writes the table with new
//! values.

use super::kc_curves::{Curve, Gauge, KcSettings, factor};
use super::measurement::{Channel, Measurement};
use super::rows::labels;
use super::section::did_you_mean;
use super::study::Study;
use super::summary::{Over, Summary, SummaryKind, weights};
use super::table::{Cell, Table};
use super::wheel_readings::marker_of;
use admire_solver::model::Model;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Required columns of the table of gradients and loop widths.
const COLUMNS: [&str; 8] = [
    "name", "curve", "kind", "over", "from", "to", "value", "sigma",
];

/// Adds one channel with its reading to the measurement for each row of the table of gradients and loop widths.
pub(super) fn summaries(
    study: &Study,
    model: &Model,
    settings: &KcSettings,
    table: &Table,
    to: &mut Measurement,
    out: &mut Vec<Diagnostic>,
) {
    let Some(columns) = table.columns(COLUMNS, out) else {
        return;
    };
    let Some(marker) = marker_of(study, &settings.marker, model, &mut Vec::new()) else {
        return;
    };
    let Some(gauge) = Gauge::new(model, marker, settings.axis, settings.forward) else {
        return;
    };
    let (unit, per, at) = (
        table.column("unit"),
        table.column("per"),
        table.column("at"),
    );
    for column in [unit, per, at].into_iter().flatten() {
        table.only(column, out);
    }
    for row in table.rows() {
        let read = Row {
            study,
            table,
            cells: row,
            columns,
            model,
        };
        let number = |column: Option<usize>, or: f64, out: &mut Vec<Diagnostic>| {
            column
                .and_then(|column| table.number(row, column, out))
                .unwrap_or(or)
        };
        let (per, at) = (number(per, 1.0, out), number(at, 0.0, out));
        let unit = unit.and_then(|column| table.cell(row, column));
        if let Err(wrong) = read.add(&gauge, (per, at, unit), to, out) {
            out.push(wrong);
        }
    }
}

struct Row<'a> {
    study: &'a Study,
    table: &'a Table,
    cells: &'a [Cell],
    columns: [usize; 8],
    model: &'a Model,
}

impl Row<'_> {
    fn cell(&self, column: usize) -> Result<&Cell, Diagnostic> {
        let found = self.table.cell(self.cells, self.columns[column]);
        found.ok_or_else(|| {
            let message = format!("this row has no `{}`", COLUMNS[column]);
            let span = self.table.row_span(self.cells);
            Diagnostic::error(Code::BadReading, message).label(self.table.source.name(), span, "")
        })
    }

    fn wrong(&self, cell: &Cell, message: String, help: String) -> Diagnostic {
        let wrong = Diagnostic::error(Code::BadReading, message);
        wrong
            .label(self.table.source.name(), cell.span, "")
            .help(help)
    }

    fn add(
        &self,
        gauge: &Gauge,
        (per, at, unit): (f64, f64, Option<&Cell>),
        to: &mut Measurement,
        out: &mut Vec<Diagnostic>,
    ) -> Result<(), Diagnostic> {
        let curve = self.curve(self.cell(1)?)?;
        let kind = self.cell(2)?;
        let kind = match kind.text.as_str() {
            "gradient" => SummaryKind::Gradient,
            "width" => SummaryKind::Width(at),
            other => {
                let message = format!("`{other}` is neither `gradient` nor `width`");
                let help =
                    "`gradient` is the slope of a curve, `width` the width of its loop".to_string();
                return Err(self.wrong(kind, message, help));
            }
        };
        let case = |cell: &Cell| {
            to.case(&cell.text).ok_or_else(|| {
                let message = format!("there is no load case `{}`", cell.text);
                let help = did_you_mean(&cell.text, "the file of load cases", &labels(to));
                self.wrong(cell, message, help)
            })
        };
        let (from, last) = (case(self.cell(4)?)?, case(self.cell(5)?)?);
        let cases: Vec<usize> = (from..=last).collect();
        let over = self.cell(3)?;
        let load = self
            .study
            .columns
            .iter()
            .position(|(n, _)| n.text == over.text);
        let over_cell = over;
        let over = match load {
            Some(load) => Over::Load(cases.iter().map(|c| to.cases[*c].loads[load]).collect()),
            None => Over::Channel(self.other(over, gauge, to)?),
        };
        let usable = match (&kind, &over) {
            (SummaryKind::Width(at), Over::Load(x)) => weights(x, *at).is_some(),
            (SummaryKind::Width(_), Over::Channel(_)) => false,
            (SummaryKind::Gradient, Over::Load(x)) => x.iter().any(|v| *v != x[0]),
            (SummaryKind::Gradient, Over::Channel(_)) => cases.len() > 1,
        };
        if !usable {
            let column = &over_cell.text;
            let message = match (&kind, &over) {
                (SummaryKind::Gradient, _) => {
                    format!("`{column}` does not change from the first to the last of these cases")
                }
                (SummaryKind::Width(_), Over::Load(_)) => {
                    format!(
                        "the load `{column}` does not cross the value in both directions within these cases"
                    )
                }
                (SummaryKind::Width(_), Over::Channel(_)) => {
                    format!("`{column}` is not a load, and the width of a loop needs a load")
                }
            };
            let help = "`over` names a column of the load cases; `from` and `to` are the first and the last case of the run";
            return Err(self.wrong(over_cell, message, help.to_string()));
        }
        let (angle, millimetre) = (curve.is_angle(), 1e-3 / self.model.units.length.si);
        let scale = match unit {
            None => 1.0,
            Some(cell) => {
                let own = factor(&cell.text, angle).ok_or_else(|| {
                    let message = format!("`{}` is not a unit of this curve", cell.text);
                    let help = "an angle: deg, min, rad, mrad; a length: mm, cm, m, in".to_string();
                    self.wrong(cell, message, help)
                })?;
                own * if angle { 1.0 } else { millimetre }
            }
        };
        let sigma = self.table.number(self.cells, self.columns[7], out);
        let Some(sigma) = sigma.filter(|sigma| *sigma > 0.0) else {
            let cell = self.cell(7)?;
            let message = "`sigma` must be more than 0".to_string();
            return Err(self.wrong(
                cell,
                message,
                "`sigma` is the standard deviation of the value".to_string(),
            ));
        };
        let name = self.cell(0)?;
        if to.channels.iter().any(|channel| channel.name == name.text) {
            let message = format!("the name `{}` is already used", name.text);
            return Err(self.wrong(
                name,
                message,
                "give every gradient and width its own name".to_string(),
            ));
        }
        // The cell of the value may be empty, because a virtual rig may produce the value.
        let value = self.table.number(self.cells, self.columns[6], out);
        self.push(to, &name.text, gauge.function(curve), gauge);
        let channel = to.channels.last_mut().expect("just pushed");
        channel.column = (name.text.clone(), scale);
        channel.sigma = sigma * scale;
        let own = if angle {
            "deg"
        } else {
            self.model.units.length.word
        };
        channel.unit = Some(own.to_string());
        channel.summary = Some(Summary {
            kind,
            over,
            cases,
            per,
        });
        let at = to.channels.len() - 1;
        to.cases[last].channels[at] = value.map(|value| value * scale);
        Ok(())
    }

    fn curve(&self, cell: &Cell) -> Result<Curve, Diagnostic> {
        Curve::named(&cell.text).ok_or_else(|| {
            let message = format!("`{}` is not a curve", cell.text);
            let help = format!("the curves are {}", Curve::words().join(", "));
            self.wrong(cell, message, help)
        })
    }

    /// Returns the channel of the curve that serves as abscissa. If no channel measures this curve, a channel without readings is added.
    fn other(&self, cell: &Cell, gauge: &Gauge, to: &mut Measurement) -> Result<usize, Diagnostic> {
        let curve = Curve::named(&cell.text).ok_or_else(|| {
            let loads = self.study.columns.iter().map(|(n, _)| n.text.as_str());
            let known: Vec<&str> = loads.chain(Curve::words()).collect();
            let message = format!("`{}` is neither a load nor a curve", cell.text);
            self.wrong(
                cell,
                message,
                format!("the loads and curves are {}", known.join(", ")),
            )
        })?;
        let function = gauge.function(curve);
        let same =
            |c: &Channel| c.function == function && c.summary.is_none() && c.relative_to.is_none();
        if let Some(at) = to.channels.iter().position(same) {
            return Ok(at);
        }
        self.push(to, "", function, gauge);
        Ok(to.channels.len() - 1)
    }

    fn push(&self, to: &mut Measurement, name: &str, function: String, gauge: &Gauge) {
        to.channels.push(Channel {
            name: name.to_string(),
            column: (String::new(), 1.0),
            function,
            helpers: gauge.helpers().to_vec(),
            sigma: 1.0,
            sigma_estimated: false,
            unit: None,
            relative_to: None,
            summary: None,
            held_out: false,
        });
        for case in &mut to.cases {
            case.channels.resize(to.channels.len(), None);
        }
    }
}

/// Returns the text of the table with new values. `read` holds the channel values that a virtual rig has read, by case.
pub fn written(table: &Table, measured: &Measurement, read: &[Vec<f64>]) -> String {
    let (name, value) = (table.column("name"), table.column("value"));
    let mut text = table.header_row();
    for row in table.rows() {
        let mut cells: Vec<(usize, String)> = row
            .iter()
            .enumerate()
            .map(|(k, cell)| (k, cell.text.replace(',', ".")))
            .collect();
        let own = name.and_then(|name| table.cell(row, name));
        let channel = measured.channels.iter().position(|channel| {
            channel.summary.is_some() && own.is_some_and(|own| own.text == channel.name)
        });
        if let (Some(channel), Some(value)) = (channel, value) {
            let info = &measured.channels[channel];
            let last = info.summary.as_ref().and_then(|s| s.cases.last());
            if let (Some(last), Some(cell)) = (last, cells.get_mut(value)) {
                cell.1 = format!("{:.9e}", read[*last][channel] / info.column.1);
            }
        }
        text += &table.further_row(&cells);
    }
    text
}
