use std::path::PathBuf;

use admire_report::TopologyGraph;
use admire_syntax::Dataset;

use super::Outcome;
use super::shell::{Exit, Shell};

/// Draw which bodies a dataset has and what joins them.
///
/// An SVG picture, with the ground at the bottom, constraints as lines and forces dashed; with --dot the same as text for Graphviz.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// As text for Graphviz (`dot -Tpdf`), not as a picture.
    #[arg(long)]
    dot: bool,
    /// Where to write it; standard output if absent.
    #[arg(long, short)]
    out: Option<PathBuf>,
}

const EXAMPLES: &str = "Examples:
  admire graph deck.adm -o deck.svg
  admire graph deck.adm --dot | dot -Tpdf -o deck.pdf";

/// Writes the graph.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let graph = TopologyGraph::of(&Dataset::parse(source).value);
    let text = if arguments.dot {
        graph.dot()
    } else {
        graph.svg()
    };
    shell.deliver(arguments.out.as_deref(), text.as_bytes())?;
    Ok(Exit::Fine)
}
