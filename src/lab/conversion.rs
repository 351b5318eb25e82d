//! Rows of blocks, converted to the units and signs of the table.

use std::collections::BTreeMap;

use super::block::Block;
use super::characteristic::{Characteristic, Target};
use super::mapping::Mapping;
use super::named_test::NamedTest;
use super::quantity::Quantity;
use super::resolved::{Resolved, find, resolve};
use super::sheet::{Sheet, is_missing};
use admire_kc::{Driven, Side, TestKind};
use admire_study::Cell;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// One converted row.
#[derive(Clone, Default, Debug)]
pub(crate) struct Row {
    /// Values by characteristic and side.
    pub values: BTreeMap<(Characteristic, Option<Side>), f64>,
    /// Values of load case columns by name.
    pub loads: BTreeMap<String, f64>,
    /// Time, in the unit of the file.
    pub time: Option<f64>,
    /// Place of the row.
    pub span: Span,
}

/// Rows of one test, in the order driven.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// The test.
    pub test: TestKind,
    /// Index of the sheet that the rows come from.
    pub sheet: usize,
    /// The rows.
    pub rows: Vec<Row>,
}

/// Columns and rows of all blocks.
#[derive(Default, Debug)]
pub(crate) struct Converted {
    /// Rows by test, in the order of the files.
    pub series: Vec<Series>,
    /// All imported columns, each listed once: index of the block, and resolved entry.
    pub columns: Vec<(usize, Resolved)>,
}

/// Converts the rows of all blocks. Cells without a number are reported. Entries of the mapping that match no block are reported, too.
pub(crate) fn converted(
    mapping: &Mapping,
    blocks: &[Block],
    sheets: &[Sheet],
    out: &mut Vec<Diagnostic>,
) -> Converted {
    let mut result = Converted::default();
    for (number, block) in blocks.iter().enumerate() {
        let test = mapping.test_of_block(block, sheets);
        if test == Some(NamedTest::Skipped) {
            continue;
        }
        let mut columns = Vec::new();
        for (entry, column) in mapping.columns.iter().enumerate() {
            match find(column, block) {
                Ok(at) => columns.extend(resolve(mapping, entry, block, at).ok()),
                Err(0) => {}
                Err(count) => out.push(
                    sheets[block.sheet]
                        .error(
                            Code::BadReading,
                            format!("{count} columns are called `{}`", column.name),
                            block.headings[0].span,
                        )
                        .help("name the column in the mapping with its unit, as the heading is written"),
                ),
            }
        }
        for resolved in &columns {
            let known = |(_, other): &(usize, Resolved)| other.entry == resolved.entry;
            if !result.columns.iter().any(known) {
                result.columns.push((number, resolved.clone()));
            }
            contradiction(mapping, block, resolved, sheets, out);
        }
        let reader = RowReader {
            mapping,
            sheet: &sheets[block.sheet],
            columns,
            test: test.and_then(NamedTest::test),
        };
        reader.read(block, &mut result.series, out);
    }
    result
}

/// Reports a heading whose unit differs from the unit of the mapping.
fn contradiction(
    mapping: &Mapping,
    block: &Block,
    resolved: &Resolved,
    sheets: &[Sheet],
    out: &mut Vec<Diagnostic>,
) {
    let heading = &block.headings[resolved.at];
    let (Some(stated), Some(own)) = (&mapping.columns[resolved.entry].unit, &heading.unit) else {
        return;
    };
    let (stated_size, own_size) = (Quantity::of_unit(stated), Quantity::of_unit(own));
    if own_size.is_some() && stated_size.is_some() && own_size != stated_size {
        let message =
            format!("the heading states the unit `{own}`, but the mapping states `{stated}`");
        let wrong = sheets[block.sheet].error(Code::WrongUnits, message, heading.span);
        out.push(wrong.help("remove `unit` from the mapping if the heading is right"));
    }
}

