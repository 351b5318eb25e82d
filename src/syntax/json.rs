//! A dataset as JSON, and a changed JSON back as edits of the original text.

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json, json};

use super::{Address, Argument, Dataset, NewStatement, Statement, Value, spell_like};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::{Edit, Span};

/// The dataset as JSON: `title`, and `statements` with `kind`, `id`, `name` (the view name) and `arguments`. Numbers are in
/// model units (radians), flags `true`, functions texts; an argument that is written several times is a list of its values.
/// Statements the grammar does not know are left out.
pub fn export(dataset: &Dataset) -> Json {
    let statements: Vec<Json> = dataset
        .statements()
        .iter()
        .filter(|statement| statement.kind().is_some_and(|kind| kind != "END"))
        .map(|statement| {
            let mut object = Map::new();
            object.insert("kind".into(), json!(statement.kind()));
            if let Some(id) = statement.number() {
                object.insert("id".into(), json!(id));
            }
            if let Some(name) = statement.view_name {
                object.insert("name".into(), json!(dataset.source().text(name)));
            }
            object.insert(
                "arguments".into(),
                Json::Object(arguments(dataset, statement)),
            );
            Json::Object(object)
        })
        .collect();
    json!({ "title": dataset.title(), "statements": statements })
}

fn arguments(dataset: &Dataset, statement: &Statement) -> Map<String, Json> {
    let mut all = Map::new();
    for argument in &statement.arguments {
        let Some(name) = argument.kind() else {
            continue;
        };
        if all.contains_key(name) {
            continue;
        }
        let mut values: Vec<Json> = statement.all(name).map(|one| value(dataset, one)).collect();
        let json = match values.len() {
            1 => values.remove(0),
            _ => Json::Array(values),
        };
        all.insert(name.to_string(), json);
    }
    all
}

fn value(dataset: &Dataset, argument: &Argument) -> Json {
    let source = dataset.source();
    match &argument.value {
        Value::Flag => Json::Bool(true),
        Value::Numbers(numbers) => numbers
            .iter()
            .map(|number| number_json(number.value))
            .collect(),
        Value::Words(_) => json!(argument.choices(source)),
        Value::Texts(_) => json!(argument.texts(source)),
        Value::Function(expression) => json!(expression.text),
        Value::User(_) => json!(argument.text(source)),
        Value::Malformed(span) => json!(source.text(*span)),
    }
}

/// Whole numbers as such: ids are not written as 12.0.
fn number_json(value: f64) -> Json {
    if value.fract() == 0.0 && value.abs() < 9e15 {
        json!(value as i64)
    } else {
        json!(value)
    }
}

