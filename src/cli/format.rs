/// Output format of diagnostics.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub(super) enum Format {
    /// Text with the lines of the file and the place marked.
    Text,
    /// One line per message: `file:line:column: severity[code]: message`.
    Plain,
    /// One JSON array of all messages.
    Json,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Workflow commands of GitHub, shown as annotations in a pull request.
    Github,
}
