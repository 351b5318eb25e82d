//! Opening of results files, shared by several commands.

use std::path::Path;

use super::shell::{Exit, Shell};
use admire_results::{AnyResults, ResultsError, ResultsReader, Selection, open_any};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::grammar::nearest;

/// Opens a results file of any readable kind, and prints its diagnostics.
pub(super) fn open(path: &Path, shell: &Shell) -> Result<AnyResults, Exit> {
    let opened = open_silently(path, shell)?;
    shell.complain(&opened.diagnostics);
    Ok(opened.value)
}

/// Opens a results file. Diagnostics are printed only if it cannot be opened.
pub(super) fn open_silently(path: &Path, shell: &Shell) -> Result<Checked<AnyResults>, Exit> {
    open_any(path).map_err(|error| match error {
        ResultsError::Io(error) => shell.fail(Diagnostic::error(
            Code::CannotRead,
            format!("`{}` cannot be read: {error}", path.display()),
        )),
        refusal @ ResultsError::Refused(_) => refused(refusal, shell),
    })
}

/// Reports why a file cannot be read further.
pub(super) fn refused(error: ResultsError, shell: &Shell) -> Exit {
    shell.fail(error.into_diagnostic())
}

/// Selects the columns that match patterns; it is an error if a pattern matches no column.
pub(super) fn selection(
    reader: &dyn ResultsReader,
    patterns: &[String],
    shell: &Shell,
) -> Result<Selection, Exit> {
    let patterns: Vec<&str> = patterns.iter().map(String::as_str).collect();
    let (selection, unused) = Selection::matching(reader.catalogue(), &patterns);
    let Some(pattern) = unused.first() else {
        return Ok(selection);
    };
    let paths: Vec<String> = Selection::all(reader.catalogue())
        .columns
        .into_iter()
        .map(|column| column.path)
        .collect();
    let capitals: Vec<String> = paths.iter().map(|path| path.to_uppercase()).collect();
    let near = nearest(pattern, capitals.iter().map(String::as_str))
        .and_then(|near| capitals.iter().position(|path| path == near));
    Err(shell.fail(
        Diagnostic::error(
            Code::UndefinedId,
            format!("the file has no column `{pattern}`"),
        )
        .help(match near {
            Some(at) => format!("did you mean `{}`?", paths[at]),
            None => "`admire results FILE --list` lists the columns".to_string(),
        }),
    ))
}
