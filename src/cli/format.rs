/// Output format of diagnostics.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub(super) enum Format {
    /// With the lines of the file and the place marked.
    Text,
    /// One line each: `file:line:column: severity[code]: message`.
    Plain,
    /// One JSON array.
    Json,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Workflow commands of GitHub: annotations in a pull request.
    Github,
}
