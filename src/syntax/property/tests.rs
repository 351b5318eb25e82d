use super::*;

const BUSHING: &str =
    "$---------------------------------------------------------------------MDI_HEADER\r
[MDI_HEADER]\r
 FILE_TYPE     =  'bus'\r
 FILE_VERSION  =  4.0\r
 FILE_FORMAT   =  'ASCII'\r
(COMMENTS)\r
{comment_string}\r
'soft = in x, $5'\r
$--------------------------------------------------------------------------UNITS\r
[UNITS]\r
 LENGTH  =  'mm'\r
 ANGLE   =  'degrees'\r
 FORCE   =  'kN'\r
 MASS    =  'kg'\r
 TIME    =  'second'\r
[DAMPING]\r
 FX_DAMPING = 0.002\r
 TX_DAMPING = 0.5\r
[FX_CURVE]\r
{ x  fx}\r
-2.0   -4.0 ! outer\r
 0.0    0.0\r
 2.0,   4.0\r
[TX_CURVE]\r
{ ax  tx}\r
-10   -1.0\r
 10    1.0\r
";

fn read(name: &str, text: &str) -> Checked<PropertyFile> {
    PropertyFile::parse(Source::new(name, text.as_bytes()))
}

#[test]
fn a_bushing_file_is_six_curves_in_units_of_the_model() {
    assert!(PropertyFile::is_one(BUSHING.as_bytes()));
    let read = read("soft.bus", BUSHING);
    assert_eq!(read.diagnostics, []);
    let file = read.value;
    assert_eq!(
        (&file.kind, file.version),
        (&PropertyKind::Bushing, Some(4.0))
    );
    assert_eq!(file.source().bytes(), BUSHING.as_bytes());
    // In newtons, millimetres and radians: 2 kN at 1 mm, and 0.1 kN mm at one degree.
    let units = Units::default();
    let curves = file.bushing_curves(&units);
    let (x, y) = curves[0].clone().expect("FX_CURVE");
    assert_eq!(
        (x.as_slice(), y.as_slice()),
        (&[-2.0, 0.0, 2.0][..], &[-4e3, 0.0, 4e3][..])
    );
    let (angle, torque) = curves[3].clone().expect("TX_CURVE");
    assert!((angle[1] - 10f64.to_radians()).abs() < 1e-15 && (torque[1] - 1e3).abs() < 1e-9);
    assert!(curves[1].is_none());
    let damping = file.bushing_damping(&units);
    assert!((damping[0] - 2.0).abs() < 1e-12);
    assert!((damping[3] - 500.0 / 1f64.to_radians()).abs() < 1e-6);
    // The row of the part COMMENTS contains an equals sign, but it is a text in quotes and not a parameter.
    let comment = &file.blocks[1];
    assert_eq!(
        (comment.part.as_deref(), comment.tables.len()),
        (Some("COMMENTS"), 1)
    );
}

#[test]
fn springs_stops_and_dampers_say_what_they_measure() {
    let spring = "[MDI_HEADER]\nFILE_TYPE='spr'\n[UNITS]\nLENGTH='meter'\nFORCE='newton'\n[SPRING_DATA]\nFREE_LENGTH = 0.3\n[CURVE]\n{disp force}\n-0.1 -2000\n0.1 2000\n";
    let file = read("a.spr", spring).value;
    assert_eq!(file.free_length(&Units::default()), Some(300.0));
    let curve = file.curve("curve").expect("CURVE");
    let (x, y) = curve.in_units(file.units.as_ref(), &Units::default());
    assert_eq!((x[1], y[1]), (100.0, 2000.0));
    let damper = read("a.dpr", &spring.replace("'spr'", "'dpr'")).value;
    assert_eq!(damper.kind, PropertyKind::Damper);
    assert_eq!(
        damper.curve("CURVE").expect("CURVE").dimensions,
        Some((VELOCITY, Dimension::FORCE))
    );
    let stop = read("a.bum", &spring.replace("'spr'", "'bum'")).value;
    assert_eq!(stop.kind, PropertyKind::Stop);
}

const VELOCITY: Dimension = Dimension::new(0, 0, 1, -1, 0);

#[test]
fn what_is_wrong_is_said_where_it_is() {
    let codes = |text: &str| -> Vec<Code> {
        let found = read("a.bus", text).diagnostics;
        assert!(found.iter().all(|d| !d.labels.is_empty()), "{found:?}");
        found.iter().map(|d| d.code).collect()
    };
    let head = "[UNITS]\nLENGTH='mm'\n[TX_CURVE]\n0 0\n1 1\n[MDI_HEADER]\nFILE_TYPE='bus'\n";
    assert_eq!(codes("<?xml version='1.0'?>"), [Code::SyntaxError; 2]);
    assert_eq!(
        codes(&format!("{head}[FX_CURVE]\n{{x fx}}\n1 2\n0 3\n")),
        [Code::SplineNotIncreasing]
    );
    assert_eq!(
        codes(&format!("{head}[FX_CURVE]\n{{x fx}}\n1 2 3\n")),
        [Code::WrongCount]
    );
    assert_eq!(codes(&head.replace("mm", "cubit")), [Code::WrongType]);
    assert_eq!(
        codes("1 2\n[MDI_HEADER]\nFILE_TYPE='bus'\n"),
        [
            Code::SyntaxError,
            Code::MissingArgument,
            Code::MissingArgument
        ]
    );
}

#[test]
fn any_bytes_are_read() {
    for text in [
        "",
        "[",
        "]",
        "()",
        "{}",
        "'",
        "[]\n'\n{\n}=\n=",
        "\u{0}$!\n[A]\n1e999 ''",
    ] {
        let found = read("a.bus", text);
        assert_eq!(found.value.source().bytes(), text.as_bytes());
    }
    assert!(!PropertyFile::is_one(b"[UNITS]"));
}
