//! Open points of an import: missing or contradictory information. On a terminal, the user is asked about them. Otherwise, they are reported as
//! diagnostics.

use super::block::Block;
use super::characteristic::{Characteristic, Target};
use super::column::Column;
use super::column_text::{FILL_IN, filled, quoted};
use super::heading::folded;
use super::mapping::{Mapping, side_named};
use super::missing::Missing;
use super::named_test::NamedTest;
use super::quantity::Quantity;
use super::resolved::{find, resolve};
use super::sheet::Sheet;
use admire_kc::{Side, TestKind};
use admire_study::Cell;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Open point of an import: information that is missing in the table and its mapping, or a contradiction in the mapping.
#[derive(Clone, PartialEq, Debug)]
pub enum OpenPoint {
    /// The mapping entry lacks information about the column to which it refers. `block` and `at` give one such column, which is shown as an
    /// example.
    Column {
        /// Index of the entry in the mapping.
        entry: usize,
        /// Index of the block.
        block: usize,
        /// Index of the column in the block.
        at: usize,
        /// Kind of the missing information.
        missing: Missing,
    },
    /// Two entries of the mapping state the same characteristic of the same side in one block.
    Twice {
        /// Indices of the entries.
        entries: [usize; 2],
        /// Index of the block.
        block: usize,
        /// Indices of the columns.
        at: [usize; 2],
    },
    /// A word may be the name of a test.
    Test {
        /// Word as written.
        word: String,
        /// Index of the block.
        block: usize,
        /// Cell with the word; `None` for the name of a sheet.
        cell: Option<Cell>,
    },
    /// A word in the column of sides is unknown.
    Side {
        /// Index of the block.
        block: usize,
        /// Cell with the word.
        cell: Cell,
    },
    /// The test of the rows is not named anywhere.
    NoTest,
}

/// Returns the information that is missing for an entry of the mapping.
pub(crate) fn missing_of(open: &[OpenPoint], of: usize) -> Vec<Missing> {
    let mut found = Vec::new();
    for point in open {
        if let OpenPoint::Column { entry, missing, .. } = point
            && *entry == of
            && !found.contains(missing)
        {
            found.push(*missing);
        }
    }
    found
}

impl Mapping {
    /// Returns the open points of the blocks and this mapping, in the order of the questions.
    pub fn open(&self, blocks: &[Block], sheets: &[Sheet]) -> Vec<OpenPoint> {
        let mut found = Vec::new();
        for (number, block) in blocks.iter().enumerate() {
            if self.test_of_block(block, sheets) == Some(NamedTest::Skipped) {
                continue;
            }
            let mut held: Vec<(Target, Option<Side>, usize, usize)> = Vec::new();
            for (entry, column) in self.columns.iter().enumerate() {
                let Ok(at) = find(column, block) else {
                    continue;
                };
                match resolve(self, entry, block, at) {
                    Ok(resolved) => {
                        let Some(is) = resolved.is else { continue };
                        let same = |(other, side, ..): &&(Target, Option<Side>, usize, usize)| {
                            *other == is && *side == resolved.side
                        };
                        if let Some((_, _, first, there)) = held.iter().find(same) {
                            found.push(OpenPoint::Twice {
                                entries: [*first, entry],
                                block: number,
                                at: [*there, at],
                            });
                        }
                        held.push((is, resolved.side, entry, at));
                    }
                    Err(missing) => {
                        found.extend(missing.into_iter().map(|missing| OpenPoint::Column {
                            entry,
                            block: number,
                            at,
                            missing,
                        }));
                    }
                }
            }
            found.extend(self.open_words(block, number));
            if self.test_of_block(block, sheets).is_none() && !self.has_test_column(block) {
                found.push(open_test(block, number, blocks, sheets));
            }
        }
        let mut once: Vec<OpenPoint> = Vec::new();
        for point in found {
            if !once.iter().any(|known| known.asks_the_same(&point)) {
                once.push(point);
            }
        }
        once
    }

    fn has_test_column(&self, block: &Block) -> bool {
        let mut entries = self.columns.iter();
        entries.any(|entry| entry.is == Some(Target::Test) && find(entry, block).is_ok())
    }

    /// Returns open points for the unknown words for tests and sides in columns of the block.
    fn open_words(&self, block: &Block, number: usize) -> Vec<OpenPoint> {
        let mut found: Vec<OpenPoint> = Vec::new();
        for entry in &self.columns {
            let (Some(is), Ok(at)) = (entry.is, find(entry, block)) else {
                continue;
            };
            let mut last = "";
            for row in &block.rows {
                let Some(cell) = row.get(at).filter(|cell| !cell.text.is_empty()) else {
                    continue;
                };
                if cell.text == last {
                    continue;
                }
                last = &cell.text;
                let point = match is {
                    Target::Test if self.test(&cell.text).is_none() => OpenPoint::Test {
                        word: cell.text.clone(),
                        block: number,
                        cell: Some(cell.clone()),
                    },
                    Target::Side if self.side(&cell.text).is_none() => OpenPoint::Side {
                        block: number,
                        cell: cell.clone(),
                    },
                    _ => continue,
                };
                if !found.iter().any(|known| known.asks_the_same(&point)) {
                    found.push(point);
                }
            }
        }
        found
    }
}

