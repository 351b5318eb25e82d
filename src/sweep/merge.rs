//! Merging of the part files of all shards into one table.

use admire_syntax::diagnostic::{Code, Diagnostic};

use super::checksum::verify;
use super::engine::SweepError;
use super::folder::SweepFolder;
use super::shard::Shard;
use super::table_reader::TableReader;
use super::table_writer::{Layout, OTHER_COLUMNS, TableWriter};

/// Columns of a table between `case` and `status`: inputs, then outputs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Columns {
    /// Names of the varied parameters.
    pub inputs: Vec<String>,
    /// Names of the recorded outputs.
    pub outputs: Vec<String>,
}

impl Columns {
    /// Splits the columns of a table, given its number of inputs.
    pub fn of(table: &TableReader, inputs: usize) -> Self {
        let all = table.columns();
        let last = all.len() + 1 - OTHER_COLUMNS.len();
        Self {
            inputs: all[1..=inputs].to_vec(),
            outputs: all[1 + inputs..last].to_vec(),
        }
    }
}

/// Joins the part files into the complete table. Does nothing if the complete table already exists and is intact.
///
/// # Errors
/// Diagnostics for missing or unfinished shards, parts of another version or of other inputs, parts with missing cases, and files that
/// cannot be read or written.
pub fn merge(folder: &SweepFolder) -> Result<(), Vec<Diagnostic>> {
    let whole = folder.results();
    if whole.is_file() {
        return verify(&whole).map_err(|damage| {
            let message = format!("`{}`: {damage}", whole.display());
            let refused = Diagnostic::error(Code::CannotRead, message);
            vec![refused.help("delete the file to join the parts again")]
        });
    }
    let inputs = folder.manifest.vary.len();
    let mut wrong = Vec::new();
    let mut missing = Vec::new();
    let mut first: Option<Columns> = None;
    for shard in folder.shards() {
        let path = folder.part(shard);
        if !path.is_file() {
            missing.push(if folder.journal(shard).is_file() {
                format!("{shard} (begun)")
            } else {
                shard.to_string()
            });
            continue;
        }
        let mut refuse = |code: Code, why: String| {
            wrong.push(Diagnostic::error(
                code,
                format!("`{}`: {why}", path.display()),
            ));
        };
        if let Err(damage) = verify(&path) {
            refuse(
                Code::CannotRead,
                format!("{damage}; delete the file, and `--shard {shard}` runs its cases again"),
            );
            continue;
        }
        let table = match TableReader::open(&path) {
            Ok(table) => table,
            Err(error) => {
                refuse(Code::CannotRead, error.to_string());
                continue;
            }
        };
        for (key, own, what) in [
            (
                "admire.version",
                &folder.manifest.version,
                "version of admire",
            ),
            (
                "admire.inputs_sha256",
                &folder.manifest.inputs_sha256,
                "checksum of the inputs",
            ),
        ] {
            let there = table.fact(key).unwrap_or("none");
            if there != own {
                refuse(
                    Code::ConflictingArguments,
                    format!("the {what} is {there}, but that of the sweep is {own}"),
                );
            }
        }
        let cases = shard.cases(folder.manifest.cases);
        if table.rows() != cases.end - cases.start {
            refuse(
                Code::WrongCount,
                format!(
                    "the table should have one row per case (rows: {}, cases: {})",
                    table.rows(),
                    cases.end - cases.start
                ),
            );
            continue;
        }
        let columns = Columns::of(&table, inputs);
        if *first.get_or_insert_with(|| columns.clone()) != columns {
            refuse(
                Code::WrongCount,
                "the columns differ from those of the first part".to_string(),
            );
        }
    }
    if !missing.is_empty() {
        let (count, shown) = (missing.len(), 20.min(missing.len()));
        let more = if count > shown {
            format!(" and {} more", count - shown)
        } else {
            String::new()
        };
        wrong.push(
            Diagnostic::error(
                Code::CannotRead,
                format!("unfinished shards: {}{more}", missing[..shown].join(", ")),
            )
            .help("the same command with --shard continues where it stopped"),
        );
    }
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let Some(columns) = first else {
        return Ok(());
    };
    join(folder, &columns).map_err(|error| {
        vec![Diagnostic::error(
            Code::CannotWrite,
            format!(
                "`{}` cannot be written: {error}",
                folder.results().display()
            ),
        )]
    })
}

fn join(folder: &SweepFolder, columns: &Columns) -> Result<(), SweepError> {
    if folder.manifest.shards == 1 {
        std::fs::rename(folder.part(Shard::WHOLE), folder.results())
            .map_err(parquet::errors::ParquetError::from)?;
        return Ok(());
    }
    let first = TableReader::open(&folder.part(Shard {
        number: 1,
        of: folder.manifest.shards,
    }))?;
    let fact = |key: &str| {
        (
            key.to_string(),
            first.fact(key).unwrap_or_default().to_string(),
        )
    };
    let layout = Layout {
        inputs: columns.inputs.clone(),
        outputs: columns.outputs.clone(),
        version: folder.manifest.version.clone(),
        hash: folder.manifest.inputs_sha256.clone(),
        facts: vec![
            fact("admire.version"),
            fact("admire.inputs_sha256"),
            ("admire.shard".to_string(), Shard::WHOLE.to_string()),
            fact("admire.units"),
            fact("admire.nominal"),
        ],
    };
    let mut whole = TableWriter::create(&folder.results(), layout)?;
    let mut next = 0;
    for shard in folder.shards() {
        let part = TableReader::open(&folder.part(shard))?;
        part.each(
            columns.inputs.len(),
            columns.outputs.len(),
            |row, numbers| -> Result<(), SweepError> {
                if row.case != next {
                    let message = format!(
                        "shard {shard} has case {} in place of case {next}; run this shard again",
                        row.case
                    );
                    return Err(parquet::errors::ParquetError::General(message).into());
                }
                next += 1;
                Ok(whole.add(row, numbers)?)
            },
        )?;
    }
    whole.finish()?;
    Ok(())
}
