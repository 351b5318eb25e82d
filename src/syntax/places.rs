//! Locations for diagnostics that name an object of a dataset.

use std::collections::BTreeMap;

use super::Dataset;
use crate::diagnostic::Diagnostic;

impl Dataset {
    /// Adds a location to each diagnostic that names an object but has no location: the statement of that object.
    pub fn locate(&self, diagnostics: &mut [Diagnostic]) {
        let is_lost = |found: &Diagnostic| found.labels.is_empty() && found.object.is_some();
        if !diagnostics.iter().any(is_lost) {
            return;
        }
        let mut places = BTreeMap::new();
        for statement in self.statements() {
            if let (Some(kind), Some((id, span))) = (statement.kind(), statement.id) {
                places.insert((kind, id), statement.keyword.join(span));
            }
        }
        for found in diagnostics.iter_mut().filter(|found| is_lost(found)) {
            let object = found.object.as_ref();
            let place = object.and_then(|object| places.get(&(object.kind, object.id)));
            if let Some(&place) = place {
                *found = found.clone().label(self.source().name(), place, "");
            }
        }
    }
}
