//! Blocks: tables within a sheet, each with title lines, headings, units and rows.

use std::collections::{HashMap, HashSet};

use super::file_options::FileOptions;
use super::heading::{Heading, folded, unbracketed};
use super::quantity::is_unit;
use super::sheet::{Sheet, is_missing};
use admire_kc::{Side, TestKind};
use admire_study::Cell;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Span;

/// Part of a sheet with one line of headings and its rows.
#[derive(Clone, Debug)]
pub struct Block {
    /// Index of the sheet in the list of sheets.
    pub sheet: usize,
    /// Cells with text above the headings: a title, a date, the name of the test.
    pub titles: Vec<Cell>,
    /// Headings of the columns, in the order of the file.
    pub headings: Vec<Heading>,
    /// Numbers of the lines from which headings and units were taken.
    pub header_lines: Vec<usize>,
    /// Rows with numbers.
    pub rows: Vec<Vec<Cell>>,
    /// Test of the rows, if the user states it for the file.
    pub test: Option<TestKind>,
    /// Side of all columns without a stated side, if the user states one for the file.
    pub side: Option<Side>,
}

/// Largest number of columns of a table.
const MAX_COLUMNS: usize = 4096;

/// Kind of a line, judged by its cells.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Line with at least two numbers and at least as many numbers as texts. In a narrow sheet, a single number alone is enough.
    Numbers,
    /// Line with two or more texts and no number.
    Texts,
    /// Any other line: a title, or a line with a name and a number.
    Title,
}

/// Finds the blocks of a sheet. Lines without numbers between two rows begin a new block. A title keeps the previous headings; a line of several
/// texts replaces them.
pub fn blocks(
    sheet: &Sheet,
    index: usize,
    options: &FileOptions,
    out: &mut Vec<Diagnostic>,
) -> Vec<Block> {
    let lines = sheet.lines();
    let fixed = fixed_lines(sheet, options, out);
    let begin = match fixed.iter().max() {
        Some(last) => last + 1,
        None => match first_row(sheet) {
            Some(first) => first,
            None => return Vec::new(),
        },
    };
    let mut found: Vec<Block> = Vec::new();
    let mut above: Vec<&Vec<Cell>> = Vec::new();
    let mut fixed = (!fixed.is_empty()).then_some(fixed);
    if fixed.is_none() {
        above.extend(&lines[..begin]);
    }
    let mut is_open = false;
    for line in &lines[begin..] {
        let kind = kind_of(line, sheet);
        let is_row = kind == Kind::Numbers
            || (is_open && line.iter().any(|cell| sheet.number(cell).is_some()));
        if !is_row {
            // A line that contains only missing values belongs to the rows.
            if line.iter().any(|cell| !is_missing(&cell.text)) {
                above.push(line);
                is_open = false;
            }
            continue;
        }
        if !is_open {
            let block = match fixed.take() {
                Some(at) => Some(Block::with(sheet, index, &[], &pick(lines, &at, options))),
                None => Block::below(sheet, index, &above, found.last()),
            };
            let Some(block) = block else {
                let message = "there is no line of headings above these numbers";
                let span = span_of(line);
                out.push(
                    sheet
                        .error(Code::MissingColumn, message.to_string(), span)
                        .help("state the line of the headings in the mapping, below `[file]`: header = 3"),
                );
                return found;
            };
            if block.headings.len() > MAX_COLUMNS {
                let message = format!("the table has more than {MAX_COLUMNS} columns");
                out.push(sheet.error(Code::BadReading, message, span_of(line)));
                return found;
            }
            found.push(block);
            above.clear();
            is_open = true;
        }
        let block = found.last_mut().expect("a block is open");
        let extra = line.iter().skip(block.headings.len());
        if extra.clone().any(|cell| !cell.text.is_empty()) {
            let message = format!(
                "the row has {} cells, but there are only {} headings",
                line.iter().filter(|cell| !cell.text.is_empty()).count(),
                block.headings.len()
            );
            out.push(
                sheet
                    .error(Code::BadReading, message, span_of(line))
                    .help("numbers with decimal commas need semicolons or tabs between the cells"),
            );
            return found;
        }
        block.rows.push(line.clone());
    }
    found
}

/// Returns the indices of the lines that the options name as headings and units. Numbers of lines that do not exist are reported.
fn fixed_lines(sheet: &Sheet, options: &FileOptions, out: &mut Vec<Diagnostic>) -> Vec<usize> {
    let mut found = Vec::new();
    for wanted in options.header.iter().chain(&options.units) {
        let is_it = |line: &Vec<Cell>| sheet.line_number(line) == *wanted;
        match sheet.lines().iter().position(is_it) {
            Some(at) => found.push(at),
            None => out.push(sheet.error(
                Code::BadSetting,
                format!("line {wanted}, which the mapping names in `[file]`, is blank or missing"),
                Span::at(0),
            )),
        }
    }
    found
}