/// The edits that bring the dataset to what the JSON says: changed, new and removed values and statements. An exported JSON
/// that was not changed gives no edits. Statements of unknown kinds stay.
///
/// # Errors
/// One diagnostic for each thing that cannot be done: a statement without a kind, a value of the wrong type.
pub fn import(dataset: &Dataset, json: &Json) -> Result<Vec<Edit>, Vec<Diagnostic>> {
    let mut edits = Vec::new();
    let mut diagnostics = Vec::new();
    let mut kept = BTreeSet::new();
    if let Some(title) = json.get("title").and_then(Json::as_str)
        && title != dataset.title()
        && !title.contains(['\n', '\r'])
    {
        edits.push(Edit::new(dataset.title_span(), title));
    }
    let Some(statements) = json.get("statements").and_then(Json::as_array) else {
        return Err(vec![refused(
            "the JSON has no list named statements".into(),
        )]);
    };
    for object in statements {
        let kind = object
            .get("kind")
            .and_then(Json::as_str)
            .unwrap_or_default();
        let id = object.get("id").and_then(Json::as_u64).map(|id| id as u32);
        let address = Address {
            kind: kind.to_string(),
            id,
            argument: None,
            index: None,
        };
        let empty = Map::new();
        let wanted = object
            .get("arguments")
            .and_then(Json::as_object)
            .unwrap_or(&empty);
        let done = match dataset.position(kind, id) {
            Some(at) => {
                kept.insert(at);
                change(dataset, &dataset.statements()[at], &address, wanted)
            }
            None if kind.is_empty() => Err(refused("a statement has no kind".into())),
            None => new_statement(object, &address, wanted).map(|new| dataset.add(&new)),
        };
        match done {
            Ok(some) => edits.extend(some),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    for (at, statement) in dataset.statements().iter().enumerate() {
        let first = statement
            .kind()
            .is_some_and(|kind| dataset.position(kind, statement.number()) == Some(at));
        if first && statement.kind() != Some("END") && !kept.contains(&at) {
            let removed = Address::of(statement).map(|address| dataset.remove(&address));
            match removed {
                Some(Ok(some)) => edits.extend(some),
                Some(Err(diagnostic)) => diagnostics.push(diagnostic),
                None => {}
            }
        }
    }
    if diagnostics.is_empty() {
        Ok(edits)
    } else {
        Err(diagnostics)
    }
}

/// Edits of one statement.
fn change(
    dataset: &Dataset,
    statement: &Statement,
    object: &Address,
    wanted: &Map<String, Json>,
) -> Result<Vec<Edit>, Diagnostic> {
    let has = arguments(dataset, statement);
    let mut edits = Vec::new();
    for (name, json) in wanted {
        let address = Address {
            argument: Some(name.clone()),
            ..object.clone()
        };
        let known = statement
            .def
            .is_some_and(|def| def.arguments.iter().any(|argument| argument.name == name));
        if !known {
            return Err(refused(format!("{object} has no argument {name}")));
        }
        match has.get(name) {
            Some(old) if same(old, json) => {}
            Some(old) => edits.extend(change_value(dataset, statement, &address, old, json)?),
            None => edits.push(new_value(dataset, statement, name, json)?),
        }
    }
    for argument in &statement.arguments {
        if argument
            .kind()
            .is_some_and(|name| !wanted.contains_key(name))
        {
            edits.push(without(dataset, statement, argument));
        }
    }
    Ok(edits)
}

/// Equal, with numbers to the last digits a JSON reader may lose.
fn same(a: &Json, b: &Json) -> bool {
    match (a, b) {
        (Json::Number(a), Json::Number(b)) => match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= 4.0 * f64::EPSILON * a.abs(),
            _ => false,
        },
        (Json::Array(a), Json::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (a, b) => a == b,
    }
}

fn change_value(
    dataset: &Dataset,
    statement: &Statement,
    address: &Address,
    old: &Json,
    new: &Json,
) -> Result<Vec<Edit>, Diagnostic> {
    let flat = |json: &Json| -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        for item in json.as_array()? {
            match item {
                Json::Array(row) => {
                    for item in row {
                        numbers.push(item.as_f64()?);
                    }
                }
                item => numbers.push(item.as_f64()?),
            }
        }
        Some(numbers)
    };
    if let (Some(old), Some(new)) = (flat(old), flat(new))
        && old.len() == new.len()
    {
        let mut edits = Vec::new();
        for (k, (old, new)) in old.iter().zip(&new).enumerate() {
            if !same(&json!(old), &json!(new)) {
                let address = Address {
                    index: Some(k + 1),
                    ..address.clone()
                };
                edits.extend(dataset.set(&address, *new)?);
            }
        }
        return Ok(edits);
    }
    let name = address.argument.as_deref().unwrap_or_default();
    if new == &Json::Bool(false) {
        return Ok(statement
            .all(name)
            .map(|argument| without(dataset, statement, argument))
            .collect());
    }
    match written(new) {
        Some(text) => dataset.set_text(address, &text),
        None => Err(refused(format!("{address} cannot be {new}"))),
    }
}

fn new_value(
    dataset: &Dataset,
    statement: &Statement,
    name: &str,
    json: &Json,
) -> Result<Edit, Diagnostic> {
    let text = match json {
        Json::Bool(true) => None,
        json => Some(written(json).ok_or_else(|| refused(format!("{name} cannot be {json}")))?),
    };
    Ok(dataset.new_argument(statement, name, text.as_deref()))
}

fn new_statement(
    object: &Json,
    address: &Address,
    wanted: &Map<String, Json>,
) -> Result<NewStatement, Diagnostic> {
    let mut arguments = Vec::new();
    for (name, json) in wanted {
        match json {
            Json::Bool(true) => arguments.push((name.clone(), None)),
            json => match written(json) {
                Some(text) => arguments.push((name.clone(), Some(text))),
                None => return Err(refused(format!("{address}.{name} cannot be {json}"))),
            },
        }
    }
    Ok(NewStatement {
        kind: address.kind.clone(),
        id: address.id,
        view_name: object
            .get("name")
            .and_then(Json::as_str)
            .map(str::to_string),
        arguments,
    })
}

/// A JSON value as the dataset language writes it.
fn written(json: &Json) -> Option<String> {
    match json {
        Json::String(text) => Some(text.clone()),
        Json::Number(number) => Some(spell_like(number.as_f64()?, b"1")),
        Json::Array(items) => {
            let words = items.iter().all(Json::is_string);
            let texts: Option<Vec<String>> = items.iter().map(written).collect();
            Some(texts?.join(if words { ":" } else { ", " }))
        }
        Json::Null | Json::Bool(_) | Json::Object(_) => None,
    }
}

/// The edit that removes an argument with what separates it from its neighbours.
fn without(dataset: &Dataset, statement: &Statement, argument: &Argument) -> Edit {
    let before = statement
        .arguments
        .iter()
        .rfind(|other| other.span.end() <= argument.span.start());
    let after_function =
        before.is_some_and(|before| matches!(before.value, Value::Function(_) | Value::User(_)));
    let rest = &dataset.bytes()[argument.span.end()..statement.span.end()];
    let backslash = rest
        .iter()
        .position(|byte| !byte.is_ascii_whitespace())
        .filter(|at| rest[*at] == b'\\');
    match backslash {
        // A backslash ends functions only: it goes with the function unless another one stands before.
        Some(at) if !after_function => {
            let start = argument.span.start();
            Edit::new(Span::new(start, argument.span.end() + at + 1), "")
        }
        _ => {
            let start = before.map_or_else(
                || dataset.after_header(statement),
                |before| before.span.end(),
            );
            Edit::new(Span::new(start, argument.span.end()), "")
        }
    }
}

fn refused(message: String) -> Diagnostic {
    Diagnostic::error(Code::WrongType, message).label("json", Span::at(0), "")
}
