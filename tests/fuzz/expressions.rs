//! Fuzz targets for function expressions and for short texts of the command line.

use std::sync::LazyLock;

use admire_rig::Scatter;
use admire_solver::function::{EvaluationMemory, ExpressionCompiler, ProgramNumbers};
use admire_solver::model::Model;
use admire_syntax::expression::Node;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset, Expression};

use crate::harness::fuzz;
use crate::mutation::function_words;
use crate::seeds;

const MODEL: &str = "t\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2, QP=1,2,3\n\
    VARIABLE/1, FUNCTION=TIME\nSPLINE/1, X=1,2,3,4,5, Y=1,4,9,16,25\nARRAY/1, IC, SIZE=2, NUMBERS=1,2\n\
    BUSHING/1, I=20, J=1, K=1,1,1, KT=1,1,1\nEND\n";

static DATASET: LazyLock<Dataset> =
    LazyLock::new(|| Dataset::parse(Source::new("a.adm", MODEL)).value);
static LOWERED: LazyLock<Model> = LazyLock::new(|| Model::lower(&DATASET).value);

/// Checks an expression: its spans lie inside the text, its own text parses to the same tree, and evaluation with and without derivatives
/// agrees.
pub fn expression(bytes: &[u8]) {
    let model = &*LOWERED;
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let read = match Expression::parse_str(text) {
        Ok(read) => read,
        Err(diagnostic) => {
            for label in &diagnostic.labels {
                assert!(label.span.end() <= text.len(), "{diagnostic:?}");
            }
            return;
        }
    };
    assert!(
        read.literals
            .iter()
            .all(|number| number.span.end() <= text.len())
    );
    let again = Expression::parse_str(&read.text).expect("its own text is an expression");
    assert_eq!(shape(&again.root), shape(&read.root), "{}", read.text);
    let values = |of: &Expression| -> Vec<u64> {
        of.literals
            .iter()
            .map(|number| number.value.to_bits())
            .collect()
    };
    assert_eq!(values(&again), values(&read), "{}", read.text);
    assert_eq!(again.text, read.text);
    let compiler = ExpressionCompiler::new(model);
    let Ok(program) = compiler.compile(&read) else {
        return;
    };
    let literals: Vec<f64> = read.literals.iter().map(|number| number.value).collect();
    let curves = compiler.curves();
    let numbers = ProgramNumbers {
        literals: &literals,
        curves: &curves,
    };
    let mut scratch = EvaluationMemory::default();
    let (mut by_input, mut by_literal) =
        (vec![0.0; program.inputs.len()], vec![0.0; literals.len()]);
    for at in [0.0, 0.3, -1e300, f64::MIN_POSITIVE, f64::NAN] {
        let inputs = vec![at; program.inputs.len()];
        let value = program.eval(&inputs, numbers, &mut scratch);
        let with = program.eval_with_derivatives(
            &inputs,
            numbers,
            &mut scratch,
            &mut by_input,
            &mut by_literal,
        );
        match (value, with) {
            (Ok(a), Ok(b)) => assert!(
                a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
                "{a} {b}"
            ),
            (a, b) => assert_eq!(a.is_ok(), b.is_ok(), "{a:?} {b:?}"),
        }
    }
}

/// Returns the structure of a tree without the spans.
fn shape(node: &Node) -> String {
    let own = match node {
        Node::Literal(at) => format!("literal {at}"),
        Node::Binary(operator, ..) => format!("{operator:?}"),
        Node::Call { function, .. } | Node::Name(function) => function.name.to_string(),
        other => format!("{:?}", std::mem::discriminant(other)),
    };
    let children: Vec<String> = node.children().into_iter().map(shape).collect();
    format!("{own}({})", children.join(","))
}

/// Checks that an address is reproduced from its own text, and that reading, setting and removing it never panics.
pub fn address(bytes: &[u8]) {
    let dataset = &*DATASET;
    let text = String::from_utf8_lossy(bytes);
    _ = Scatter::parse(&text);
    let Ok(address) = Address::parse(&text, dataset) else {
        return;
    };
    let again = Address::parse(&address.to_string(), dataset);
    assert_eq!(again.as_ref(), Ok(&address), "{text}");
    dataset.value_at(&address);
    _ = dataset.set(&address, 3.0);
    _ = dataset.set_text(&address, "TIME");
    _ = dataset.remove(&address);
}

#[test]
fn expressions() {
    let seeds: Vec<Vec<u8>> = seeds::EXPRESSIONS
        .map(|text| text.as_bytes().to_vec())
        .into();
    fuzz("expression", 20_000, &seeds, &function_words());
}

#[test]
fn texts_of_the_command_line() {
    let seeds = [
        "BUSHING/1.K.2",
        "MARKER/20.QP.1",
        "PART/2.MASS",
        "VARIABLE/1.FUNCTION.2",
        "tails=3,outliers=6,outlier_size=2,declared=0.5",
    ];
    let seeds: Vec<Vec<u8>> = seeds.map(|text| text.as_bytes().to_vec()).into();
    let words = [
        "BUSHING",
        "/",
        ".",
        "FUNCTION",
        "outliers=",
        "K",
        "MARKER",
        "4294967296",
    ]
    .map(String::from);
    fuzz("address", 5000, &seeds, &words);
}