/// Returns the open point about the test of a block. The name of its sheet or the last title above the block may name the test.
fn open_test(block: &Block, number: usize, blocks: &[Block], sheets: &[Sheet]) -> OpenPoint {
    let sheet = sheets[block.sheet].name.as_ref();
    let same_file = |other: &&Block| other.sheet == block.sheet;
    if let Some(sheet) = sheet.filter(|_| sheets.len() > 1) {
        return OpenPoint::Test {
            word: sheet.clone(),
            block: number,
            cell: None,
        };
    }
    match block.titles.last() {
        Some(title) if blocks.iter().filter(same_file).count() > 1 => OpenPoint::Test {
            word: title.text.clone(),
            block: number,
            cell: Some(title.clone()),
        },
        _ => OpenPoint::NoTest,
    }
}

impl OpenPoint {
    fn asks_the_same(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Column { entry, missing, .. },
                Self::Column {
                    entry: other,
                    missing: too,
                    ..
                },
            ) => entry == other && missing == too,
            (Self::Twice { entries, .. }, Self::Twice { entries: other, .. }) => entries == other,
            (Self::Test { word, .. }, Self::Test { word: other, .. }) => {
                folded(word) == folded(other)
            }
            (Self::Side { cell, .. }, Self::Side { cell: other, .. }) => {
                folded(&cell.text) == folded(&other.text)
            }
            (Self::NoTest, Self::NoTest) => true,
            _ => false,
        }
    }

    /// Returns the line of the mapping that names the test of a word.
    pub(crate) fn test_line(&self) -> Option<String> {
        let Self::Test { word, .. } = self else {
            return None;
        };
        let names = TestKind::ALL.map(TestKind::name).join(", ");
        let remark = filled(&format!("{names}, or {}", NamedTest::SKIP));
        Some(format!("{remark}{} = {}", quoted(word), quoted(FILL_IN)))
    }

    /// Returns the line of the mapping that names the side of a word.
    pub(crate) fn side_line(&self) -> Option<String> {
        let Self::Side { cell, .. } = self else {
            return None;
        };
        let remark = filled("left or right");
        Some(format!(
            "{remark}{} = {}",
            quoted(&cell.text),
            quoted(FILL_IN)
        ))
    }

    /// Returns the question for the user at the terminal.
    pub fn question(&self, mapping: &Mapping, blocks: &[Block]) -> String {
        match self {
            Self::Column {
                entry,
                block,
                at,
                missing,
            } => {
                let column = &mapping.columns[*entry];
                let heading = &blocks[*block].headings[*at];
                let is = column.is.map_or("a load", Target::word);
                let found = match (&heading.unit, missing) {
                    (Some(unit), Missing::Unit) => format!(" (`{unit}` is not clear)"),
                    _ => String::new(),
                };
                format!(
                    "`{}`, {is}{found}: {}?",
                    heading.written,
                    missing.wanted(column)
                )
            }
            Self::Twice { block, at, entries } => {
                let of = |k: usize| &blocks[*block].headings[at[k]].written;
                let is = mapping.columns[entries[0]].is.map_or("", Target::word);
                format!(
                    "`{}` (1) and `{}` (2) could both be {is}: which one is it, 1 or 2?",
                    of(0),
                    of(1)
                )
            }
            Self::Test { word, .. } => {
                let names = TestKind::ALL.map(TestKind::name).join(", ");
                format!("which test is `{word}`: {names}, or {}?", NamedTest::SKIP)
            }
            Self::Side { cell, .. } => format!("which side is `{}`: left or right?", cell.text),
            Self::NoTest => {
                let names = TestKind::ALL.map(TestKind::name).join(", ");
                format!("which test is this file: {names}?")
            }
        }
    }

    /// Stores the reply to [`Self::question`] in the mapping. Returns false if the reply is not a valid answer.
    #[must_use]
    pub fn answer(&self, reply: &str, mapping: &mut Mapping) -> bool {
        let reply = reply.trim();
        match self {
            Self::Column { entry, missing, .. } => {
                let column = &mut mapping.columns[*entry];
                column.take(*missing, reply)
            }
            Self::Twice { entries, .. } => {
                let dropped = match reply {
                    "1" => entries[1],
                    "2" => entries[0],
                    _ => return false,
                };
                mapping.columns.remove(dropped);
                true
            }
            Self::Test { word, .. } => {
                let Some(kind) = NamedTest::named(reply) else {
                    return false;
                };
                mapping.tests.push((word.clone(), kind));
                true
            }
            Self::Side { cell, .. } => {
                let Some(side) = side_named(reply) else {
                    return false;
                };
                mapping.sides.push((cell.text.clone(), side));
                true
            }
            Self::NoTest => {
                mapping.file.test = NamedTest::named(reply).and_then(NamedTest::test);
                mapping.file.test.is_some()
            }
        }
    }
}

