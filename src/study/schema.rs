//! JSON Schema of `study.toml`. The keys are recorded from the code that reads the file, and the descriptions come from the guide.

use serde_json::{Map, Value, json};

use super::section::{Key, ValueType};
use super::study::study_keys;
use admire_guide::glossary;

/// Returns the JSON Schema (draft 7) of `study.toml`, for editors.
pub fn schema() -> Value {
    let mut root = table();
    for key in study_keys() {
        insert(&mut root, &key);
    }
    let required = |value: &mut Value, names: &[&str]| value["required"] = json!(names);
    required(&mut root, &["model"]);
    root["anyOf"] = json!([{ "required": ["loads"] }, { "required": ["target"] }]);
    required(&mut root["properties"]["model"], &["deck"]);
    required(&mut root["properties"]["loads"], &["file", "columns"]);
    required(&mut root["properties"]["marks"], &["on_parts", "measured"]);
    required(&mut root["properties"]["wheel"], &["marker"]);
    required(&mut root["properties"]["car"], &["subsystem"]);
    root["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    root["title"] = json!("study.toml of admire");
    root
}

fn table() -> Value {
    json!({ "type": "object", "properties": {}, "additionalProperties": false })
}

/// Inserts a key into the schema below `root`. A key that was recorded with two types of values accepts either type.
fn insert(root: &mut Value, key: &Key) {
    let mut at = root;
    let pieces: Vec<&str> = key.path.split('.').collect();
    let (last, above) = pieces.split_last().expect("a key has a name");
    for piece in above {
        at = inner(at, piece);
        if at.get("anyOf").is_some() {
            at = at["anyOf"]
                .as_array_mut()
                .and_then(|any| any.iter_mut().find(|one| one["type"] == "object"))
                .expect("a table");
        }
    }
    let mut new = holds(&key.holds);
    if let Some(meaning) = glossary::meaning(&key.path) {
        new["description"] = json!(meaning);
    }
    if key.holds == ValueType::OwnTexts || (*last == "NAME" && key.holds == ValueType::Table) {
        at["additionalProperties"] = new;
        return;
    }
    let properties = at["properties"]
        .as_object_mut()
        .expect("a table has properties");
    either(properties, last, new);
}

/// Returns the subschema of one component of a key in a table. The component `NAME` stands for all user-defined names.
fn inner<'a>(at: &'a mut Value, piece: &str) -> &'a mut Value {
    if piece == "NAME" {
        &mut at["additionalProperties"]
    } else {
        let inner = &mut at["properties"][piece];
        // Each of several tables has the same keys.
        if inner["type"] == "array" {
            &mut inner["items"]
        } else {
            inner
        }
    }
}

/// Adds a property to a table. If the property exists already, `new` becomes an alternative type of its value.
fn either(properties: &mut Map<String, Value>, name: &str, new: Value) {
    let Some(old) = properties.get_mut(name) else {
        properties.insert(name.to_string(), new);
        return;
    };
    if let Some(any) = old.get_mut("anyOf").and_then(Value::as_array_mut) {
        if !any.contains(&new) {
            any.push(new);
        }
    } else if *old != new {
        *old = json!({ "anyOf": [old.take(), new] });
    }
}

fn holds(what: &ValueType) -> Value {
    match what {
        ValueType::Table => table(),
        ValueType::Text | ValueType::OwnTexts => json!({ "type": "string" }),
        ValueType::Number(least, most) => {
            let mut number = json!({ "type": "number" });
            // A tiny lower bound serves only to exclude zero.
            if *least > 0.0 && *least < 1e-6 {
                number["exclusiveMinimum"] = json!(0);
            } else {
                number["minimum"] = json!(least);
            }
            if most.is_finite() {
                number["maximum"] = json!(most);
            }
            number
        }
        ValueType::Count(least, most) => {
            json!({ "type": "integer", "minimum": least, "maximum": most })
        }
        ValueType::Choice(words) => json!({ "enum": words }),
        ValueType::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        ValueType::Flag => json!({ "type": "boolean" }),
        ValueType::Quantity => json!({ "type": ["number", "string"] }),
        ValueType::Bounds => json!({
            "type": "array", "items": { "type": ["number", "string"] }, "minItems": 2, "maxItems": 2
        }),
        ValueType::Numbers => json!({ "type": "array", "items": { "type": "number" } }),
        ValueType::Tables => json!({ "type": "array", "items": table() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CausePriors;

    #[test]
    fn every_key_the_reader_knows_is_explained_in_the_guide() {
        let lacking: Vec<String> = study_keys()
            .into_iter()
            .filter(|key| {
                !matches!(key.holds, ValueType::Table | ValueType::Tables)
                    && glossary::meaning(&key.path).is_none()
            })
            .map(|key| key.path)
            .collect();
        assert!(
            lacking.is_empty(),
            "no row of the guide explains {lacking:?}"
        );
        assert!(study_keys().len() > 50);
    }

    #[test]
    fn priors_of_the_guide_are_those_of_the_program() {
        for prior in CausePriors::TABLE {
            let term = format!("priors.{}", prior.name);
            let row = glossary::entries().find(|entry| entry.term == term);
            let cells = row.expect("a row of the guide").cells;
            let said: Vec<&str> = cells.iter().map(|(_, text)| text.as_str()).collect();
            let meaning = prior.meaning.trim().trim_end_matches('.');
            assert_eq!(
                said[said.len() - 2..],
                [&format!("`{}`", prior.value), meaning]
            );
            assert!(prior.unit.is_empty() || said[0] == prior.unit, "{term}");
        }
    }

    /// The guide must not explain keys that the program does not read.
    #[test]
    fn every_key_of_the_guide_is_one_the_reader_asks_for() {
        let keys = study_keys();
        for entry in glossary::entries()
            .filter(|entry| entry.page == "study" && entry.section == "study.toml")
        {
            let known = keys
                .iter()
                .any(|key| key.path == entry.term || key.path == format!("{}.NAME", entry.term));
            assert!(known, "{}", entry.term);
        }
    }

    #[test]
    fn the_schema_has_the_shape_of_a_study() {
        let schema = schema();
        let properties = &schema["properties"];
        assert_eq!(
            properties["marks"]["properties"]["sigma"]["exclusiveMinimum"],
            0
        );
        assert_eq!(
            properties["loads"]["properties"]["columns"]["additionalProperties"]["type"],
            "string"
        );
        let channel = &properties["readings"]["properties"]["channels"]["additionalProperties"];
        assert_eq!(channel["properties"]["function"]["type"], "string");
        let initial = &properties["identify"]["properties"]["initial"]["anyOf"];
        assert_eq!(initial[0]["properties"]["translational"]["type"], "number");
        assert_eq!(initial[1]["enum"][0], "deck");
        assert_eq!(
            properties["tolerances"]["properties"]["pose"]["anyOf"][1]["enum"][0],
            "estimate"
        );
        assert!(schema.to_string().contains("sd of one coordinate"));
    }
}
