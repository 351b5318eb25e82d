//! Results of a study as changes of a subsystem file and as new property files.

use std::collections::BTreeSet;

use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Edit, Source, Span, apply_edits};
use admire_syntax::units::{Dimension, Units};

use crate::block_edit::{new_key, repeated_block};
use crate::bushing::BushingProperty;
use crate::edit::{rounded, spelled};
use crate::file_units::{angle_word, factor, force_word, length_word, torque_word};
use crate::hardpoint_rows::{HardpointMove, move_hardpoints};
use crate::names::BushingName;
use crate::settings::{LEARNED_NAME_CHARACTERS, SMALLEST_CHANGE_RATIO};
use crate::side::{Side, Symmetry};
use crate::subsystem::{BushingAssembly, Subsystem};
use crate::word_change::{LearnedFile, NotWritten, WordChange};

/// Changes of one bushing on one side of the vehicle. Components are x, y, z, then about x, y, z.
#[derive(Clone, PartialEq, Debug)]
pub struct BushingChange {
    /// Bushing of the subsystem.
    pub name: BushingName,
    /// Ratio of new to old stiffness, with the standard error of this ratio; `None` for an unchanged component.
    pub scale: [Option<(f64, Option<f64>)>; 6],
    /// Preload force and torque on I in the units of the deck; `None` for an unchanged component.
    pub preload: [Option<f64>; 6],
    /// Offset of each displacement (in the units of the deck) or angle (in radians); `None` for an unchanged component.
    pub offset: [Option<f64>; 6],
    /// Contents of a new property file in the units of the deck. It replaces the scale factors.
    pub learned: Option<BushingProperty>,
    /// Origin of the changes, such as `identified BUSHING/1`.
    pub because: String,
}

/// A subsystem file with results written into it.
#[derive(Clone, PartialEq, Debug)]
pub struct WriteBack {
    /// Bytes of the new subsystem file. Lines without a change are those of the old file.
    pub bytes: Vec<u8>,
    /// Changed values in the order of the file.
    pub changes: Vec<WordChange>,
    /// New property files.
    pub files: Vec<LearnedFile>,
    /// Results that could not be written to the new file.
    pub not_written: Vec<NotWritten>,
}

/// Sides of a subsystem's entries that exist in the deck.
type InDeck<T> = BTreeSet<(T, Side)>;

impl WriteBack {
    /// Writes results into a subsystem file.
    ///
    /// `hardpoints` and `bushings` state which sides of which entries the deck contains. If the deck contains only one side of an entry for
    /// `left/right`, the entry still applies to both sides. If the deck contains both sides and their results differ, the entry is split into one for
    /// `left` and one for `right`. A scale factor is multiplied by the ratio of the stiffnesses, because the stiffness in the deck includes the
    /// present factor of the file.
    pub fn new(
        subsystem: &Subsystem,
        units: &Units,
        hardpoints: &InDeck<usize>,
        moves: &[HardpointMove],
        bushings: &InDeck<String>,
        changes: &[BushingChange],
    ) -> Self {
        let mut out = Self {
            bytes: Vec::new(),
            changes: Vec::new(),
            files: Vec::new(),
            not_written: Vec::new(),
        };
        let edits = move_hardpoints(subsystem, units, hardpoints, moves, &mut out.changes);
        out.bytes = applied(subsystem.file.source().bytes(), &edits);
        for change in changes {
            let usage = &change.name.usage;
            let is_there = |one: &&BushingAssembly| {
                one.usage.eq_ignore_ascii_case(usage)
                    && one.symmetry.sides().contains(&change.name.side)
            };
            if !subsystem.bushings.iter().any(|one| is_there(&one)) {
                out.not_written.push(NotWritten {
                    what: change.because.clone(),
                    why: format!(
                        "the subsystem has no [BUSHING_ASSEMBLY] `{usage}` for the side of this bushing"
                    ),
                });
            }
        }
        let mut words = Vec::new();
        // Blocks are changed from the last to the first, so that the indices of the preceding blocks remain valid.
        for assembly in subsystem.bushings.iter().rev() {
            let before = out.changes.len();
            out.change_bushing(&subsystem.file, units, assembly, bushings, changes);
            words.push(out.changes.split_off(before));
        }
        out.changes.extend(words.into_iter().rev().flatten());
        out
    }

