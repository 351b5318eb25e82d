use std::path::PathBuf;

use admire_report::TopologyGraph;
use admire_syntax::Dataset;

use super::Outcome;
use super::shell::{Exit, Shell};

/// Draw the bodies of a dataset and the connections between them.
///
/// The output is an SVG picture, with the ground at the bottom, constraints as solid lines and forces as dashed lines. With --dot, the same
/// graph is written as text for Graphviz.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Write text for Graphviz (`dot -Tpdf`) instead of a picture.
    #[arg(long)]
    dot: bool,
    /// File to write; by default, standard output.
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
