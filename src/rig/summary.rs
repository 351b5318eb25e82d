//! Numbers that a laboratory takes from its curves: gradients and widths of loops, as readings of their own.
//!
//! A gradient is the slope of the least-squares line of a curve over a load or over another curve, within a run of load cases:
//! `g = sum (x - mean x)(y - mean y) / sum (x - mean x)^2`. The width of a loop where its load has a value is what the curve shows there on
//! average with the load falling, less what it shows with the load rising, cases between which it passes joined by straight lines.
//! Source: guide page `study`, section "Gradients and widths".

use super::kc_curves::{Curve, Gauge, KcSettings, factor};
use super::measurement::{Channel, Measurement};
use super::rows::labels;
use super::section::meant;
use super::study::Study;
use super::table::{Cell, Table};
use super::wheel_readings::marker_of;
use crate::diagnostic::{Code, Diagnostic};
use crate::model::Model;

/// What is taken from a curve.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SummaryKind {
    /// Slope of the least-squares line.
    Gradient,
    /// Width of the loop where the load has this value.
    Width(f64),
}

/// What a curve is drawn over.
#[derive(Clone, PartialEq, Debug)]
pub enum Over {
    /// A load: its value in each of the cases, in the unit of the study's file.
    Load(Vec<f64>),
    /// Another channel.
    Channel(usize),
}

/// A number taken from a channel over several cases.
#[derive(Clone, PartialEq, Debug)]
pub struct Summary {
    /// What is taken.
    pub kind: SummaryKind,
    /// Over what.
    pub over: Over,
    /// The cases in the order driven.
    pub cases: Vec<usize>,
    /// A gradient is stated per so many units of what it is over.
    pub per: f64,
}

/// The value of a summary, and its derivatives by each value of the curve and of what it is over.
#[derive(Clone, PartialEq, Debug)]
pub struct Taken {
    /// The value.
    pub value: f64,
    /// By the curve in each case.
    pub by_curve: Vec<f64>,
    /// By what it is over, in each case.
    pub by_over: Vec<f64>,
}

impl Summary {
    /// From the curve in each of its cases, `channel` telling another channel there. Zero where nothing can be taken.
    pub fn take(&self, curve: &[f64], channel: &dyn Fn(usize) -> Vec<f64>) -> Taken {
        let x = match &self.over {
            Over::Load(values) => values.clone(),
            Over::Channel(other) => channel(*other),
        };
        match self.kind {
            SummaryKind::Gradient => gradient(&x, curve, self.per),
            SummaryKind::Width(at) => {
                let by_curve = weights(&x, at).unwrap_or_else(|| vec![0.0; x.len()]);
                Taken {
                    value: by_curve.iter().zip(curve).map(|(w, y)| w * y).sum(),
                    by_over: vec![0.0; x.len()],
                    by_curve,
                }
            }
        }
    }
}

fn gradient(x: &[f64], y: &[f64], per: f64) -> Taken {
    let count = x.len() as f64;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
    let (middle, height) = (mean(x), mean(y));
    let square: f64 = x.iter().map(|x| (x - middle).powi(2)).sum();
    let scale = if square > 0.0 { per / square } else { 0.0 };
    let by_curve: Vec<f64> = x.iter().map(|x| (x - middle) * scale).collect();
    let value: f64 = by_curve.iter().zip(y).map(|(w, y)| w * y).sum();
    let each = x.iter().zip(y);
    let by_over =
        each.map(|(x, y)| ((y - height) * scale) - 2.0 * value * (x - middle) * scale / per);
    Taken {
        value,
        by_over: by_over.collect(),
        by_curve,
    }
}

/// Weights of the curve's values in the width of a loop; `None` if the load does not pass there both ways.
fn weights(x: &[f64], at: f64) -> Option<Vec<f64>> {
    let mut ways = [vec![0.0; x.len()], vec![0.0; x.len()]];
    let mut counts = [0.0; 2];
    for k in 0..x.len() {
        if x[k] == at {
            let before = if k == 0 { x[k] } else { x[k - 1] };
            let after = x.get(k + 1).copied().unwrap_or(x[k]);
            let way = match after - before {
                rise if rise > 0.0 => 1,
                rise if rise < 0.0 => 0,
                _ => continue,
            };
            ways[way][k] += 1.0;
            counts[way] += 1.0;
        } else if let Some(next) = x.get(k + 1)
            && (x[k] - at) * (next - at) < 0.0
        {
            let way = usize::from(*next > x[k]);
            let part = (at - x[k]) / (next - x[k]);
            ways[way][k] += 1.0 - part;
            ways[way][k + 1] += part;
            counts[way] += 1.0;
        }
    }
    let [falling, rising] = counts;
    let both = falling > 0.0 && rising > 0.0;
    let each = ways[0].iter().zip(&ways[1]);
    both.then(|| {
        each.map(|(down, up)| down / falling - up / rising)
            .collect()
    })
}

/// Columns of the table.
const COLUMNS: [&str; 8] = [
    "name", "curve", "kind", "over", "from", "to", "value", "sigma",
];