    /// Changes the block of one bushing in `self.bytes`. The preceding blocks are those of `file`.
    fn change_bushing(
        &mut self,
        file: &PropertyFile,
        units: &Units,
        assembly: &BushingAssembly,
        in_deck: &InDeck<String>,
        changes: &[BushingChange],
    ) {
        let usage = assembly.usage.to_ascii_lowercase();
        let of = |side: Side| {
            changes
                .iter()
                .find(|one| one.name.usage == usage && one.name.side == side)
        };
        let is_there = |side: Side| in_deck.contains(&(usage.clone(), side));
        let word = |symmetry: &'static str| Instance {
            assembly,
            units,
            symmetry,
        };
        if assembly.symmetry != Symmetry::Pair {
            let side = assembly.symmetry.sides()[0];
            let symmetry = match side {
                Side::Left => "left",
                Side::Right => "right",
                Side::Single => "single",
            };
            if let Some(one) = of(side) {
                self.change_block(file, assembly.block, &word(symmetry), one);
            }
            return;
        }
        let both = [of(Side::Left), of(Side::Right)];
        match both {
            [None, None] => {}
            [Some(one), None] if !is_there(Side::Right) => {
                self.change_block(file, assembly.block, &word("left/right"), one);
            }
            [None, Some(one)] if !is_there(Side::Left) => {
                let sided = one.preload.iter().chain(&one.offset);
                if sided.copied().any(|value| value.is_some()) {
                    self.not_written.push(NotWritten {
                        what: one.because.clone(),
                        why: format!(
                            "the block of bushing `{usage}` is for both sides, and the preload and offset of the left bushing do not follow from those of the right one"
                        ),
                    });
                }
                let without = BushingChange {
                    preload: [None; 6],
                    offset: [None; 6],
                    ..one.clone()
                };
                self.change_block(file, assembly.block, &word("left/right"), &without);
            }
            [Some(left), Some(right)] if are_alike(left, right) => {
                self.change_block(file, assembly.block, &word("left/right"), left);
            }
            [left, right] => {
                let now = self.now(file);
                let Some(copy) = repeated_block(&now, assembly.block) else {
                    return;
                };
                self.bytes = applied(&self.bytes, &[copy]);
                let now = self.now(file);
                // The copy is the next block with this name.
                let second = (assembly.block + 1..now.blocks.len())
                    .find(|at| now.blocks[*at].name == "BUSHING_ASSEMBLY");
                for (side, block, change) in [
                    ("right", second, right),
                    ("left", Some(assembly.block), left),
                ] {
                    let Some(block) = block else { continue };
                    self.set_key(file, block, "SYMMETRY", &format!("'{side}'"));
                    if let Some(change) = change {
                        self.change_block(file, block, &word(side), change);
                    }
                }
            }
        }
    }

    /// Parses the current bytes.
    fn now(&self, file: &PropertyFile) -> PropertyFile {
        PropertyFile::parse(Source::new(file.source().name(), self.bytes.as_slice())).value
    }

    /// Sets a key of a block to a new value, or adds the key. `value` is written as it is; a text in quotes keeps its quotes.
    fn set_key(&mut self, file: &PropertyFile, block: usize, key: &str, value: &str) {
        let now = self.now(file);
        let Some(found) = now.blocks.get(block) else {
            return;
        };
        let edits = match found.parameter(key) {
            Some(parameter) => {
                let mut span = parameter.value.span();
                let bytes = now.source().bytes();
                let quoted = span.start() > 0
                    && bytes.get(span.start() - 1) == Some(&b'\'')
                    && bytes.get(span.end()) == Some(&b'\'');
                if quoted {
                    span = Span::new(span.start() - 1, span.end() + 1);
                }
                vec![Edit::new(span, now.source().encoded(value))]
            }
            None => new_key(&now, block, key, value),
        };
        self.bytes = applied(&self.bytes, &edits);
    }

    /// Applies the changes of one bushing to one block.
    fn change_block(
        &mut self,
        file: &PropertyFile,
        block: usize,
        instance: &Instance<'_>,
        change: &BushingChange,
    ) {
        let element = format!("bushing {}", instance.assembly.usage);
        let word = |factor: &str, before: String, after: String, unit, std_error| WordChange {
            element: element.clone(),
            symmetry: instance.symmetry,
            factor: factor.to_ascii_lowercase(),
            before,
            after,
            unit,
            std_error,
            because: change.because.clone(),
        };
        let present = |this: &Self, key: &str| -> Option<(f64, String)> {
            let now = this.now(file);
            let cell = now.blocks.get(block)?.parameter(key)?.value;
            let text = String::from_utf8_lossy(now.source().slice(cell.span())).into_owned();
            Some((cell.number()?, text))
        };
        let put = |this: &mut Self, key: &str, usual: f64, value: &dyn Fn(f64) -> f64, unit, sd| {
            let old = present(this, key);
            let before = old.as_ref().map_or(usual, |(value, _)| *value);
            let after = rounded(value(before));
            let smallest = SMALLEST_CHANGE_RATIO * before.abs().max(f64::MIN_POSITIVE);
            if !after.is_finite() || (after - before).abs() <= smallest {
                return;
            }
            let style = old.map_or_else(|| "1.0".to_string(), |(_, text)| text);
            let text = spelled(after, style.as_bytes());
            this.set_key(file, block, key, &text);
            this.changes
                .push(word(key, format!("{before}"), text, unit, sd));
        };
        if let Some(learned) = &change.learned {
            for key in SCALES {
                put(self, key, 1.0, &|_| 1.0, String::new(), None);
            }
            let side = match instance.symmetry {
                "left" => "_left",
                "right" => "_right",
                _ => "",
            };
            let mut name = learned_name(&instance.assembly.usage, side);
            // Two names may differ only in characters that a file name must not contain.
            while self
                .files
                .iter()
                .any(|file| file.name.eq_ignore_ascii_case(&name))
            {
                name.insert(0, '_');
            }
            let old = instance.assembly.property_file.clone().unwrap_or_default();
            let folder = old.rfind(['/', '\\']).map_or("", |at| &old[..=at]);
            let new = format!("{folder}{name}");
            self.set_key(file, block, "PROPERTY_FILE", &format!("'{new}'"));
            self.changes
                .push(word("PROPERTY_FILE", old, new, String::new(), None));
            let text = learned.text(instance.units, &change.because);
            self.files.push(LearnedFile { name, text });
        } else {
            for (key, scale) in SCALES.iter().zip(change.scale) {
                let Some((ratio, error)) = scale else {
                    continue;
                };
                let before = present(self, key).map_or(1.0, |(value, _)| value);
                let error = error.map(|error| error * before.abs());
                put(
                    self,
                    key,
                    1.0,
                    &|before| before * ratio,
                    String::new(),
                    error,
                );
            }
        }
        for k in 0..6 {
            let (load, place) = if k < 3 {
                (Dimension::FORCE, Dimension::LENGTH)
            } else {
                (Dimension::TORQUE, Dimension::ANGLE)
            };
            let words = if k < 3 {
                [
                    force_word(file, instance.units),
                    length_word(file, instance.units),
                ]
            } else {
                [torque_word(file, instance.units), angle_word(file)]
            };
            let all = [
                (PRELOADS[k], change.preload[k], load),
                (OFFSETS[k], change.offset[k], place),
            ];
            for ((key, value, dimension), unit) in all.into_iter().zip(words) {
                let Some(value) = value else { continue };
                let value = value / factor(file, dimension, instance.units);
                put(self, key, 0.0, &|_| value, unit, None);
            }
        }
    }

    /// Returns the names that [`WriteBack::new`] may give to new property files, except names to which it adds `_` because they occur already.
    pub fn file_names(subsystem: &Subsystem) -> Vec<String> {
        let usages = subsystem.bushings.iter().map(|one| one.usage.as_str());
        usages
            .flat_map(|usage| ["", "_left", "_right"].map(|side| learned_name(usage, side)))
            .collect()
    }
}