/// Returns the header lines at these indices, units last.
fn pick<'a>(lines: &'a [Vec<Cell>], at: &[usize], options: &FileOptions) -> HeaderLines<'a> {
    let count = options.header.len();
    HeaderLines {
        names: at.iter().take(count).map(|k| &lines[*k]).collect(),
        units: at.get(count).map(|k| &lines[*k]),
    }
}

/// Lines of a header: one or two lines of names, and a line of units.
struct HeaderLines<'a> {
    names: Vec<&'a Vec<Cell>>,
    units: Option<&'a Vec<Cell>>,
}

impl Block {
    /// Creates the block below these lines. If they contain no line of headings, the block has the headings of the previous block.
    fn below(
        sheet: &Sheet,
        index: usize,
        above: &[&Vec<Cell>],
        before: Option<&Self>,
    ) -> Option<Self> {
        let units = above
            .iter()
            .rposition(|line| is_units(line))
            .filter(|at| at + 1 == above.len() && *at > 0);
        let names = &above[..units.unwrap_or(above.len())];
        let last = names
            .iter()
            .rposition(|line| kind_of(line, sheet) == Kind::Texts);
        let last = last.filter(|at| at + 1 == names.len());
        let Some(last) = last.or_else(|| {
            // The headings belong to a single column, or they contain numbers.
            (before.is_none() && !names.is_empty()).then(|| names.len() - 1)
        }) else {
            let before = before?;
            return Some(Self {
                sheet: index,
                titles: texts(above),
                headings: before.headings.clone(),
                header_lines: before.header_lines.clone(),
                rows: Vec::new(),
                test: None,
                side: None,
            });
        };
        let mut header = HeaderLines {
            names: vec![names[last]],
            units: units.map(|at| above[at]),
        };
        let mut first = last;
        // Equal names are distinguished by the line above, which names groups of columns.
        if is_repeating(names[last]) && last > 0 && kind_of(names[last - 1], sheet) == Kind::Texts {
            header.names.insert(0, names[last - 1]);
            first -= 1;
        }
        Some(Self::with(sheet, index, &names[..first], &header))
    }

    fn with(sheet: &Sheet, index: usize, titles: &[&Vec<Cell>], header: &HeaderLines<'_>) -> Self {
        let count = header.names.iter().map(|line| line.len()).max();
        let count = count.unwrap_or_default();
        let mut groups = vec![String::new(); header.names.len()];
        let mut headings: Vec<Heading> = Vec::new();
        let (mut names, mut texts_so_far) = (HashMap::<String, usize>::new(), HashSet::new());
        for column in 0..count {
            let (mut words, mut span) = (Vec::new(), Span::at(0));
            for (level, line) in header.names.iter().enumerate() {
                let is_lowest = level + 1 == header.names.len();
                if let Some(cell) = line.get(column) {
                    span = cell.span;
                    if !cell.text.is_empty() || is_lowest {
                        groups[level].clone_from(&cell.text);
                    }
                } else if is_lowest {
                    groups[level].clear();
                }
                words.push(groups[level].clone());
            }
            let words: Vec<String> = words.into_iter().filter(|word| !word.is_empty()).collect();
            let units = header.units.and_then(|line| line.get(column));
            let units = units.map(|cell| cell.text.as_str());
            let mut heading = Heading::new(&words.join(" "), units, span);
            // Several columns may have the same heading, or the same name with different units.
            let count = names.entry(heading.name_key().to_string()).or_default();
            *count += 1;
            if !texts_so_far.insert(heading.written_key().to_string()) && !heading.name.is_empty() {
                heading.number(*count);
            }
            headings.push(heading);
        }
        while headings.last().is_some_and(|last| last.written.is_empty()) {
            headings.pop();
        }
        let lines = header.names.iter().chain(&header.units);
        Self {
            sheet: index,
            titles: texts(titles),
            headings,
            header_lines: lines.map(|line| sheet.line_number(line)).collect(),
            rows: Vec::new(),
            test: None,
            side: None,
        }
    }
}

/// Returns the index of the first row of numbers: the first of two consecutive lines of numbers that are as wide as most lines of numbers.
fn first_row(sheet: &Sheet) -> Option<usize> {
    let lines = sheet.lines();
    let count = |line: &Vec<Cell>| {
        let numbers = line.iter().filter(|cell| sheet.number(cell).is_some());
        numbers.count()
    };
    let mut widths: Vec<usize> = lines.iter().map(count).filter(|n| *n > 0).collect();
    widths.sort_unstable();
    let usual = *widths.get(widths.len() / 2)?;
    let is_row = |line: &Vec<Cell>| {
        kind_of(line, sheet) == Kind::Numbers && 2 * count(line) >= usual && count(line) > 0
            || usual == 1 && count(line) == 1
    };
    let pair = lines.windows(2).position(|two| two.iter().all(is_row));
    pair.or_else(|| lines.iter().position(is_row))
        .filter(|at| *at > 0 || lines.len() == 1)
}

