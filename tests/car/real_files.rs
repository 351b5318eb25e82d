//! Public files that Adams/Car wrote (../shared/real-car-files). Expected values were read from the files by eye.

use std::path::PathBuf;

use admire_car::{
    Assembly, Side, Spring, Subsystem, Symmetry, Tire, check, diff, entries, select, set,
    set_number,
};
use admire_syntax::diff::DiffTolerance;
use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::units::Units;

use crate::common::shared;

/// Returns the public files in TeimOrbit format, with their bytes.
fn files() -> Vec<(PathBuf, Vec<u8>)> {
    let Some(folder) = shared("real-car-files") else {
        return Vec::new();
    };
    ["sub", "asy", "spr", "tir"]
        .iter()
        .flat_map(|ending| crate::common::files_below(&folder, ending))
        .map(|path| {
            let bytes = std::fs::read(&path).expect("readable file");
            (path, bytes)
        })
        .collect()
}

fn parse(name: &str) -> Option<PropertyFile> {
    let path = shared("real-car-files")?.join(name);
    let source = Source::read(&path).expect("readable file");
    assert!(PropertyFile::is_one(source.bytes()), "{name}");
    Some(PropertyFile::parse(source).value)
}

fn near(a: Option<f64>, b: f64) {
    let a = a.expect("a number");
    assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
}

#[test]
fn no_public_file_is_complained_of() {
    for (path, bytes) in files() {
        assert!(PropertyFile::is_one(&bytes), "{}", path.display());
        let found = check(Source::new(path.display().to_string(), bytes));
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
    }
}

/// Checks every value of every file. An edit to the same text changes nothing. An edit to another value changes only the bytes of that value,
/// and the reverse edit restores the file.
#[test]
fn every_value_is_edited_without_touching_another_byte() {
    for (path, bytes) in files() {
        let name = path.display().to_string();
        let file = PropertyFile::parse(Source::new(name.as_str(), bytes.as_slice())).value;
        let all = entries(&file);
        assert!(all.len() > 40, "{name} has {} values", all.len());
        // Each address names one value.
        let mut addresses: Vec<String> =
            all.iter().map(|e| e.address.to_ascii_lowercase()).collect();
        addresses.sort();
        addresses.dedup();
        assert_eq!(addresses.len(), all.len(), "{name}");
        for (at, entry) in all.iter().enumerate() {
            let span = entry.cell.span();
            let written = String::from_utf8_lossy(file.source().slice(span)).into_owned();
            let same = set(&file, entry, &written).expect("its own text");
            assert!(
                apply_edits(&bytes, &same).expect("one place") == bytes,
                "{name} {}",
                entry.address
            );
            let edits = match entry.cell.number() {
                Some(value) => set_number(&file, entry, value + 1.25).expect("a number"),
                None => set(&file, entry, "changed").expect("a text"),
            };
            let new = apply_edits(&bytes, &edits).expect("one place");
            let behind = bytes.len() - span.end();
            assert_eq!(new[..span.start()], bytes[..span.start()], "{name}");
            assert_eq!(new[new.len() - behind..], bytes[span.end()..], "{name}");
            // Only every tenth value is read again, to keep this test short.
            if at % 10 == 0 {
                let again = PropertyFile::parse(Source::new(name.as_str(), new.as_slice())).value;
                assert_eq!(again.source().bytes(), new);
                let back = &entries(&again)[at];
                let edits = set(&again, back, &written).expect("the old text");
                let restored = apply_edits(&new, &edits).expect("one place");
                if entry.cell.number().is_some() {
                    assert!(restored == bytes, "{name} {}", entry.address);
                    let found = diff(&file, &again, DiffTolerance::default());
                    assert_eq!(found.len(), 1, "{name} {}", entry.address);
                }
            }
        }
    }
}

