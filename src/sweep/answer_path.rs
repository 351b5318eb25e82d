use std::fmt;

use serde_json::Value;

/// Result file of a study.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ResultFile {
    /// `identification.json`.
    Identification,
    /// `diagnosis.json`.
    Diagnosis,
}

/// Path to a number in a result file, such as `fit_test.chi2` or `parameters[BUSHING/1.K.1].value`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct AnswerPath {
    /// Result file.
    pub answer: ResultFile,
    steps: Vec<Step>,
}

#[derive(Clone, PartialEq, Eq, Debug)]
enum Step {
    /// Field of an object.
    Field(String),
    /// Element of a list. It is named by its address, by cause and address, or by its position counted from 0; `*` matches any characters.
    Element(String),
}

impl AnswerPath {
    /// Parses a path; `None` if the text is not a path.
    pub(crate) fn parse(answer: ResultFile, text: &str) -> Option<Self> {
        let mut steps = Vec::new();
        let mut rest = text;
        loop {
            let end = rest.find(['.', '[']).unwrap_or(rest.len());
            if end == 0 {
                return None;
            }
            steps.push(Step::Field(rest[..end].to_string()));
            rest = &rest[end..];
            while let Some(inside) = rest.strip_prefix('[') {
                let end = inside.find(']')?;
                steps.push(Step::Element(inside[..end].to_string()));
                rest = &inside[end + 1..];
            }
            if rest.is_empty() {
                return Some(Self { answer, steps });
            }
            rest = rest.strip_prefix('.')?;
        }
    }

    /// Expands each `*` against a result. Returns every matching path without `*`, each with the names that its stars match. A path without
    /// `*` is returned unchanged and unchecked.
    pub(crate) fn matching(&self, answer: &Value) -> Vec<(Self, String)> {
        let mut found = vec![(Vec::new(), String::new(), answer)];
        let any = |step: &Step| matches!(step, Step::Element(word) if word.contains('*'));
        if !self.steps.iter().any(any) {
            return vec![(self.clone(), String::new())];
        }
        for step in &self.steps {
            let mut next = Vec::new();
            for (steps, names, value) in found {
                let steps: &Vec<Step> = &steps;
                let mut add = |step: Step, name: &str, value| {
                    let mut steps = steps.clone();
                    steps.push(step);
                    let dot = if names.is_empty() || name.is_empty() {
                        ""
                    } else {
                        "."
                    };
                    next.push((steps, format!("{names}{dot}{name}"), value));
                };
                match step {
                    Step::Field(name) => {
                        if let Some(value) = value.get(name) {
                            add(step.clone(), "", value);
                        }
                    }
                    Step::Element(word) => {
                        for (name, value) in elements(value) {
                            if like(word, &name) {
                                add(Step::Element(name.clone()), &name, value);
                            }
                        }
                    }
                }
            }
            found = next;
        }
        let path = |(steps, names, _): (Vec<Step>, String, &Value)| {
            let path = Self {
                answer: self.answer,
                steps,
            };
            (path, names)
        };
        found.into_iter().map(path).collect()
    }

    /// Returns the reason why no result of this kind can have a number at this path; `None` if the path is acceptable. Two absences are
    /// acceptable: a null, because it may be a number in another case, and a missing finding (named `cause@address`), because it may occur
    /// in another case.
    pub(crate) fn refused(&self, answer: &Value) -> Option<String> {
        let mut at = answer;
        for step in &self.steps {
            let next = match step {
                Step::Field(name) => at.get(name),
                Step::Element(word) => elements(at).find(|(name, _)| name == word).map(|(_, v)| v),
            };
            at = match (next, step) {
                (Some(Value::Null), _) => return None,
                (Some(next), _) => next,
                (None, Step::Element(word)) if word.contains('@') => return None,
                (None, Step::Element(word)) if word.contains('*') => {
                    let text = "`*` matches nothing here in the result of the unchanged study; name the element, as in findings[dry-friction@BUSHING/1.K.1]";
                    return Some(text.to_string());
                }
                (None, Step::Field(name) | Step::Element(name)) => {
                    return Some(format!("the result has no field `{name}`"));
                }
            };
        }
        match at {
            Value::Number(_) | Value::Bool(_) => None,
            _ => Some(format!("`{self}` is not a number")),
        }
    }