/// Reader of the rows of one block.
struct RowReader<'a> {
    mapping: &'a Mapping,
    sheet: &'a Sheet,
    columns: Vec<Resolved>,
    /// Test of the rows, if no column contains it.
    test: Option<TestKind>,
}

impl RowReader<'_> {
    fn read(&self, block: &Block, into: &mut Vec<Series>, out: &mut Vec<Diagnostic>) {
        let mut own: Vec<(Option<Side>, Series)> = Vec::new();
        let mut bad: Vec<(usize, usize, Cell)> = Vec::new();
        for line in &block.rows {
            let Some(test) = self.test_of(line) else {
                continue;
            };
            let side = self.side_of(line);
            let row = self.row(line, side, &mut bad);
            let same =
                |(of, series): &&mut (Option<Side>, Series)| *of == side && series.test == test;
            match own.iter_mut().find(same) {
                Some((_, series)) => series.rows.push(row),
                None => own.push((
                    side,
                    Series {
                        test,
                        sheet: block.sheet,
                        rows: vec![row],
                    },
                )),
            }
        }
        for (_, count, cell) in bad {
            let unclear = self.sheet.is_unclear(&cell);
            let more = match count {
                0 | 1 => String::new(),
                2 => ", nor is one more cell of this column".to_string(),
                _ => format!(", nor are {} more cells of this column", count - 1),
            };
            let (message, help) = if unclear {
                (
                    format!(
                        "`{}` is ambiguous: its point may separate thousands or decimals, because other numbers of this file have decimal commas",
                        cell.text
                    ),
                    "state the decimal mark in the mapping, below `[file]`: decimal = \",\" or decimal = \".\"",
                )
            } else {
                (
                    format!("`{}` is not a number{more}", cell.text),
                    "leave a cell empty where nothing was measured",
                )
            };
            out.push(
                self.sheet
                    .error(Code::BadReading, message, cell.span)
                    .help(help),
            );
        }
        for (_, mut series) in own {
            self.put_in_order(&mut series, out);
            let every = self.mapping.file.every.max(1);
            series.rows = series.rows.into_iter().step_by(every).collect();
            into.push(series);
        }
    }

    fn cell_of<'b>(&self, line: &'b [Cell], target: Target) -> Option<&'b Cell> {
        let column = self
            .columns
            .iter()
            .find(|column| column.is == Some(target))?;
        line.get(column.at).filter(|cell| !cell.text.is_empty())
    }

    fn test_of(&self, line: &[Cell]) -> Option<TestKind> {
        match self.cell_of(line, Target::Test) {
            Some(cell) => self.mapping.test(&cell.text)?.test(),
            None => self.test,
        }
    }

    fn side_of(&self, line: &[Cell]) -> Option<Side> {
        let cell = self.cell_of(line, Target::Side)?;
        self.mapping.side(&cell.text)
    }

    /// Converts a row. Cells without a number are collected in `bad`, one cell per column with the number of such cells.
    fn row(&self, line: &[Cell], side: Option<Side>, bad: &mut Vec<(usize, usize, Cell)>) -> Row {
        let mut row = Row {
            span: match (line.first(), line.last()) {
                (Some(first), Some(last)) => first.span.join(last.span),
                _ => Span::at(0),
            },
            ..Row::default()
        };
        for column in &self.columns {
            let is_word = matches!(column.is, Some(Target::Test | Target::Side));
            let Some(cell) = line.get(column.at).filter(|_| !is_word) else {
                continue;
            };
            if is_missing(&cell.text) {
                continue;
            }
            let Some(number) = self.sheet.number(cell) else {
                match bad.iter_mut().find(|(at, ..)| *at == column.at) {
                    Some((_, count, _)) => *count += 1,
                    None => bad.push((column.at, 1, cell.clone())),
                }
                continue;
            };
            let entry = &self.mapping.columns[column.entry];
            if column.is == Some(Target::Time) {
                row.time = Some(number);
                continue;
            }
            let mut value = number * column.factor;
            if let Some(over) = entry.over_mm {
                value = libm::asin((value / over).clamp(-1.0, 1.0)).to_degrees();
            }
            if let Some(name) = &entry.load {
                let sign = entry.load_sign.unwrap_or(1.0);
                row.loads
                    .insert(name.clone(), value * sign * in_deck(column));
            }
            if let Some(of) = column.characteristic() {
                let side = column.side.or(side.filter(|_| of.is_sided()));
                let positive = entry.positive.as_deref().unwrap_or_default();
                let sign = of.sign(positive, side).unwrap_or(1.0);
                row.values.insert((of, side), value * sign + 0.0);
            }
        }
        row
    }

    /// Sorts rows by time if they are in another order, and reports it. Several long runs that each restart the time keep their order.
    fn put_in_order(&self, series: &mut Series, out: &mut Vec<Diagnostic>) {
        /// Smallest mean number of rows between two backward steps in time at which the rows count as several runs.
        const MIN_RUN_ROWS: usize = 4;
        let times: Vec<f64> = series.rows.iter().filter_map(|row| row.time).collect();
        let back = times.windows(2).filter(|two| two[1] < two[0]).count();
        if times.len() < series.rows.len() || back == 0 || MIN_RUN_ROWS * (back + 1) <= times.len()
        {
            return;
        }
        let time = |row: &Row| row.time.unwrap_or_default();
        series.rows.sort_by(|a, b| time(a).total_cmp(&time(b)));
        let name = series.test.name();
        let first = series.rows[0].span;
        let twice = series
            .rows
            .windows(2)
            .find(|two| two[0].time == two[1].time);
        if let Some([_, second]) = twice {
            let message = format!(
                "the rows of the test `{name}` are not in time order, and a time occurs twice"
            );
            let help = "give each run a file of its own, or remove the time column from the mapping if the rows are in the order driven";
            let wrong = self
                .sheet
                .error(Code::DuplicateReading, message, second.span);
            out.push(wrong.help(help));
            return;
        }
        let message = format!("rows of the test `{name}` are sorted by time");
        let note = Diagnostic::note(Code::CsvDialect, message);
        out.push(note.label(self.sheet.source.name(), first, ""));
    }
}

