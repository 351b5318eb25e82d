//! Options of OUTPUT and RESULTS that request output which this solver does not write.

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Dataset, Statement};

/// Options of OUTPUT that have no effect here, with descriptions of the output that ADAMS writes for them.
const OUTPUT: [(&str, &str); 11] = [
    ("GR521SAV", "a graphics file in an old format"),
    ("ICSAVE", "a file of the states at every output step"),
    ("MATSAVE", "a file for MATLAB"),
    ("DACSAVE", "a DAC file"),
    ("RPCSAVE", "an RPC III file"),
    ("CHART", "charts in the tabular output"),
    ("OSFORMAT", "a table after every output step"),
    ("DSCALE", "scaled displacements"),
    ("VSCALE", "scaled velocities"),
    ("ASCALE", "scaled accelerations"),
    ("FSCALE", "scaled forces"),
];

/// Options of RESULTS by which ADAMS shortens numbers; they have no effect here.
const DIGITS: [&str; 3] = ["ROUNDOFF", "SIGNIFICANTFIGURES", "ZEROTHRESHOLD"];

/// Returns a warning for each option of a dataset that requests output which is not written.
///
/// Without the option XRF, ADAMS writes a results file as text or, by default, in binary form (help page `fstate_results`). Only the
/// displacements of parts are documented in these layouts. An XML file is therefore written instead, with a warning.
pub(super) fn not_written(dataset: &Dataset) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut warn = |statement: &Statement, option: Option<&str>, what: &str, help: Option<&str>| {
        let span = option
            .and_then(|name| statement.argument(name))
            .map_or(statement.keyword, |argument| argument.span);
        let mut warning = Diagnostic::warning(Code::OutputNotWritten, what.to_string());
        warning = warning.label(dataset.source().name(), span, "");
        if let Some(help) = help {
            warning = warning.help(help);
        }
        found.push(warning);
    };
    if let Some(output) = dataset.statement("OUTPUT", None) {
        for (option, what) in OUTPUT {
            if output.has(option) {
                let said = format!("OUTPUT/{option} asks for {what}, which is not written");
                warn(output, Some(option), &said, None);
            }
        }
    }
    if let Some(results) = dataset.statement("RESULTS", None) {
        for option in DIGITS {
            if results.has(option) {
                let said = format!("RESULTS/{option} is ignored: numbers are not shortened");
                warn(
                    results,
                    Some(option),
                    &said,
                    Some("DECIMALPLACES sets the number of digits after the decimal point"),
                );
            }
        }
    }
    if let Some(results) = dataset.statement("RESULTS", None)
        && !results.has("XRF")
    {
        let (option, kind) = if results.has("FORMATTED") {
            (Some("FORMATTED"), "plain text")
        } else {
            (
                results.has("UNFORMATTED").then_some("UNFORMATTED"),
                "binary",
            )
        };
        warn(
            results,
            option,
            &format!("without XRF, ADAMS writes a {kind} results file; admire writes XML"),
            Some("with RESULTS/XRF, ADAMS writes the same columns in XML"),
        );
    }
    found
}