    /// Returns the number at this path, with true as 1 and false as 0; NaN if there is no number.
    pub(crate) fn number(&self, answer: &Value) -> f64 {
        let mut at = answer;
        for step in &self.steps {
            let next = match step {
                Step::Field(name) => at.get(name),
                Step::Element(word) => elements(at).find(|(name, _)| name == word).map(|(_, v)| v),
            };
            let Some(next) = next else { return f64::NAN };
            at = next;
        }
        match at {
            Value::Bool(yes) => f64::from(u8::from(*yes)),
            other => other.as_f64().unwrap_or(f64::NAN),
        }
    }
}

impl fmt::Display for AnswerPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, step) in self.steps.iter().enumerate() {
            match step {
                Step::Field(name) if k > 0 => write!(f, ".{name}")?,
                Step::Field(name) => f.write_str(name)?,
                Step::Element(name) => write!(f, "[{name}]")?,
            }
        }
        Ok(())
    }
}

/// Iterates over the elements of a list, each with its name: address, cause and address, or position.
fn elements(list: &Value) -> impl Iterator<Item = (String, &Value)> {
    let list = list.as_array().map_or(&[][..], Vec::as_slice);
    list.iter().enumerate().map(|(k, value)| {
        let word = |key: &str| value.get(key).and_then(Value::as_str);
        let name = match (word("cause"), word("address")) {
            (Some(cause), Some(address)) => format!("{cause}@{address}"),
            (None, Some(address)) => address.to_string(),
            _ => k.to_string(),
        };
        (name, value)
    })
}

/// Returns true if a name matches a pattern in which `*` stands for any characters.
fn like(pattern: &str, name: &str) -> bool {
    glob::Pattern::new(&pattern.replace('[', "[[]")).is_ok_and(|pattern| pattern.matches(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_find_numbers_by_address_and_cause() {
        let answer = serde_json::json!({
            "converged": true,
            "fit_test": { "chi2": 12.5 },
            "parameters": [
                { "address": "BUSHING/1.K.1", "value": 1.0, "interval95": [0.5, null] },
                { "address": "BUSHING/1.K.2", "value": 2.0, "interval95": [1.5, 2.5] },
            ],
            "findings": [{ "cause": "dry-friction", "address": "BUSHING/2.K.1", "probability": 0.9 }],
        });
        let path = |text: &str| AnswerPath::parse(ResultFile::Identification, text).unwrap();
        let number = |text: &str| path(text).number(&answer);
        assert_eq!(number("converged"), 1.0);
        assert_eq!(number("fit_test.chi2"), 12.5);
        assert_eq!(number("parameters[BUSHING/1.K.2].value"), 2.0);
        assert_eq!(number("parameters[BUSHING/1.K.2].interval95[1]"), 2.5);
        assert!(number("parameters[BUSHING/1.K.1].interval95[1]").is_nan());
        assert_eq!(
            number("findings[dry-friction@BUSHING/2.K.1].probability"),
            0.9
        );
        let all = path("parameters[BUSHING/1.*].value").matching(&answer);
        let names: Vec<&str> = all.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["BUSHING/1.K.1", "BUSHING/1.K.2"]);
        assert_eq!(all[1].0.number(&answer), 2.0);
        let refused = |text: &str| path(text).refused(&answer);
        for fine in [
            "converged",
            "parameters[BUSHING/1.K.1].interval95[1]",
            "findings[creep@BUSHING/1.K.1].probability",
        ] {
            assert_eq!(refused(fine), None);
        }
        for wrong in [
            "fit_test.chi",
            "fit_test",
            "parameters[BUSHING/9.K.1].value",
            "parameters[BUSHING/1.K.1].address",
            "findings[creep*].probability",
        ] {
            assert!(refused(wrong).is_some(), "{wrong}");
        }
        for bad in ["", ".a", "a.", "a[b", "a]b.", "a[b]c"] {
            assert_eq!(AnswerPath::parse(ResultFile::Diagnosis, bad), None, "{bad}");
        }
    }
}
