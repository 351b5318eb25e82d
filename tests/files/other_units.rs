//! Tests of unit conversion: motions stay the same, and settings either keep their meaning or are named.

use super::bulk::DECK;
use super::folder::Folder;

/// Solves a deck dynamically up to a time in its own units. Returns the columns of its variables, converted by the given factors.
fn motion(folder: &Folder, deck: &str, (second, variables): (f64, &[(&str, f64)])) -> Vec<f64> {
    let deck = admire::Deck::parse("d.adm", folder.read(deck).as_bytes());
    let commands = format!("SIMULATE/DYNAMIC, END={second}, STEPS=4\n");
    let run = deck.run_watched("r.acf", &commands, &admire::SharedProgress::default());
    run.succeeded().unwrap_or_else(|error| panic!("{error:?}"));
    let mut found = Vec::new();
    for (name, unit) in variables {
        let column = run.column(&format!("{name}.Q")).unwrap();
        found.extend(column[column.len() - 4..].iter().map(|x| x * unit));
    }
    found
}

/// Checks that converted decks move alike. Initial rates are converted with the unit of time, and adjusted initial velocities do not depend
/// on the units.
#[test]
fn other_units_move_alike() {
    let ics = "ics
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,2,3
PART/3, MASS=1, CM=30, IP=1,2,3
PART/4, MASS=1, CM=40, IP=1,2,3
PART/5, MASS=1, CM=50, IP=1E3,2E3,3E3
PART/6, MASS=1, CM=60, IP=1E3,2E3,3E3
MARKER/1, PART=1
MARKER/20, PART=2
MARKER/30, PART=3
MARKER/40, PART=4
MARKER/50, PART=5
MARKER/60, PART=6, QP=0,-50,0
MARKER/61, PART=6
JOINT/1, TRANSLATIONAL, I=20, J=1, IC=10, 200
JOINT/2, REVOLUTE, I=30, J=1, IC=10D, 2
JOINT/3, CYLINDRICAL, I=40, J=1, ICTRAN=10, 200, ICROT=10D, 2
JOINT/4, TRANSLATIONAL, I=50, J=1, IC=0, 100
JOINT/5, SPHERICAL, I=61, J=50
VARIABLE/1, FUNCTION=DZ(20,1)
VARIABLE/2, FUNCTION=AZ(30,1)
VARIABLE/3, FUNCTION=DZ(40,1)
VARIABLE/4, FUNCTION=AZ(40,1)
VARIABLE/5, FUNCTION=AX(61,1)
RESULTS/FORMATTED, XRF
END
";
    let folder = Folder::with(ics);
    let names = [
        "VARIABLE_1",
        "VARIABLE_2",
        "VARIABLE_3",
        "VARIABLE_4",
        "VARIABLE_5",
    ];
    // The value of a VARIABLE is not converted.
    let units: Vec<(&str, f64)> = names.into_iter().zip([1e-3, 1.0, 1e-3, 1.0, 1.0]).collect();
    let plain = motion(&folder, "d.adm", (1.0, &units));
    let expected = |from: f64, rate: f64| [0.25, 0.5, 0.75, 1.0].map(|t| from + rate * t);
    let turn = 10.0_f64.to_radians();
    for (k, exact) in [
        expected(0.01, 0.2),
        expected(turn, 2.0),
        expected(0.01, 0.2),
        expected(turn, 2.0),
    ]
    .concat()
    .into_iter()
    .enumerate()
    {
        assert!((plain[k] - exact).abs() < 1e-6, "{k}: {} {exact}", plain[k]);
    }
    // The initial rate minimises (v + r w)^2 + w^2 in metres and radians. Here v + r w is the velocity of the mass centre, 50 mm from a
    // point that moves at 0.1 m/s.
    let rate = 0.1 * 0.05 / (1.0 + 0.05 * 0.05);
    let begins = plain[16] / 0.25;
    assert!((begins.abs() / rate - 1.0).abs() < 1e-2, "{begins} {rate}");
    for (to, second) in [("mks", 1.0), ("millisecond,inch", 1e3)] {
        let (code, out, said) = folder.run(&["convert-units", "d.adm", "--to", to]);
        assert_eq!(code, 0, "{said}");
        assert!(
            said.contains("command files of this dataset are not converted"),
            "{said}"
        );
        folder.write("new.adm", &out);
        let new = motion(&folder, "new.adm", (second, &units));
        for (k, (a, b)) in plain.iter().zip(&new).enumerate() {
            assert!((a - b).abs() < 1e-6 * (1.0 + a.abs()), "{to} {k}: {a} {b}");
        }
    }
}

/// Checks that limits in units of force or length are converted and that defaults which depend on the unit are written out. A tolerance
/// shared by lengths and angles is named.
#[test]
fn settings_are_converted_or_named() {
    let deck = DECK.replace(
        "END\n",
        "EQUILIBRIUM/IMBALANCE=1E-6, TLIMIT=20\nINTEGRATOR/ERROR=1E-5\nJOINT/77, REVOLUTE, I=30, J=10\nFRICTION/1, JOINT=77, MU_STATIC=0.5\nEND\n",
    );
    let folder = Folder::with(&deck);
    let to = "meter,knewton";
    let (code, out, said) = folder.run(&["convert-units", "d.adm", "--to", to]);
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("IMBALANCE=1E-9, TLIMIT=0.02"), "{out}");
    assert!(out.contains("PIN_RADIUS=0.001"), "{out}");
    assert!(
        said.contains("ERROR of INTEGRATOR keeps its value"),
        "{said}"
    );
    folder.write("r.acf", "d\n\nSIMULATE/STATICS\n");
    let (code, _, said) = folder.run(&["convert-units", "r.acf", "--to", to]);
    assert!(
        code == 2 && said.contains("a command file cannot be converted"),
        "{said}"
    );
}
