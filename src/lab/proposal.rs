//! Proposal of a mapping from the headings alone.

use super::block::Block;
use super::characteristic::Target;
use super::column::Column;
use super::file_options::FileOptions;
use super::heading::{Heading, folded};
use super::mapping::Mapping;
use super::open_point::OpenPoint;
use super::sheet::Sheet;
use super::words;

/// Number of times that a question is asked before the interview ends.
const ATTEMPTS: usize = 3;

impl Mapping {
    /// Returns a mapping of all columns whose headings name a known characteristic, in the order of the file. It contains only what the headings
    /// state.
    pub fn proposed(blocks: &[Block], file: FileOptions) -> Self {
        let mut columns: Vec<Column> = Vec::new();
        for block in blocks {
            for heading in &block.headings {
                let name = name_of(heading, block);
                let known = columns.iter().any(|own| folded(&own.name) == folded(name));
                if let (Some(is), false) = (words::target(&heading.name), known) {
                    columns.push(entry(name, heading, is));
                }
            }
        }
        Self {
            file,
            columns,
            ..Self::default()
        }
    }

    /// Asks the user about all open points of the blocks and this mapping, and which further columns to import. `ask` shows a question and returns
    /// the reply, or `None` at the end of input. Returns false if a question was not answered.
    #[must_use]
    pub fn complete(
        &mut self,
        blocks: &[Block],
        sheets: &[Sheet],
        ask: &mut dyn FnMut(&str) -> Option<String>,
    ) -> bool {
        if !self.add_columns(blocks, ask) {
            return false;
        }
        let mut left: Option<(OpenPoint, usize)> = None;
        loop {
            let Some(point) = self.open(blocks, sheets).into_iter().next() else {
                return true;
            };
            let attempts = match &left {
                Some((last, attempts)) if *last == point => attempts + 1,
                _ => 1,
            };
            if attempts > ATTEMPTS {
                return false;
            }
            let Some(reply) = ask(&point.question(self, blocks)) else {
                return false;
            };
            // After an invalid reply, the point remains open and the question is repeated.
            let _ = point.answer(&reply, self);
            left = Some((point, attempts));
        }
    }

    /// Asks which columns to import in addition to the proposed ones. Returns false at the end of input.
    fn add_columns(
        &mut self,
        blocks: &[Block],
        ask: &mut dyn FnMut(&str) -> Option<String>,
    ) -> bool {
        let mut others: Vec<(&Block, &Heading)> = Vec::new();
        for block in blocks {
            for heading in &block.headings {
                let name = name_of(heading, block);
                let is_known = self
                    .columns
                    .iter()
                    .any(|own| folded(&own.name) == folded(name))
                    || others
                        .iter()
                        .any(|(_, other)| other.written == heading.written);
                if !is_known && !heading.written.is_empty() {
                    others.push((block, heading));
                }
            }
        }
        if others.is_empty() {
            return true;
        }
        let list: Vec<String> = others
            .iter()
            .enumerate()
            .map(|(k, (_, heading))| format!("{} `{}`", k + 1, heading.written))
            .collect();
        let question = format!(
            "other columns: {}\nimport some of them, by number: 1, 2? [none]",
            list.join(", ")
        );
        let Some(reply) = ask(&question) else {
            return false;
        };
        for word in reply.split([',', ' ']) {
            let number = word.parse::<usize>().ok();
            let Some((block, heading)) = number.and_then(|k| others.get(k.checked_sub(1)?)) else {
                continue;
            };
            for _ in 0..ATTEMPTS {
                let question = format!(
                    "what is `{}`: {}, or `load NAME` for a column of the load cases?",
                    heading.written,
                    Target::words().join(", ")
                );
                let Some(reply) = ask(&question) else {
                    return false;
                };
                let name = name_of(heading, block);
                if let Some(load) = reply.trim().strip_prefix("load ") {
                    self.columns.push(Column {
                        name: name.to_string(),
                        load: Some(load.trim().to_string()),
                        ..Column::default()
                    });
                    break;
                }
                if let Some(is) = Target::named(reply.trim()) {
                    self.columns.push(entry(name, heading, is));
                    break;
                }
            }
        }
        true
    }
}

/// Returns the name of a column in a mapping. The name omits the unit, unless another column of the block has the same name.
fn name_of<'a>(heading: &'a Heading, block: &Block) -> &'a str {
    let same = |other: &&Heading| other.name_key() == heading.name_key();
    if block.headings.iter().filter(same).count() > 1 {
        &heading.written
    } else {
        &heading.name
    }
}

fn entry(name: &str, heading: &Heading, is: Target) -> Column {
    let of = match is {
        Target::Characteristic(of) => Some(of),
        _ => None,
    };
    Column {
        name: name.to_string(),
        is: Some(is),
        side: of
            .filter(|of| of.is_sided())
            .and_then(|_| words::side(&heading.name)),
        positive: of.and_then(|of| words::sign(&heading.name, of).map(str::to_string)),
        ..Column::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{blocks, sheets};
    use admire_syntax::text::Source;

    fn tables(text: &str) -> (Vec<Sheet>, Vec<Block>) {
        let (options, mut out) = (FileOptions::default(), Vec::new());
        let source = Source::new("lab.csv", text);
        let sheets = sheets(&source, &options, &mut out).unwrap();
        let blocks = blocks(&sheets[0], 0, &options, &mut out);
        (sheets, blocks)
    }

    /// Everything that headings cannot state is asked once, and again after an invalid reply. The mapping then has no open point.
    #[test]
    fn an_interview_completes_a_mapping() {
        let text = "Parallelhub;;;\nFederweg VL;Spur VL [mm];Kraft X;Temp\nmm;;kN;\n-10;1,5;0,1;20\n10;-1,5;0,2;21\n";
        let (sheets, blocks) = tables(text);
        let mut mapping = Mapping::proposed(&blocks, FileOptions::default());
        assert_eq!(mapping.columns.len(), 2);
        let mut script = [
            ("other columns: 1 `Kraft X`, 2 `Temp`", "1"),
            ("what is `Kraft X`", "load Fx"),
            ("`Federweg VL`, wheel_travel: positive", "upwards"),
            ("`Federweg VL`, wheel_travel: positive", "up"),
            ("`Spur VL [mm]`, toe_angle: over_mm", "406,4"),
            ("`Spur VL [mm]`, toe_angle: positive", "in"),
            ("`Kraft X`, a load: load_sign", "-"),
        ]
        .into_iter();
        let mut ask = |question: &str| {
            let (asked, reply) = script.next().expect("a further question");
            assert!(question.starts_with(asked), "{question} is not {asked}");
            Some(reply.to_string())
        };
        assert!(mapping.complete(&blocks, &sheets, &mut ask));
        assert!(script.next().is_none());
        assert!(mapping.open(&blocks, &sheets).is_empty());
        assert_eq!(mapping.columns[1].over_mm, Some(406.4));
        assert_eq!(mapping.columns[2].load_sign, Some(-1.0));
    }

    #[test]
    fn an_interview_ends_with_the_input() {
        let (sheets, blocks) = tables("Sturz;Radhub\n1;2\n3;4\n");
        let mut mapping = Mapping::proposed(&blocks, FileOptions::default());
        assert!(!mapping.complete(&blocks, &sheets, &mut |_| None));
        let mut count = 0;
        let mut silent = |_: &str| {
            count += 1;
            Some(String::new())
        };
        assert!(!mapping.complete(&blocks, &sheets, &mut silent));
        assert_eq!(count, ATTEMPTS);
    }
}
