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
    car_file(bytes);
}

/// Edits one value of a file of Adams/Car, compares the files, reads all typed views, and writes results into it.
fn car_file(bytes: &[u8]) {
    let name = "a.sub";
    let source = Source::new(name, bytes);
    assert_inside(&admire_car::check(source.clone()), name, bytes);
    let read = admire_car::Subsystem::parse(source);
    assert_inside(&read.diagnostics, name, bytes);
    let subsystem = read.value;
    let file = &subsystem.file;
    let units = Units::default();
    admire_car::Assembly::of(file, &mut Vec::new());
    admire_car::Spring::of(file, &units);
    admire_car::Tire::of(file, &units);
    let all = admire_car::entries(file);
    assert_eq!(
        admire_car::diff(file, file, admire_syntax::diff::DiffTolerance::default()),
        []
    );
    // Which value is edited follows from the length of the file.
    if let Some(entry) = all.get(bytes.len() % all.len().max(1)) {
        let found = admire_car::select(file, &entry.address).unwrap_or_default();
        assert!(found.iter().any(|one| one == entry), "{entry:?}");
        for text in ["1.5", "word"] {
            let Ok(edits) = admire_car::set(file, entry, text) else {
                continue;
            };
            let new = apply_edits(bytes, &edits).expect("one place");
            let again = PropertyFile::parse(Source::new(name, new)).value;
            assert_eq!(admire_car::entries(&again).len(), all.len(), "{entry:?}");
        }
    }
    let moves: Vec<admire_car::HardpointMove> = subsystem
        .hardpoints
        .iter()
        .enumerate()
        .map(|(hardpoint, point)| admire_car::HardpointMove {
            hardpoint,
            side: point.symmetry.sides()[0],
            by: [1.0, -2.0, 0.0],
            std_error: [None; 3],
            because: "a test".to_string(),
        })
        .collect();
    let sides = subsystem
        .hardpoints
        .iter()
        .enumerate()
        .flat_map(|(at, point)| {
            let sides = point.symmetry.sides().iter();
            sides.map(move |side| (at, *side))
        });
    let changes: Vec<admire_car::BushingChange> = subsystem
        .bushings
        .iter()
        .map(|one| admire_car::BushingChange {
            name: admire_car::BushingName {
                side: one.symmetry.sides()[0],
                usage: one.usage.to_ascii_lowercase(),
            },
            scale: [Some((1.5, None)), None, None, None, None, Some((0.5, None))],
            preload: [None, Some(3.0), None, None, None, None],
            offset: [None, None, Some(0.2), None, Some(0.01), None],
            learned: None,
            because: "a test".to_string(),
        })
        .collect();
    let there = subsystem.bushings.iter().flat_map(|one| {
        let sides = one.symmetry.sides().iter();
        sides.map(|side| (one.usage.to_ascii_lowercase(), *side))
    });
    let written = admire_car::WriteBack::new(
        &subsystem,
        &units,
        &sides.collect(),
        &moves,
        &there.collect(),
        &changes,
    );
    admire_car::Subsystem::parse(Source::new(name, written.bytes));
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
    let mut seeds: Vec<Vec<u8>> = seeds::PROPERTIES
        .map(|text| text.as_bytes().to_vec())
        .into();
    seeds.extend(
        ["sub", "bus", "spr"]
            .iter()
            .flat_map(|ending| seeds::all(ending)),
    );
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
        "[HARDPOINT]\n",
        "{hardpoint_name symmetry x_value y_value z_value}\n",
        "'left/right'",
        "'right'",
        "[BUSHING_ASSEMBLY]\n",
        "SYMMETRY = 'left/right'\n",
        "USAGE = 'a'\n",
    ];
    fuzz("property-file", 6000, &seeds, &words.map(String::from));
}