impl Column {
    /// Stores a reply about missing information. Returns false if the reply is not valid.
    fn take(&mut self, missing: Missing, reply: &str) -> bool {
        let of = match self.is {
            Some(Target::Characteristic(of)) => Some(of),
            _ => None,
        };
        match missing {
            Missing::Unit => {
                let quantity = of.and_then(Characteristic::quantity);
                let known = Quantity::of_unit(reply).map(|(quantity, _)| quantity);
                let as_length =
                    quantity == Some(Quantity::Angle) && known == Some(Quantity::Length);
                let fits = match (of, quantity) {
                    (Some(_), None) => !reply.is_empty(),
                    (Some(_), Some(wanted)) => wanted.factor(reply).is_some() || as_length,
                    (None, _) => known.is_some(),
                };
                self.unit = fits.then(|| reply.to_string());
                fits
            }
            Missing::OverMm => {
                let number = reply.replace(',', ".").parse::<f64>().ok();
                self.over_mm = number.filter(|over| *over > 0.0 && over.is_finite());
                self.over_mm.is_some()
            }
            Missing::Side => {
                self.side = side_named(reply);
                self.side.is_some()
            }
            Missing::Positive => {
                let known = of.and_then(|of| of.sign(reply, None));
                self.positive = known.map(|_| reply.to_string());
                known.is_some()
            }
            Missing::LoadSign => {
                self.load_sign = match reply {
                    "+" => Some(1.0),
                    "-" => Some(-1.0),
                    _ => None,
                };
                self.load_sign.is_some()
            }
        }
    }
}

/// Returns the diagnostics about open points. Each diagnostic shows places in the tables, and the lines of the mapping that would settle its
/// open points.
pub fn complaints(
    open: &[OpenPoint],
    mapping: &Mapping,
    blocks: &[Block],
    sheets: &[Sheet],
) -> Vec<Diagnostic> {
    /// Largest number of places that one diagnostic labels.
    const MAX_LABELS: usize = 12;
    let mut found = Vec::new();
    let name = |block: usize| sheets[blocks[block].sheet].source.name();
    for kind in [
        Missing::Unit,
        Missing::OverMm,
        Missing::Side,
        Missing::Positive,
        Missing::LoadSign,
    ] {
        let mut complaint = Diagnostic::error(Code::UnclearColumn, kind.described());
        let mut lines = Vec::new();
        for point in open {
            if let OpenPoint::Column {
                entry,
                block,
                at,
                missing,
            } = point
                && *missing == kind
            {
                if lines.len() < MAX_LABELS {
                    let span = blocks[*block].headings[*at].span;
                    complaint = complaint.label(name(*block), span, "");
                }
                lines.push(mapping.columns[*entry].line(&missing_of(open, *entry)));
            }
        }
        if !lines.is_empty() {
            let help = format!("write in the mapping:\n[columns]\n{}", lines.join("\n"));
            found.push(complaint.help(help));
        }
    }
    let mut tests = Diagnostic::error(Code::UnclearColumn, "the tests of these rows are not clear");
    let mut sides = Diagnostic::error(Code::UnclearColumn, "the sides of these rows are not clear");
    let (mut test_lines, mut side_lines) = (Vec::new(), Vec::new());
    for point in open {
        match point {
            OpenPoint::Twice { block, at, entries } => {
                let of = |k: usize| blocks[*block].headings[at[k]].span;
                let is = mapping.columns[entries[0]].is.map_or("", Target::word);
                let message = format!("two columns hold {is} of the same side");
                let wrong = Diagnostic::error(Code::UnclearColumn, message);
                let wrong = wrong.label(name(*block), of(0), "this one");
                let wrong = wrong.label(name(*block), of(1), "and this one");
                found
                    .push(wrong.help(
                        "keep only one of the two columns in the mapping, below `[columns]`",
                    ));
            }
            OpenPoint::Test { block, cell, .. } => {
                let heading = blocks[*block].headings.first().map(|heading| heading.span);
                let span = cell.as_ref().map(|cell| cell.span).or(heading);
                tests = tests.label(name(*block), span.unwrap_or_default(), "");
                test_lines.extend(point.test_line());
            }
            OpenPoint::Side { block, cell } => {
                sides = sides.label(name(*block), cell.span, "");
                side_lines.extend(point.side_line());
            }
            OpenPoint::NoTest => {
                let message = "the test of these rows is not stated";
                let span = blocks.first().and_then(|block| block.headings.first());
                let wrong = Diagnostic::error(Code::UnclearColumn, message).label(
                    name(0),
                    span.map(|heading| heading.span).unwrap_or_default(),
                    "",
                );
                let names = TestKind::ALL.map(TestKind::name).join(", ");
                found.push(wrong.help(format!(
                    "--test TEST, or in the mapping, below `[file]`: test = \"bounce\"; tests are {names}"
                )));
            }
            OpenPoint::Column { .. } => {}
        }
    }
    for (complaint, section, lines) in [(tests, "tests", test_lines), (sides, "sides", side_lines)]
    {
        if !lines.is_empty() {
            let help = format!("write in the mapping:\n[{section}]\n{}", lines.join("\n"));
            found.push(complaint.help(help));
        }
    }
    found
}
