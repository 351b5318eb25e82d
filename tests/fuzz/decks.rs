//! Fuzz targets for datasets, command files and property files.

use admire_solver::model::Model;
use admire_solver::system::System;
use admire_syntax::lint::{Options, check, check_commands};
use admire_syntax::property::PropertyFile;
use admire_syntax::renumber::{in_order, renumber};
use admire_syntax::text::{Edit, Source, Span, apply_edits};
use admire_syntax::units::Units;
use admire_syntax::{Address, CommandFile, Dataset, Value, all_fixes, layout};
use rand::RngExt;

use crate::common::tiling::{assert_commands, assert_dataset};
use crate::harness::{assert_inside, fuzz};
use crate::mutation::{drawn, grammar_words};
use crate::seeds;

/// Parses, checks, lowers and compiles a deck, and then edits, lays out and renumbers it.
pub fn deck(bytes: &[u8]) {
    let read = Dataset::parse(Source::new("a.adm", bytes));
    let dataset = &read.value;
    assert_dataset(dataset, bytes);
    assert_inside(&read.diagnostics, "a.adm", bytes);
    let lint = check(dataset, &Options::default());
    assert_inside(&lint, "a.adm", bytes);
    for found in [&read.diagnostics, &lint] {
        apply_edits(bytes, &all_fixes(found, "a.adm")).expect("fixes that can be made");
    }
    let lowered = Model::lower(dataset);
    assert_inside(&lowered.diagnostics, "a.adm", bytes);
    let design = admire_solver::model::lint::check(dataset, &lowered.value);
    assert_inside(&design, "a.adm", bytes);
    if !read.has_errors() && !lowered.has_errors() {
        let compiled = System::compile(&lowered.value);
        assert_inside(&compiled.diagnostics, "a.adm", bytes);
    }
    edits_are_local(dataset);
    what_is_renumbered_is_read(dataset);
}

/// Returns the addresses of the numbers of a deck, each with the span of its argument.
fn numbers(dataset: &Dataset) -> Vec<(Address, Span)> {
    let mut all = Vec::new();
    for (at, statement) in dataset.statements().iter().enumerate() {
        let Some(object) = Address::of(statement) else {
            continue;
        };
        // An address refers to the first statement with its kind and id.
        if dataset.position(&object.kind, object.id) != Some(at) {
            continue;
        }
        for argument in &statement.arguments {
            let (Some(def), Value::Numbers(numbers)) = (argument.def, &argument.value) else {
                continue;
            };
            if statement
                .arguments
                .iter()
                .filter(|a| a.def == argument.def)
                .count()
                > 1
            {
                continue;
            }
            for k in 0..numbers.len() {
                let address = Address {
                    argument: Some(def.name.to_string()),
                    index: Some(k + 1),
                    ..object.clone()
                };
                all.push((address, argument.span));
            }
        }
    }
    all
}

/// Checks that setting a number gives the new value and changes only its argument. Also checks layout and removal.
fn edits_are_local(dataset: &Dataset) {
    let mut random = drawn(dataset.bytes());
    let numbers = numbers(dataset);
    for _ in 0..numbers.len().min(2) {
        let (address, place) = &numbers[random.random_range(0..numbers.len())];
        let value = [7.0, -2.25e-3, 1e-320, 1e308, 12345.678][random.random_range(0..5)];
        let Ok(edits) = dataset.set(address, value) else {
            continue;
        };
        // The points that define the axes of a marker move with its origin, so their arguments change too.
        let has_points = address.kind == "MARKER" && address.argument.as_deref() == Some("QP");
        assert!(
            has_points || edits.len() <= 1 && edits.iter().all(|edit| place.contains(edit.span)),
            "{address} = {value}: {edits:?} outside of {place:?}"
        );
        let after = dataset
            .edited(&edits)
            .expect("edits that can be made")
            .value;
        let applied = apply_edits(dataset.bytes(), &edits).expect("edits that can be made");
        assert_dataset(&after, &applied);
        assert_eq!(after.value_at(address), Some(value), "{address}");
        assert_eq!(after.statements().len(), dataset.statements().len());
        assert_eq!(after.set(address, value), Ok(Vec::new()), "a second time");
    }
    let all = Span::new(0, dataset.bytes().len());
    let laid = dataset
        .edited(&layout::layout(dataset, all))
        .expect("edits that can be made");
    assert_eq!(laid.value.statements().len(), dataset.statements().len());
    if let Some((address, _)) = numbers.first() {
        assert_eq!(
            laid.value.value_at(address),
            dataset.value_at(address),
            "{address}"
        );
    }
    // Removing an object reduces the number of statements. END is skipped, because its removal may expose further statements after it.
    let objects = dataset.statements().iter().filter_map(Address::of);
    if let Some(object) = objects.into_iter().find(|object| object.kind != "END")
        && let Ok(edits) = dataset.remove(&object)
    {
        let after = dataset
            .edited(&edits)
            .expect("edits that can be made")
            .value;
        assert!(
            after.statements().len() < dataset.statements().len(),
            "{object}"
        );
    }
}

