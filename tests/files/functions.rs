//! Tests of the functions of all real decks: each is parsed, and either compiled or refused by name.

use std::collections::BTreeMap;

use admire_solver::function::ExpressionCompiler;
use admire_solver::model::Model;
use admire_syntax::text::Source;
use admire_syntax::{Dataset, Value};

use crate::common::{files_below, shared};

#[test]
fn functions_of_real_decks_compile_or_are_refused_by_name() {
    let Some(folder) = shared("real-decks") else {
        return;
    };
    let mut compiled = 0;
    let mut refused: BTreeMap<String, usize> = BTreeMap::new();
    for path in files_below(&folder, "adm") {
        let bytes = std::fs::read(&path).expect("readable deck");
        let dataset = Dataset::parse(Source::new(path.display().to_string(), bytes)).value;
        let model = Model::lower(&dataset).value;
        let compiler = ExpressionCompiler::new(&model);
        for statement in dataset.statements() {
            for argument in &statement.arguments {
                let Value::Function(expression) = &argument.value else {
                    continue;
                };
                match compiler.compile(expression) {
                    Ok(_) => compiled += 1,
                    Err(refusal) => *refused.entry(refusal.message).or_default() += 1,
                }
            }
        }
    }
    // Only the deck of a feeding machine uses contact forces, which the built-in solver does not compute.
    assert!(compiled >= 2159, "{compiled}");
    let expected = [(
        "CONTACT: the built-in solver does not solve the element".to_string(),
        7,
    )];
    assert_eq!(refused, BTreeMap::from(expected));
}
