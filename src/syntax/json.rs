//! Export of a dataset to JSON, and import of a modified JSON as edits of the original text.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use serde_json::{Map, Value as Json, json};

use super::number::parse_number;
use super::statement::{NO_OWNER, OWNERS};
use super::{Address, Argument, Dataset, NewStatement, Statement, Value, spell_like};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{ArgumentDef, STATEMENTS, ValueKind, nearest};
use crate::text::Edit;

/// Exports a dataset as JSON: `title`, and a list `statements` with `kind`, `id`, `name` (the ADAMS/View name) and `arguments`.
///
/// Numbers are in model units (angles in radians), flags are `true`, and functions are texts. A repeated argument becomes a list of its
/// values. Statements that are not in the grammar are left out.
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

/// Converts a number to JSON. An integer gets no decimal point, so that an id becomes 12 and not 12.0.
fn number_json(value: f64) -> Json {
    if value.fract() == 0.0 && value.abs() < 9e15 {
        json!(value as i64)
    } else {
        json!(value)
    }
}

/// Returns the edits that make the dataset equal to the JSON: they change, add and remove values and statements.
///
/// An exported JSON without changes gives no edits. Statements that are not in the grammar stay in the dataset.
///
/// # Errors
/// Returns one diagnostic for each change that is impossible, such as a statement without a kind or a value of the wrong type.
pub fn import(dataset: &Dataset, json: &Json) -> Result<Vec<Edit>, Vec<Diagnostic>> {
    let mut edits = Vec::new();
    let mut diagnostics = Vec::new();
    if let Some(title) = json.get("title").and_then(Json::as_str)
        && title != dataset.title()
    {
        match dataset.set_title(title) {
            Ok(some) => edits.extend(some),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let Some(statements) = json.get("statements").and_then(Json::as_array) else {
        return Err(vec![refused("the JSON has no list `statements`".into())]);
    };
    // Repeated statements are paired in their order of appearance.
    let mut places: BTreeMap<(&str, Option<u32>), VecDeque<usize>> = BTreeMap::new();
    for (at, statement) in dataset.statements().iter().enumerate() {
        if let Some(kind) = statement.kind().filter(|kind| *kind != "END") {
            places
                .entry((kind, statement.number()))
                .or_default()
                .push_back(at);
        }
    }
    for object in statements {
        let done = address_of(object).and_then(|(kind, address)| {
            let known = places.get_mut(&(kind, address.id));
            match known.and_then(VecDeque::pop_front) {
                Some(at) => change(dataset, &dataset.statements()[at], &address, object),
                None => new_statement(object, &address).map(|new| dataset.add(&new)),
            }
        });
        match done {
            Ok(some) => edits.extend(some),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let gone: BTreeSet<usize> = places.into_values().flatten().collect();
    for at in &gone {
        let statement = &dataset.statements()[*at];
        let stays = |marker: &usize| !gone.contains(marker);
        match dataset.carried(*at).find(stays) {
            Some(marker) => diagnostics.push(dataset.stranded(*at, marker)),
            None => edits.push(dataset.without_statement(statement)),
        }
    }
    if diagnostics.is_empty() {
        Ok(edits)
    } else {
        Err(diagnostics)
    }
}

/// Lists the objects and arguments in which a dataset differs from a JSON; the list is empty after a successful import.
pub fn disagreements(dataset: &Dataset, json: &Json) -> Vec<String> {
    let is = export(dataset);
    let list = |json: &Json| -> Vec<Json> {
        let statements = json.get("statements").and_then(Json::as_array);
        statements.cloned().unwrap_or_default()
    };
    let key = |object: &Json| {
        let kind = object
            .get("kind")
            .and_then(Json::as_str)
            .unwrap_or_default();
        (kind.to_string(), object.get("id").and_then(Json::as_u64))
    };
    let mut found: BTreeMap<_, VecDeque<Json>> = BTreeMap::new();
    for object in list(&is) {
        found.entry(key(&object)).or_default().push_back(object);
    }
    let mut differ = Vec::new();
    let empty = Map::new();
    for object in list(json) {
        let (kind, id) = key(&object);
        let name = match id {
            Some(id) => format!("{kind}/{id}"),
            None => kind.clone(),
        };
        let Some(is) = found.get_mut(&(kind, id)).and_then(VecDeque::pop_front) else {
            differ.push(name);
            continue;
        };
        let arguments = |object: &Json| -> Map<String, Json> {
            let all = object.get("arguments").and_then(Json::as_object);
            let said = |json: &Json| *json != Json::Bool(false);
            all.unwrap_or(&empty)
                .iter()
                .filter(|(_, json)| said(json))
                .map(|(name, json)| (name.clone(), json.clone()))
                .collect()
        };
        let (wanted, is) = (arguments(&object), arguments(&is));
        let all: BTreeSet<&String> = wanted.keys().chain(is.keys()).collect();
        for argument in all {
            let agree = match (wanted.get(argument), is.get(argument)) {
                (Some(wanted), Some(is)) => agree(wanted, is),
                _ => false,
            };
            if !agree {
                differ.push(format!("{name}.{argument}"));
            }
        }
    }
    let more = found.into_iter().filter(|(_, left)| !left.is_empty());
    differ.extend(more.map(|((kind, _), _)| kind));
    differ
}

/// Returns true if a value of the dataset (`is`) equals the value in the JSON (`wanted`), apart from spelling.
///
/// Examples of equal values: a number and a list of only this number; a list of numbers and a text with the same numbers; an abbreviated
/// word and the full word.
fn agree(wanted: &Json, is: &Json) -> bool {
    match (wanted, is) {
        (Json::Array(a), Json::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).all(|(a, b)| agree(a, b))
        }
        (Json::String(a), Json::Array(b)) if b.len() != 1 => {
            let parts: Vec<&str> = a.split([',', ':']).map(str::trim).collect();
            parts.len() == b.len() && parts.iter().zip(b).all(|(a, b)| agree(&json!(a), b))
        }
        (a, Json::Array(b)) if b.len() == 1 && !a.is_array() => agree(a, &b[0]),
        (Json::Array(a), b) if a.len() == 1 => agree(&a[0], b),
        (Json::String(a), Json::Number(b)) => {
            let read = parse_number(a.trim().as_bytes());
            read.is_some_and(|(value, _)| same(&json!(value), &Json::Number(b.clone())))
        }
        (Json::String(a), Json::String(b)) => {
            let bare = |text: &str| -> String {
                let kept = |c: &char| !c.is_whitespace() && *c != '"';
                text.chars().filter(kept).collect::<String>().to_uppercase()
            };
            let (a, b) = (bare(a), bare(b));
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            a == b || (!a.is_empty() && a.chars().all(word) && b.starts_with(&a))
        }
        (a, b) => same(a, b),
    }
}

/// Returns the statement keyword and the address of the object that a JSON statement describes.
fn address_of(object: &Json) -> Result<(&'static str, Address), Diagnostic> {
    let kind = object.get("kind").and_then(Json::as_str);
    let Some(kind) = kind.filter(|kind| !kind.is_empty()) else {
        return Err(refused("a statement in the JSON has no `kind`".into()));
    };
    let Some(def) = STATEMENTS.iter().find(|def| def.name == kind) else {
        let names = STATEMENTS.iter().map(|def| def.name);
        let refusal = refused(format!("no statement is called {kind}"));
        return Err(match nearest(kind, names) {
            Some(near) => refusal.help(format!("did you mean {near}?")),
            None => refusal,
        });
    };
    let id = match object.get("id") {
        None | Some(Json::Null) => None,
        Some(id) => Some(
            id.as_u64()
                .and_then(|id| u32::try_from(id).ok())
                .ok_or_else(|| refused(format!("{id} is not a valid id of {kind}")))?,
        ),
    };
    if def.id.is_some() != id.is_some() {
        let needs = if id.is_some() {
            "has no id"
        } else {
            "needs an id"
        };
        return Err(refused(format!("{kind} {needs}")));
    }
    let address = Address {
        kind: kind.to_string(),
        id,
        argument: None,
        index: None,
    };
    Ok((def.name, address))
}

/// Returns the grammar definition of an argument of an object.
fn definition(object: &Address, name: &str) -> Result<&'static ArgumentDef, Diagnostic> {
    let all = STATEMENTS
        .iter()
        .find(|def| def.name == object.kind)
        .map_or(&[][..], |def| def.arguments);
    all.iter().find(|def| def.name == name).ok_or_else(|| {
        let refusal = refused(format!("{object} has no argument {name}"));
        match nearest(name, all.iter().map(|def| def.name)) {
            Some(near) => refusal.help(format!("did you mean {near}?")),
            None => refusal,
        }
    })
}

/// Returns the edits that make one statement equal to its JSON.
fn change(
    dataset: &Dataset,
    statement: &Statement,
    object: &Address,
    wanted: &Json,
) -> Result<Vec<Edit>, Diagnostic> {
    let has = arguments(dataset, statement);
    let empty = Map::new();
    let name = wanted.get("name").and_then(Json::as_str);
    let mut edits: Vec<Edit> = dataset.rename(statement, name)?.into_iter().collect();
    let wanted = wanted
        .get("arguments")
        .and_then(Json::as_object)
        .unwrap_or(&empty);
    let first = dataset
        .find(object)
        .is_some_and(|first| first.span == statement.span);
    for (name, json) in wanted {
        let address = Address {
            argument: Some(name.clone()),
            ..object.clone()
        };
        let def = definition(object, name)?;
        match has.get(name) {
            Some(old) if same(old, json) => {}
            Some(_) if !first => {
                let message =
                    format!("{object} is defined twice; only the first definition can be changed");
                return Err(refused(message));
            }
            Some(old) => edits.extend(change_value(dataset, statement, &address, old, json)?),
            None if *json == Json::Bool(false) => {}
            None => edits.push(new_value(dataset, statement, def, json)?),
        }
    }
    for argument in &statement.arguments {
        if argument
            .kind()
            .is_some_and(|name| !wanted.contains_key(name))
        {
            edits.push(dataset.without(statement, argument));
        }
    }
    Ok(edits)
}

/// Returns true if two values are equal. Numbers are compared except for their last digits, which a JSON reader may lose.
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
                // The points ZP and XP do not move along with QP of a marker, because the JSON contains their own values.
                edits.extend(dataset.set_alone(&address, *new)?);
            }
        }
        return Ok(edits);
    }
    let name = address.argument.as_deref().unwrap_or_default();
    if new == &Json::Bool(false) {
        return Ok(statement
            .every(name)
            .map(|argument| dataset.without(statement, argument))
            .collect());
    }
    let quoted = statement.argument(name).is_some_and(|argument| {
        let start = argument.value_span().start();
        matches!(argument.value, Value::Texts(_)) && start > 0 && dataset.bytes()[start - 1] == b'"'
    });
    let text = match new {
        // The first opening quote and the last closing quote of the list stay in place.
        Json::Array(items) if quoted && items.iter().all(Json::is_string) => {
            let texts: Vec<&str> = items.iter().filter_map(Json::as_str).collect();
            Some(texts.join("\", \""))
        }
        new => written(new),
    };
    match text {
        Some(text) => dataset.set_text(address, &text),
        None => Err(refused(format!("{address} cannot have the value {new}"))),
    }
}

