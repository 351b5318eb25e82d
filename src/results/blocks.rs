use std::collections::BTreeMap;

use super::StepKind;

/// Sequence of the Data blocks in an XRF file. An output step starts a new block if its kind differs from the kind of the step before it.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(super) struct Blocks {
    kind: Option<StepKind>,
    name: String,
    count: u32,
    numbers: BTreeMap<StepKind, u32>,
}

impl Blocks {
    /// Assigns the next output step to a block; returns true if the step starts a new block.
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

    /// Returns the name of the current block, for example `quasiStatic_001`; empty before the first step.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of blocks so far, including the current one.
    pub(super) fn count(&self) -> u32 {
        self.count
    }
}
