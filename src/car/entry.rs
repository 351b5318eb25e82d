//! Addresses of the values in a TeimOrbit file.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map;

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::nearest;
use admire_syntax::property::{Block, Cell, PropertyFile, Table};
use admire_syntax::text::{Source, Span};

use crate::settings::ADDRESS_NAME_CHARACTERS;

/// One value of a file with its address.
///
/// A parameter has the address `BLOCK.KEY`, a cell of a table `BLOCK/ROW.COLUMN`. A row is named by its first cell if this is a text, otherwise by
/// its number from 1. A column is named by the heading, or by its number. A block that occurs several times is named by its USAGE:
/// `PART_ASSEMBLY/upright.MASS`. A part of a block is `BLOCK(PART)`. If several blocks, rows or keys have the same name, the second one is followed
/// by `#2`.
#[derive(Clone, PartialEq, Debug)]
pub struct Entry {
    /// Address of the value.
    pub address: String,
    /// The value and its location.
    pub cell: Cell,
    /// Index of the value's block among the blocks of the file.
    pub block: usize,
}

impl Entry {
    /// Returns the value as text, without quotes and surrounding blanks.
    pub fn text<'s>(&self, source: &'s Source) -> Cow<'s, str> {
        self.cell.text(source)
    }
}

/// Numbers names that occur several times: the second is `name#2`.
#[derive(Default)]
struct Names {
    /// Number of occurrences of each name in lower case, and the names assigned so far.
    count: HashMap<String, usize>,
}

impl Names {
    fn unique(&mut self, name: String) -> String {
        let lower = name.to_ascii_lowercase();
        let Some(count) = self.count.get_mut(&lower) else {
            self.count.insert(lower, 1);
            return name;
        };
        *count += 1;
        let mut number = *count;
        // A name in the file may itself end in `#2`.
        loop {
            let given = format!("{lower}#{number}");
            if let hash_map::Entry::Vacant(free) = self.count.entry(given) {
                free.insert(1);
                self.count.insert(lower, number);
                return format!("{name}#{number}");
            }
            number += 1;
        }
    }
}

/// Returns the beginning of a name. A malicious file may contain a name of a million characters.
fn cut(name: &str) -> &str {
    match name.char_indices().nth(ADDRESS_NAME_CHARACTERS) {
        Some((at, _)) => &name[..at],
        None => name,
    }
}

/// Returns all values of a file with their addresses, in the order of the file.
pub fn entries(file: &PropertyFile) -> Vec<Entry> {
    let source = file.source();
    let mut count: HashMap<(&str, Option<&str>), usize> = HashMap::new();
    for block in &file.blocks {
        *count.entry(key(block)).or_default() += 1;
    }
    let mut labels = Names::default();
    let mut out = Vec::new();
    // A part belongs to the block above it, and has the label of that block.
    let mut above = String::new();
    for (at, block) in file.blocks.iter().enumerate() {
        let label = if let Some(part) = &block.part {
            format!("{above}({})", cut(part))
        } else {
            let name = cut(&block.name).to_string();
            let usage = block.parameter("USAGE").map(|usage| usage.text(source));
            match usage.filter(|_| count.get(&key(block)).is_some_and(|count| *count > 1)) {
                Some(usage) if !usage.is_empty() => format!("{name}/{}", cut(&usage)),
                _ => name,
            }
        };
        let label = labels.unique(label);
        if block.part.is_none() {
            above.clone_from(&label);
        }
        let mut keys = Names::default();
        for parameter in &block.parameters {
            let key = keys.unique(cut(&parameter.name).to_string());
            out.push(Entry {
                address: format!("{label}.{key}"),
                cell: parameter.value,
                block: at,
            });
        }
        let mut rows = Names::default();
        for table in &block.tables {
            of_table(source, table, (&label, at), &mut rows, &mut out);
        }
    }
    // The name of a block may equal the name of a row in another block.
    let mut addresses = Names::default();
    for entry in &mut out {
        entry.address = addresses.unique(std::mem::take(&mut entry.address));
    }
    out
}

fn key(block: &Block) -> (&str, Option<&str>) {
    (&block.name, block.part.as_deref())
}

fn of_table(
    source: &Source,
    table: &Table,
    (label, block): (&str, usize),
    rows: &mut Names,
    out: &mut Vec<Entry>,
) {
    let mut number = 0;
    let mut row_label = String::new();
    for row in &table.rows {
        let is_remark = table.is_remark(row) && !row_label.is_empty();
        if !is_remark {
            number += 1;
            let named = match row.first() {
                Some(cell @ Cell::Text(_)) if row.len() > 1 => Some(cell.text(source)),
                _ => None,
            };
            row_label = rows.unique(match named {
                Some(name) if !name.is_empty() => cut(&name).to_string(),
                _ => number.to_string(),
            });
        }
        let mut columns = Names::default();
        for (k, cell) in row.iter().enumerate() {
            let column = if is_remark {
                "remark".to_string()
            } else {
                let heading = table.columns.get(k).filter(|name| !name.is_empty());
                heading.map_or_else(|| (k + 1).to_string(), |name| cut(name).to_string())
            };
            let column = columns.unique(column);
            out.push(Entry {
                address: format!("{label}/{row_label}.{column}"),
                cell: *cell,
                block,
            });
        }
    }
}