fn new_value(
    dataset: &Dataset,
    statement: &Statement,
    def: &'static ArgumentDef,
    json: &Json,
) -> Result<Edit, Diagnostic> {
    let name = def.name;
    let text = match json {
        Json::Bool(true) if def.kind == ValueKind::Flag => None,
        json => Some(
            new_text(def, json)
                .ok_or_else(|| refused(format!("{name} cannot have the value {json}")))?,
        ),
    };
    Ok(dataset.new_argument(statement, name, text.as_deref()))
}

fn new_statement(object: &Json, address: &Address) -> Result<NewStatement, Diagnostic> {
    let mut arguments = Vec::new();
    let empty = Map::new();
    let wanted = object
        .get("arguments")
        .and_then(Json::as_object)
        .unwrap_or(&empty);
    for (name, json) in wanted {
        let def = definition(address, name)?;
        match json {
            Json::Bool(false) => {}
            Json::Bool(true) if def.kind == ValueKind::Flag => arguments.push((name.clone(), None)),
            json => match new_text(def, json) {
                Some(text) => arguments.push((name.clone(), Some(text))),
                None => {
                    return Err(refused(format!(
                        "{address}.{name} cannot have the value {json}"
                    )));
                }
            },
        }
    }
    if address.kind == "MARKER" && !OWNERS.iter().any(|owner| wanted.contains_key(*owner)) {
        return Err(refused(format!("{address} {NO_OWNER}")));
    }
    let view_name = object.get("name").and_then(Json::as_str);
    if view_name.is_some_and(|name| name.contains(['\n', '\r', '\''])) {
        return Err(refused(format!(
            "the name of {address} must not contain a line break or an apostrophe"
        )));
    }
    Ok(NewStatement {
        kind: address.kind.clone(),
        id: address.id,
        view_name: view_name.map(str::to_string),
        arguments,
    })
}

/// Formats a value for an argument that is not yet in the dataset; ambiguous texts are put in quotes.
fn new_text(def: &ArgumentDef, json: &Json) -> Option<String> {
    let text = written(json)?;
    if text.contains(['\n', '\r']) {
        return None;
    }
    if def.kind != ValueKind::TextList {
        return Some(text);
    }
    let items: Vec<&str> = match json {
        Json::Array(items) => items.iter().map(Json::as_str).collect::<Option<_>>()?,
        json => vec![json.as_str()?],
    };
    let plain = |text: &&str| {
        !text.is_empty() && !text.contains([',', ':', ';', '!', '&', '=']) && text.trim() == *text
    };
    Some(if items.iter().all(plain) {
        items.join(":")
    } else {
        let quoted: Vec<String> = items.iter().map(|item| format!("\"{item}\"")).collect();
        quoted.join(", ")
    })
}

/// Formats a JSON value in the dataset language.
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

fn refused(message: String) -> Diagnostic {
    Diagnostic::error(Code::WrongType, message)
}