#[test]
fn a_subsystem_has_hardpoints_parameters_and_blocks() {
    let Some(folder) = shared("real-car-files") else {
        return;
    };
    let source = Source::read(&folder.join("fsae_front_susp.sub")).expect("readable file");
    let read = Subsystem::parse(source);
    assert_eq!(read.diagnostics, []);
    let sub = read.value;
    assert_eq!(sub.major_role.as_deref(), Some("suspension"));
    assert_eq!(sub.minor_role.as_deref(), Some("front"));
    assert_eq!(
        sub.template.as_deref(),
        Some("mdids://fsae_2012/templates.tbl/_fsae_frontsusp.tpl")
    );
    assert_eq!((sub.hardpoints.len(), sub.parameters.len()), (17, 11));
    let outer = sub
        .hardpoints
        .iter()
        .find(|point| point.name == "lca_outer")
        .expect("lca_outer");
    assert_eq!(outer.symmetry, Symmetry::Pair);
    assert_eq!(outer.place(Side::Left), Some([-512.0, -716.0, 27.4]));
    assert_eq!(outer.place(Side::Right), Some([-512.0, 716.0, 27.4]));
    assert_eq!(outer.place(Side::Single), None);
    assert_eq!(outer.full_name(Side::Right), "hpr_lca_outer");
    assert_eq!(sub.hardpoints[0].symmetry, Symmetry::Single);
    let metre = admire_syntax::units::LENGTH_UNITS
        .iter()
        .find(|unit| unit.keyword == "METER")
        .expect("metre");
    let units = Units {
        length: *metre,
        ..Units::default()
    };
    let place = outer
        .place_in(&sub.file, Side::Right, &units)
        .expect("right");
    assert!((place[1] - 0.716).abs() < 1e-15);
    let drive = sub
        .parameters
        .iter()
        .find(|parameter| parameter.name == "drive_shaft_offset")
        .expect("drive_shaft_offset");
    assert_eq!(
        (drive.kind.as_str(), drive.value.number()),
        ("real", Some(75.0))
    );
    // Blocks with the same name are distinguished by USAGE and by their order.
    for (address, expected) in [
        ("PART_ASSEMBLY/upright.IXX", 508.381_210_529_8),
        ("LINK_GEOMETRY/lca_rear.RADIUS", 9.525),
        ("ADJUSTABLE_FORCE/toe_adjuster.STIFFNESS", 9.999_999_999_9e5),
        ("NSPRING_ASSEMBLY/ride_spring.USER_VALUE", 189.5),
        ("NSPRING_ASSEMBLY/ride_spring#2.USER_VALUE", 2000.0),
        ("BUMPSTOP_ASSEMBLY.USER_DISTANCE", 250.0),
    ] {
        let found = select(&sub.file, address).expect(address);
        assert_eq!(found.len(), 1, "{address}");
        near(found[0].cell.number(), expected);
    }
}

#[test]
fn an_assembly_names_its_subsystems() {
    let Some(file) = parse("fsae_full_vehicle.asy") else {
        return;
    };
    let mut out = Vec::new();
    let assembly = Assembly::of(&file, &mut out);
    assert_eq!(out, []);
    assert_eq!(assembly.class.as_deref(), Some("full_vehicle"));
    assert_eq!(assembly.subsystems.len(), 10);
    assert_eq!(
        assembly.subsystems[2],
        "<fsae_2012>/subsystems.tbl/fsae_steering.sub"
    );
    assert_eq!(assembly.testrig.as_deref(), Some("__MDI_SDI_TESTRIG"));
    assert_eq!(assembly.hardpoints.len(), 2);
    assert_eq!(assembly.parameters.len(), 8);
    let rack = assembly
        .parameters
        .iter()
        .find(|parameter| parameter.name == "rack_ratio")
        .expect("rack_ratio");
    assert_eq!(rack.value.number(), Some(83.3));
    assert_eq!(
        rack.remark.as_deref(),
        Some("swa to rack displacement ratio in S.I. (rad/meter)")
    );
    assert_eq!(assembly.parameters[0].remark, None);
}

#[test]
fn a_spring_and_a_tyre_are_in_the_units_of_the_model() {
    if let Some(file) = parse("spring_125kN.spr") {
        let spring = Spring::of(&file, &Units::default()).expect("a curve");
        assert_eq!(spring.free_length, Some(300.0));
        assert_eq!(spring.displacement.len(), 21);
        assert_eq!(
            (spring.displacement[0], spring.force[0]),
            (-10.0, -1_250_000.0)
        );
        assert_eq!(
            (spring.displacement[20], spring.force[20]),
            (10.0, 1_250_000.0)
        );
    }
    if let Some(file) = parse("tire.tir") {
        // The file is in metres: 0.326 m, 2.1e5 N/m, 50 N s/m.
        let tire = Tire::of(&file, &Units::default());
        assert_eq!(tire.format.as_deref(), Some("PAC2002"));
        near(tire.unloaded_radius, 326.0);
        near(tire.width, 235.0);
        near(tire.rim_radius, 228.6);
        near(tire.vertical_stiffness, 210.0);
        near(tire.vertical_damping, 0.05);
        near(tire.nominal_load, 4850.0);
    }
}