/// Adds the readings of a table of gradients and widths.
pub(super) fn summaries(
    study: &Study,
    model: &Model,
    (settings, table): (&KcSettings, &Table),
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
    for row in table.rows() {
        let read = Row {
            study,
            table,
            row,
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
    row: &'a [Cell],
    columns: [usize; 8],
    model: &'a Model,
}

impl Row<'_> {
    fn cell(&self, column: usize) -> Result<&Cell, Diagnostic> {
        let found = self.table.cell(self.row, self.columns[column]);
        found.ok_or_else(|| {
            let message = format!("a gradient or width without `{}`", COLUMNS[column]);
            let span = self.table.row_span(self.row);
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
                let help = "the slope of a curve, or the width of its loop".to_string();
                return Err(self.wrong(kind, message, help));
            }
        };
        let case = |cell: &Cell| {
            to.case(&cell.text).ok_or_else(|| {
                let message = format!("the load cases have no case `{}`", cell.text);
                let help = meant(&cell.text, "the file of load cases", &labels(to));
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
            let message = match kind {
                SummaryKind::Gradient => {
                    "nothing changes from the first of these cases to the last"
                }
                SummaryKind::Width(_) => {
                    "this is no load that passes there both ways within these cases"
                }
            };
            let help = "`over` names a column of the load cases; `from` and `to` are the first and the last case of the run";
            return Err(self.wrong(over_cell, message.to_string(), help.to_string()));
        }
        let (angle, millimetre) = (curve.is_angle(), 1e-3 / self.model.units.length.si);
        let scale = match unit {
            None => 1.0,
            Some(cell) => {
                let own = factor(&cell.text, angle).ok_or_else(|| {
                    let message = format!("`{}` is no unit of this curve", cell.text);
                    let help = "an angle: deg, min, rad, mrad; a length: mm, cm, m, in".to_string();
                    self.wrong(cell, message, help)
                })?;
                own * if angle { 1.0 } else { millimetre }
            }
        };
        let sigma = self.table.number(self.row, self.columns[7], out);
        let Some(sigma) = sigma.filter(|sigma| *sigma > 0.0) else {
            let cell = self.cell(7)?;
            let message = "sigma is to be more than 0".to_string();
            return Err(self.wrong(cell, message, "sd of this number".to_string()));
        };
        let name = self.cell(0)?;
        if to.channels.iter().any(|channel| channel.name == name.text) {
            let message = format!("`{}` is a channel already", name.text);
            return Err(self.wrong(name, message, "give each a name of its own".to_string()));
        }
        // An empty value is one that a rig may make.
        let value = self.table.number(self.row, self.columns[6], out);
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
            let message = format!("`{}` is no curve", cell.text);
            let help = format!("one of {}", Curve::words().join(", "));
            self.wrong(cell, message, help)
        })
    }

    /// The channel of a curve that another is drawn over: one that is read, or a new one that is not.
    fn other(&self, cell: &Cell, gauge: &Gauge, to: &mut Measurement) -> Result<usize, Diagnostic> {
        let curve = Curve::named(&cell.text).ok_or_else(|| {
            let loads = self.study.columns.iter().map(|(n, _)| n.text.as_str());
            let known: Vec<&str> = loads.chain(Curve::words()).collect();
            let message = format!("`{}` is no load and no curve", cell.text);
            self.wrong(cell, message, format!("one of {}", known.join(", ")))
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

/// The table with the values that a rig takes from its own curves.
pub(super) fn written(table: &Table, measured: &Measurement, read: &[Vec<f64>]) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(kind: SummaryKind, over: Over, count: usize) -> Summary {
        Summary {
            kind,
            over,
            cases: (0..count).collect(),
            per: 100.0,
        }
    }

    #[test]
    fn a_line_has_its_slope_and_derivatives_are_those_of_differences() {
        let x = [-20.0, -5.0, 3.0, 11.0, 30.0];
        let line: Vec<f64> = x.iter().map(|x| 0.7 - 0.0032 * x).collect();
        let own = summary(SummaryKind::Gradient, Over::Channel(0), 5);
        let taken = own.take(&line, &|_| x.to_vec());
        assert!((taken.value + 0.32).abs() < 1e-12);
        let y = [0.3, -0.4, 0.9, 0.2, 1.7];
        let taken = own.take(&y, &|_| x.to_vec());
        let step = 1e-5;
        for k in 0..5 {
            let at = |of_x: f64, of_y: f64| {
                let (mut x, mut y) = (x.to_vec(), y);
                x[k] += of_x;
                y[k] += of_y;
                own.take(&y, &|_| x.clone()).value
            };
            let by_x = (at(step, 0.0) - at(-step, 0.0)) / (2.0 * step);
            let by_y = (at(0.0, step) - at(0.0, -step)) / (2.0 * step);
            assert!((by_x - taken.by_over[k]).abs() < 1e-7, "{k}");
            assert!((by_y - taken.by_curve[k]).abs() < 1e-7, "{k}");
        }
    }

    /// Dry friction of size f on a line: the loop is 2 f wide, whether it is read at a point or between two.
    #[test]
    fn a_loop_has_its_width() {
        let x = [0.0, 10.0, 20.0, 10.0, 0.0, -10.0, -20.0, -10.0, 0.0, 10.0];
        let ways = [1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
        let y: Vec<f64> = x
            .iter()
            .zip(ways)
            .map(|(x, way)| 0.1 * x - 0.4 * way)
            .collect();
        for at in [0.0, 5.0] {
            let own = summary(SummaryKind::Width(at), Over::Load(x.to_vec()), 10);
            let taken = own.take(&y, &|_| Vec::new());
            assert!((taken.value - 0.8).abs() < 1e-12, "{at}: {}", taken.value);
        }
        assert!(weights(&x, 25.0).is_none() && weights(&[0.0, 1.0, 2.0], 1.0).is_none());
    }
}