/// Returns the values at an address, in the order of the file. `*` matches any text. The name of a block or row selects all its values. Case is
/// ignored.
///
/// # Errors
/// `undefined-id` if nothing matches. The help names the nearest address, or the blocks of the file.
pub fn select(file: &PropertyFile, text: &str) -> Result<Vec<Entry>, Diagnostic> {
    let wanted = text.trim().to_ascii_lowercase();
    let exact = text.to_ascii_lowercase();
    let all = entries(file);
    let chosen = |fits: &dyn Fn(&str) -> bool| -> Vec<Entry> {
        all.iter()
            .filter(|entry| fits(&entry.address.to_ascii_lowercase()))
            .cloned()
            .collect()
    };
    let mut found = chosen(&|address| address == wanted || address == exact);
    if found.is_empty() && wanted.contains('*') {
        found = chosen(&|address| matches(wanted.as_bytes(), address.as_bytes()));
    }
    if found.is_empty() && !wanted.is_empty() {
        found = chosen(&|address| {
            let rest = address.strip_prefix(wanted.as_str());
            rest.is_some_and(|rest| rest.starts_with(['.', '/', '(', '#']))
        });
    }
    if !found.is_empty() {
        return Ok(found);
    }
    let capitals: Vec<String> = all
        .iter()
        .map(|entry| entry.address.to_ascii_uppercase())
        .collect();
    let near = nearest(text, capitals.iter().map(String::as_str)).and_then(|near| {
        let at = capitals.iter().position(|address| address == near)?;
        Some(&all[at].address)
    });
    let help = near.map_or_else(
        || {
            let mut blocks: Vec<&str> = file.blocks.iter().map(|b| cut(&b.name)).collect();
            blocks.dedup();
            blocks.truncate(12);
            format!(
                "write BLOCK.KEY or BLOCK/ROW.COLUMN; the blocks of the file are {}",
                blocks.join(", ")
            )
        },
        |near| format!("did you mean `{near}`?"),
    );
    let message = format!("`{}` has no `{text}`", file.source().name());
    Err(Diagnostic::error(Code::UndefinedId, message)
        .label(file.source().name(), Span::at(0), "")
        .help(help))
}

/// Returns true if a text matches a pattern in which `*` matches any text. The time is at most proportional to the product of both lengths.
fn matches(pattern: &[u8], text: &[u8]) -> bool {
    let (mut p, mut t) = (0, 0);
    // Position after the last star, and the position in the text up to which this star matches.
    let mut retry: Option<(usize, usize)> = None;
    while t < text.len() {
        if pattern.get(p) == Some(&b'*') {
            retry = Some((p + 1, t));
            p += 1;
        } else if pattern.get(p) == Some(&text[t]) {
            p += 1;
            t += 1;
        } else if let Some((behind, reach)) = retry {
            retry = Some((behind, reach + 1));
            p = behind;
            t = reach + 1;
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|byte| *byte == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[MDI_HEADER]\nFILE_TYPE = 'asy'\n(COMMENTS)\n{comment_string}\n'an assembly'\n[UNITS]\nLENGTH='mm'\n\
        [PARAMETER]\n{parameter_name symmetry type value}\n'lag  ' 'single' 'real' 0.1\n 'a delay'\n'lag' 'left' 'real' 2\n\
        [PART]\nUSAGE='arm'\nMASS=1\n[PART]\nUSAGE='arm'\nMASS=2\nMASS=3\n[PART]\nUSAGE='rod'\nMASS=4\n[CURVE]\n-1 -10\n1 10\n";

    fn file() -> PropertyFile {
        let read = PropertyFile::parse(Source::new("a.asy", TEXT));
        assert_eq!(read.diagnostics, []);
        read.value
    }

    #[test]
    fn every_value_has_an_address_of_its_own() {
        let file = file();
        let shown: Vec<String> = entries(&file)
            .iter()
            .map(|entry| format!("{}={}", entry.address, entry.text(file.source())))
            .collect();
        assert_eq!(
            shown,
            [
                "MDI_HEADER.FILE_TYPE=asy",
                "MDI_HEADER(COMMENTS)/1.comment_string=an assembly",
                "UNITS.LENGTH=mm",
                "PARAMETER/lag.parameter_name=lag",
                "PARAMETER/lag.symmetry=single",
                "PARAMETER/lag.type=real",
                "PARAMETER/lag.value=0.1",
                "PARAMETER/lag.remark=a delay",
                "PARAMETER/lag#2.parameter_name=lag",
                "PARAMETER/lag#2.symmetry=left",
                "PARAMETER/lag#2.type=real",
                "PARAMETER/lag#2.value=2",
                "PART/arm.USAGE=arm",
                "PART/arm.MASS=1",
                "PART/arm#2.USAGE=arm",
                "PART/arm#2.MASS=2",
                "PART/arm#2.MASS#2=3",
                "PART/rod.USAGE=rod",
                "PART/rod.MASS=4",
                "CURVE/1.1=-1",
                "CURVE/1.2=-10",
                "CURVE/2.1=1",
                "CURVE/2.2=10",
            ]
        );
    }

    #[test]
    fn an_address_selects_one_value_a_row_a_block_or_a_pattern() {
        let file = file();
        let count = |text: &str| select(&file, text).map_or(0, |found| found.len());
        for (text, expected) in [
            ("parameter/LAG.value", 1),
            ("PARAMETER/lag", 9),
            ("PART/*.mass", 3),
            ("CURVE", 4),
            ("*", 23),
            ("*.MASS*", 4),
            ("", 0),
            ("PART/ar", 0),
        ] {
            assert_eq!(count(text), expected, "{text}");
        }
        let refused = select(&file, "PARAMETER/lag.valu").unwrap_err();
        assert_eq!(
            refused.help.as_deref(),
            Some("did you mean `PARAMETER/lag.value`?")
        );
    }
}