/// Returns the name of a new property file for a bushing. Characters that are invalid in file names on some systems become underscores.
fn learned_name(usage: &str, side: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c
        } else {
            '_'
        }
    };
    let usage: String = usage
        .chars()
        .take(LEARNED_NAME_CHARACTERS)
        .map(plain)
        .collect();
    format!("{usage}{side}_learned.bus")
}

/// Keys of the scale factors in `[BUSHING_ASSEMBLY]`.
const SCALES: [&str; 6] = [
    "FX_SCALING_FACTOR",
    "FY_SCALING_FACTOR",
    "FZ_SCALING_FACTOR",
    "TX_SCALING_FACTOR",
    "TY_SCALING_FACTOR",
    "TZ_SCALING_FACTOR",
];

/// Keys of the preloads in `[BUSHING_ASSEMBLY]`: forces, then torques.
const PRELOADS: [&str; 6] = [
    "T_PRELOAD_X",
    "T_PRELOAD_Y",
    "T_PRELOAD_Z",
    "R_PRELOAD_X",
    "R_PRELOAD_Y",
    "R_PRELOAD_Z",
];

/// Keys of the offsets in `[BUSHING_ASSEMBLY]`: displacements, then angles. The names are those of Adams Insight; no public file has them.
const OFFSETS: [&str; 6] = [
    "T_OFFSET_X",
    "T_OFFSET_Y",
    "T_OFFSET_Z",
    "R_OFFSET_X",
    "R_OFFSET_Y",
    "R_OFFSET_Z",
];

/// Block to be changed.
struct Instance<'a> {
    assembly: &'a BushingAssembly,
    units: &'a Units,
    symmetry: &'static str,
}

/// Returns true if both sides of a bushing change in the same way.
fn are_alike(left: &BushingChange, right: &BushingChange) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SMALLEST_CHANGE_RATIO * a.abs().max(b.abs());
    let same = |pair: (Option<f64>, Option<f64>)| match pair {
        (Some(a), Some(b)) => near(a, b),
        (a, b) => a == b,
    };
    let scales = |one: &BushingChange| one.scale.map(|scale| scale.map(|(ratio, _)| ratio));
    scales(left).into_iter().zip(scales(right)).all(same)
        && left.preload.into_iter().zip(right.preload).all(same)
        && left.offset.into_iter().zip(right.offset).all(same)
        && left.learned == right.learned
}

/// Applies edits that do not overlap.
fn applied(bytes: &[u8], edits: &[Edit]) -> Vec<u8> {
    apply_edits(bytes, edits).unwrap_or_else(|_| bytes.to_vec())
}

#[cfg(test)]
mod tests;