fn kind_of(line: &[Cell], sheet: &Sheet) -> Kind {
    let numbers = line
        .iter()
        .filter(|cell| sheet.number(cell).is_some() || sheet.is_unclear(cell));
    let numbers = numbers.count();
    let texts = line.iter().filter(|cell| !is_missing(&cell.text)).count() - numbers;
    if numbers >= 2 && numbers >= texts {
        Kind::Numbers
    } else if numbers == 0 && texts >= 2 {
        Kind::Texts
    } else {
        Kind::Title
    }
}

/// Returns true if most texts of the line are units. The unit of a channel need not be a unit of a K&C curve.
fn is_units(line: &[Cell]) -> bool {
    let words = line.iter().map(|cell| unbracketed(&cell.text));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let units = words.iter().filter(|word| is_unit(word)).count();
    2 * units > words.len() && words.iter().any(|word| !is_missing(word))
}

/// Returns true if a text occurs twice in the line.
fn is_repeating(line: &[Cell]) -> bool {
    let mut words: Vec<String> = line.iter().map(|cell| folded(&cell.text)).collect();
    words.retain(|word| !word.is_empty());
    let all = words.len();
    words.sort_unstable();
    words.dedup();
    words.len() < all
}

/// Returns the cells with text of several lines.
fn texts(lines: &[&Vec<Cell>]) -> Vec<Cell> {
    let cells = lines.iter().flat_map(|line| line.iter());
    cells
        .filter(|cell| !cell.text.is_empty())
        .cloned()
        .collect()
}

fn span_of(line: &[Cell]) -> Span {
    match (line.first(), line.last()) {
        (Some(first), Some(last)) => first.span.join(last.span),
        _ => Span::at(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sheets;
    use admire_syntax::text::Source;

    fn found(text: &str) -> Vec<Block> {
        let (options, mut out) = (FileOptions::default(), Vec::new());
        let source = Source::new("lab.csv", text);
        let all = sheets(&source, &options, &mut out).unwrap();
        let blocks = blocks(&all[0], 0, &options, &mut out);
        assert!(out.is_empty(), "{out:?}");
        blocks
    }

    fn names(block: &Block) -> Vec<&str> {
        let names = block.headings.iter().map(|heading| heading.name.as_str());
        names.collect()
    }

    #[test]
    fn titles_headings_and_units_are_told_apart() {
        let all = found(
            "K&C rig 2;;\nDate;12.03.2026;\nWheel load;4500;\n\nTravel;Toe;Note;U\nmm;min;-;V\n-10;1,5;a;1\n0;0,5;b;1\n10;n/a;c;1\n",
        );
        assert_eq!(all.len(), 1);
        assert_eq!(names(&all[0]), ["Travel", "Toe", "Note", "U"]);
        assert_eq!(all[0].headings[1].unit.as_deref(), Some("min"));
        assert_eq!(all[0].header_lines, [5, 6]);
        assert_eq!(all[0].rows.len(), 3);
        assert!(all[0].titles.iter().any(|cell| cell.text == "K&C rig 2"));
    }

    #[test]
    fn a_title_between_rows_begins_another_block() {
        let all = found("Hub\nz;toe\n1;2\n3;4\nWank\n5;6\nLenken\nz;toe;steer\n7;8;9\n1;1;1\n");
        let rows: Vec<usize> = all.iter().map(|block| block.rows.len()).collect();
        assert_eq!(rows, [2, 1, 2]);
        assert_eq!(names(&all[1]), ["z", "toe"]);
        assert_eq!(names(&all[2]), ["z", "toe", "steer"]);
        let titles: Vec<&str> = all.iter().map(|b| b.titles[0].text.as_str()).collect();
        assert_eq!(titles, ["Hub", "Wank", "Lenken"]);
    }

    #[test]
    fn groups_tell_repeated_names_apart() {
        let all = found("Left,,Right,\nToe,Camber,Toe,Camber\n1,2,3,4\n5,6,7,8\n");
        assert_eq!(
            names(&all[0]),
            ["Left Toe", "Left Camber", "Right Toe", "Right Camber"]
        );
        let all = found("Toe,Toe\n1,2\n3,4\n");
        assert_eq!(names(&all[0]), ["Toe", "Toe #2"]);
    }

    #[test]
    fn lines_of_the_header_may_be_stated() {
        let options = FileOptions {
            header: vec![2],
            units: Some(1),
            ..FileOptions::default()
        };
        let mut out = Vec::new();
        let source = Source::new("lab.csv", "mm;deg\n2;3\n1;2\n3;4\n");
        let all = sheets(&source, &options, &mut out).unwrap();
        let blocks = blocks(&all[0], 0, &options, &mut out);
        assert_eq!(names(&blocks[0]), ["2", "3"]);
        assert_eq!(blocks[0].headings[1].unit.as_deref(), Some("deg"));
        assert_eq!(blocks[0].rows.len(), 2);
    }
}
