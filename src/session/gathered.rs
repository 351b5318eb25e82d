//! Grouping of diagnostics: if the same problem concerns many objects, they are named in one message.

use std::collections::BTreeMap;

use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

use super::run_state::Session;

/// Maximum number of objects that get a separate message for the same problem.
const APART: usize = 3;
/// Maximum number of further objects that are named in a common message.
const NAMED: usize = 5;

impl Session<'_> {
    /// Reports diagnostics about objects of the model. Diagnostics about the same problem are grouped. A diagnostic is reported only once
    /// while the model is loaded.
    pub(super) fn report_once(&mut self, mut found: Vec<Diagnostic>) {
        if let Some(loaded) = &mut self.loaded {
            found.retain(|told| loaded.told.insert((told.severity, told.message.clone())));
        }
        let mut found = grouped_diagnostics(found);
        if let Some(loaded) = &self.loaded {
            loaded.definitions.dataset().locate(&mut found);
        }
        for diagnostic in found {
            self.complain(&diagnostic);
        }
    }
}

/// Groups diagnostics that differ only in their object, such as `CONTACT/1 'a' is not solved`, if there are many of them.
fn grouped_diagnostics(found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    type Key = (Code, Severity, &'static str, String, Option<String>);
    let mut groups: Vec<Vec<Diagnostic>> = Vec::new();
    let mut known: BTreeMap<Key, usize> = BTreeMap::new();
    for diagnostic in found {
        let object = diagnostic.object.as_ref();
        let Some(object) = object.filter(|_| diagnostic.labels.is_empty()) else {
            groups.push(vec![diagnostic]);
            continue;
        };
        let key = (
            diagnostic.code,
            diagnostic.severity,
            object.kind,
            diagnostic.message.replacen(&object.called, "", 1),
            diagnostic.help.clone(),
        );
        let at = *known.entry(key).or_insert(groups.len());
        match groups.get_mut(at) {
            Some(group) => group.push(diagnostic),
            None => groups.push(vec![diagnostic]),
        }
    }
    groups.into_iter().flat_map(as_one).collect()
}

/// Merges the diagnostics of a group into one message, if there are more than [`APART`] of them.
fn as_one(mut group: Vec<Diagnostic>) -> Vec<Diagnostic> {
    if group.len() <= APART {
        return group;
    }
    let others = group.split_off(1);
    let named: Vec<&str> = others
        .iter()
        .filter_map(|other| Some(&*other.object.as_ref()?.called))
        .take(NAMED)
        .collect();
    let left = others.len() - named.len();
    let and = if left > 0 {
        format!(" and {left} more")
    } else {
        String::new()
    };
    let text = format!(
        "; the same applies to {} more: {}{and}",
        others.len(),
        named.join(", ")
    );
    group[0].message.push_str(&text);
    group
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::diagnostic::Object;

    #[test]
    fn many_alike_are_one_and_few_stay_apart() {
        let error = |kind: &'static str, called: String, view: Option<String>| {
            let message = format!("{called} is not solved: it would push");
            let object = Object {
                kind,
                id: 0,
                called,
                view,
            };
            Diagnostic::error(Code::NotSolvedNatively, message).about(object)
        };
        let contact = |k: usize| {
            let view = format!("c{k}");
            error("CONTACT", format!("CONTACT/{k} '{view}'"), Some(view))
        };
        let curve = |k: usize| error("PTCV", format!("PTCV/{k}"), None);
        let mut found: Vec<Diagnostic> = (1..=9).map(contact).collect();
        found.insert(4, curve(1));
        found.push(curve(2));
        let told: Vec<String> = grouped_diagnostics(found)
            .into_iter()
            .map(|d| d.message)
            .collect();
        assert_eq!(
            told,
            [
                "CONTACT/1 'c1' is not solved: it would push; the same applies to 8 more: CONTACT/2 'c2', CONTACT/3 'c3', \
                 CONTACT/4 'c4', CONTACT/5 'c5', CONTACT/6 'c6' and 3 more",
                "PTCV/1 is not solved: it would push",
                "PTCV/2 is not solved: it would push",
            ]
        );
    }
}