/// Returns the factor from the unit of a column's quantity to the unit in a deck with newtons and millimetres.
fn in_deck(column: &Resolved) -> f64 {
    if column.quantity == Some(Quantity::Torque) {
        1000.0
    } else {
        1.0
    }
}

/// Returns the characteristic that a test drives, and the factors of the left and the right wheel for the variable of the test.
pub(crate) fn driven(test: TestKind) -> (Characteristic, [f64; 2]) {
    // Lateral forces are positive to the left in the table, and positive to the right in the variable of a test.
    match test.driven() {
        Driven::Height(ways) => (Characteristic::WheelTravel, ways),
        Driven::Steering => (Characteristic::SteeringInput, [1.0, 1.0]),
        Driven::Fx(ways) if test == TestKind::Traction => {
            (Characteristic::DrivingForce, ways.map(|way| -way))
        }
        Driven::Fx(ways) => (Characteristic::BrakingForce, ways),
        Driven::Fy(ways) => (Characteristic::LateralForce, ways.map(|way| -way)),
        Driven::Mz(ways) => (Characteristic::AligningTorque, ways),
    }
}

impl Row {
    /// Returns the variable of a test: the mean over both wheels, or the value of the only wheel.
    pub(crate) fn variable(&self, test: TestKind) -> Option<f64> {
        let (of, ways) = driven(test);
        if !of.is_sided() {
            return self.values.get(&(of, None)).copied();
        }
        let each: Vec<f64> = Side::BOTH
            .into_iter()
            .filter(|side| ways[side.index()] != 0.0)
            .filter_map(|side| Some(self.values.get(&(of, Some(side)))? * ways[side.index()]))
            .collect();
        (!each.is_empty()).then(|| each.iter().sum::<f64>() / each.len() as f64)
    }
}
