//! Tests of property files as other programs write and read them (grammar/NOTES.md, Sources).

use admire_syntax::property::{PropertyFile, PropertyKind};
use admire_syntax::text::Source;
use admire_syntax::units::Units;

fn read(text: &str) -> PropertyFile {
    let read = PropertyFile::parse(Source::new("a", text.as_bytes()));
    assert_eq!(read.diagnostics, []);
    read.value
}

/// Checks a bushing file whose rows directly follow the block name, without a heading line.
#[test]
fn a_bushing_file_may_leave_out_the_headings() {
    let file = read(
        "[MDI_HEADER]\nFILE_TYPE = 'bus'\n[UNITS]\nLENGTH = 'mm'\nFORCE = 'newton'\nANGLE = 'degrees'\nMASS = 'kg'\n\
         TIME = 'second'\n[DAMPING]\nFX_DAMPING = 10\nTX_DAMPING = 20\n[FX_CURVE]\n0 0\n1 100\n[TX_CURVE]\n0 0\n10 200\n",
    );
    assert_eq!(file.kind, PropertyKind::Bushing);
    let curves = file.bushing_curves(&Units::default());
    assert_eq!(curves[0], Some((vec![0.0, 1.0], vec![0.0, 100.0])));
    let (angle, torque) = curves[3].clone().expect("TX_CURVE");
    assert!((angle[1] - 10f64.to_radians()).abs() < 1e-15 && (torque[1] - 200.0).abs() < 1e-12);
    let damping = file.bushing_damping(&Units::default());
    assert!((damping[0] - 10.0).abs() < 1e-12);
    assert!((damping[3] - 20.0 / 1f64.to_radians()).abs() < 1e-9);
}

/// Checks the items that other programs read from a spring file: FREE_LENGTH, and the two columns after the line in braces.
#[test]
fn a_spring_file_has_a_free_length_and_one_curve() {
    let file = read(
        "$---MDI_HEADER\n[MDI_HEADER]\n FILE_TYPE     =  'spr'\n FILE_VERSION  =  4.0\n[UNITS]\n LENGTH  =  'mm'\n FORCE   =  'newton'\n\
         [SPRING_DATA]\n FREE_LENGTH  =  210.5\n[CURVE]\n{ disp  force}\n-100.0 -12500.0\n 0.0 0.0\n 100.0 12500.0\n",
    );
    assert_eq!(file.free_length(&Units::default()), Some(210.5));
    let curve = file.curve("CURVE").expect("CURVE");
    let (x, y) = curve.in_units(file.units.as_ref(), &Units::default());
    assert_eq!((x[0], y[2]), (-100.0, 12500.0));
}
