use std::collections::BTreeMap;

use super::StepKind;

/// The Data blocks of an XRF file: a step of another kind than the one before begins a new one.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(super) struct Blocks {
    kind: Option<StepKind>,
    name: String,
    count: u32,
    numbers: BTreeMap<StepKind, u32>,
}

impl Blocks {
    /// Puts a step into its block; true if that is a new one.
    pub(super) fn take(&mut self, kind: StepKind) -> bool {
        if self.kind == Some(kind) {
            return false;
        }
        self.count += 1;
        let number = self.numbers.entry(kind).or_insert(0);
        *number += 1;
        self.name = format!("{}_{number:03}", kind.block_name());
        self.kind = Some(kind);
        true
    }

    /// Name of the present block, for example `quasiStatic_001`; empty before the first step.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// How many blocks there are, the present one included.
    pub(super) fn count(&self) -> u32 {
        self.count
    }
}