/// Checks that each renumbered marker is found under its new id at its old position.
fn what_is_renumbered_is_read(dataset: &Dataset) {
    let renumbering = in_order(dataset, "MARKER", 1_000_001, 3);
    let Ok(edits) = renumber(dataset, &[], &renumbering) else {
        return;
    };
    let after = dataset
        .edited(&edits.value.dataset)
        .expect("edits that can be made");
    assert_eq!(after.value.statements().len(), dataset.statements().len());
    for ((_, old), new) in &renumbering {
        let (before, after) = (
            dataset.position("MARKER", Some(*old)),
            after.value.position("MARKER", Some(*new)),
        );
        assert_eq!(before, after, "MARKER/{old} as {new}");
    }
}

pub fn commands(bytes: &[u8]) {
    let read = CommandFile::parse(Source::new("a.acf", bytes));
    assert_commands(&read.value, bytes);
    assert_inside(&read.diagnostics, "a.acf", bytes);
    let found = check_commands(&read.value);
    assert_inside(&found, "a.acf", bytes);
    let all = Span::new(0, bytes.len());
    let edits: Vec<Edit> = layout::layout_of_commands(&read.value, all);
    let laid = apply_edits(bytes, &edits).expect("edits that can be made");
    let again = CommandFile::parse(Source::new("a.acf", laid)).value;
    assert_eq!(again.commands().len(), read.value.commands().len());
}

pub fn property(bytes: &[u8]) {
    // The kind follows from the bytes if possible, and otherwise from the file name extension.
    for name in ["a.bus", "a.spr"] {
        let read = PropertyFile::parse(Source::new(name, bytes));
        assert_inside(&read.diagnostics, name, bytes);
        let file = &read.value;
        assert_eq!(file.source().bytes(), bytes);
        PropertyFile::is_one(bytes);
        let units = Units::default();
        for curve in file.curves() {
            let (x, y) = curve.in_units(file.units.as_ref(), &units);
            assert_eq!(x.len(), y.len());
        }
        for (x, y) in file.bushing_curves(&units).into_iter().flatten() {
            assert_eq!(x.len(), y.len());
        }
        file.bushing_damping(&units);
        file.free_length(&units);
        for block in &file.blocks {
            assert!(block.heading.end() <= bytes.len());
            for table in &block.tables {
                assert!(table.span.end() <= bytes.len());
                let cells = table.rows.iter().flatten();
                assert!(
                    cells
                        .map(admire_syntax::property::Cell::span)
                        .all(|span| span.end() <= bytes.len())
                );
            }
        }
    }
}

#[test]
fn datasets() {
    let seeds = [seeds::all("adm"), seeds::faults("adm")].concat();
    fuzz("dataset", 1500, &seeds, &grammar_words());
}

#[test]
fn command_files() {
    let seeds = [seeds::all("acf"), seeds::faults("acf")].concat();
    fuzz("command-file", 4000, &seeds, &grammar_words());
}

#[test]
fn property_files() {
    let seeds: Vec<Vec<u8>> = seeds::PROPERTIES
        .map(|text| text.as_bytes().to_vec())
        .into();
    let words = [
        "[",
        "]",
        "{",
        "}",
        "(",
        ")",
        "'",
        "$",
        "[MDI_HEADER]\n",
        "FILE_TYPE = 'bus'\n",
        "[FX_CURVE]\n",
        "[UNITS]\n",
        "inch",
    ];
    fuzz("property-file", 6000, &seeds, &words.map(String::from));
}
