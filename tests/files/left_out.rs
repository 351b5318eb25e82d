//! Tests that arguments which only real ADAMS supports are reported, and that DYNAMIC_HOLD and switched states are obeyed.

use std::process::Command;

use admire::{Deck, SharedProgress};
use admire_syntax::grammar::{STATEMENTS, ValueKind};

use super::folder::Folder;

const HEAD: &str = "deck
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/1, PART=1
MARKER/20, PART=2
";

/// Returns a statement of a kind, to which an argument can be appended, and the further statements that its deck needs.
fn statement(kind: &str) -> (String, &'static str) {
    let (text, beside) = match kind {
        "JOINT" => ("JOINT/1, REVOLUTE, I=20, J=1", ""),
        "VARIABLE" => ("VARIABLE/1, FUNCTION=2\\", "JOINT/1, FIXED, I=20, J=1\n"),
        "EQUILIBRIUM" => ("EQUILIBRIUM/MAXIT=30", "JOINT/1, FIXED, I=20, J=1\n"),
        other => panic!("no deck for {other}"),
    };
    (text.to_string(), beside)
}

/// Checks every unsupported argument of the grammar in a deck of its own: `check`, the JSON of `solve` and the message file report it.
#[test]
fn every_argument_that_is_left_out_is_named() {
    let mut count = 0;
    for def in STATEMENTS {
        for argument in def.left_out.iter().flat_map(|left| left.arguments) {
            let known = def.arguments.iter().find(|a| a.name == *argument).unwrap();
            let value = match known.kind {
                ValueKind::Flag => String::new(),
                ValueKind::Choice(words) => {
                    let on = words.iter().find(|word| word.name != "OFF").unwrap();
                    format!("={}", on.name)
                }
                _ => "=0.5".to_string(),
            };
            let (text, beside) = statement(def.name);
            let folder = Folder::with(&format!(
                "{HEAD}{beside}{text}, {argument}{value}\nRESULTS/XRF\nEND\n"
            ));
            let wanted = format!("{argument} of {}", def.name);
            let (code, said, _) = folder.run(&["check", "d.adm", "--format", "plain"]);
            assert!(code == 0 && said.contains(&wanted), "{argument}: {said}");
            let (_, out, said) = folder.run(&["solve", "d.adm", "--format", "json"]);
            assert!((out + &said).contains(&wanted), "{argument}: {said}");
            folder.write("r.acf", "\nfile/model=d\nSIMULATE/STATICS\nSTOP\n");
            let run = Command::new(env!("CARGO_BIN_EXE_mdi"))
                .current_dir(folder.path())
                .args(["ru-s", "r.acf"])
                .output();
            run.expect("mdi runs");
            let messages = folder.read("d.msg");
            let lines: Vec<&str> = messages.split_whitespace().collect();
            assert!(lines.join(" ").contains(&wanted), "{argument}: {messages}");
            count += 1;
        }
    }
    assert!(count >= 19, "{count}");
    let off = format!("{HEAD}JOINT/1, REVOLUTE, I=20, J=1, MU_DYN_ROT=0.5, FRICTION=OFF\nEND\n");
    let (_, said, _) = Folder::with(&off).run(&["check", "d.adm", "--format", "plain"]);
    assert!(!said.contains("MU_DYN_ROT"), "{said}");
}

/// Returns the time and the value of VARIABLE/1 at every output step.
fn values(deck: &str, commands: &str) -> Vec<(f64, f64)> {
    let run = Deck::parse("d.adm", deck.as_bytes()).run_watched(
        "r.acf",
        commands,
        &SharedProgress::default(),
    );
    run.succeeded()
        .unwrap_or_else(|error| panic!("{error:?} {}", run.messages()));
    let (times, values) = (
        run.column("time.TIME").unwrap(),
        run.column("VARIABLE_1.Q").unwrap(),
    );
    times.into_iter().zip(values).collect()
}

fn at(values: &[(f64, f64)], time: f64) -> f64 {
    let found = values.iter().rfind(|(t, _)| (t - time).abs() < 1e-9);
    found
        .unwrap_or_else(|| panic!("nothing at {time}: {values:?}"))
        .1
}

fn with_state(state: &str) -> String {
    format!(
        "{HEAD}JOINT/1, REVOLUTE, I=20, J=1\nVARIABLE/1, FUNCTION=DIF(1)\n{state}\nRESULTS/FORMATTED, XRF\nEND\n"
    )
}

#[test]
fn a_state_is_held_in_motion() {
    let run = "SIMULATE/DYNAMIC, END=1, STEPS=10";
    let free = values(&with_state("DIFF/1, IC=0.5, FUNCTION=1"), run);
    assert!((at(&free, 1.0) - 1.5).abs() < 1e-6, "{free:?}");
    for held in [
        "DIFF/1, IC=0.5, DYNAMIC_HOLD, FUNCTION=1",
        "DIFF/1, IC=0.5, IMPLICIT, DYNAMIC_HOLD, FUNCTION=DIF1(1)-1",
    ] {
        let held = values(&with_state(held), run);
        assert!(held.iter().skip(1).all(|(_, x)| *x == 0.5), "{held:?}");
    }
}

/// Checks that a deactivated state is zero, and that it restarts from its initial value in the dataset when activated.
#[test]
fn states_are_switched_off_and_on() {
    let found = values(
        &with_state("DIFF/1, IC=1, FUNCTION=2"),
        "SIMULATE/DYNAMIC, END=1, STEPS=4\nDEACTIVATE/DIFF, ID=1\nSIMULATE/DYNAMIC, END=2, STEPS=4\n\
         ACTIVATE/DIFF, ID=1\nSIMULATE/DYNAMIC, END=3, STEPS=4",
    );
    assert!((at(&found, 0.5) - 2.0).abs() < 1e-6, "{found:?}");
    for time in [1.25, 1.5, 1.75] {
        assert_eq!(at(&found, time), 0.0, "{found:?}");
    }
    assert!((at(&found, 2.5) - 2.0).abs() < 1e-6, "{found:?}");
    // The filter is x' = -2 x + u, y = 3 x.
    let filter = "VARIABLE/2, FUNCTION=1\nARRAY/1, X, SIZE=1\nARRAY/2, U, SIZE=1, VARIABLES=2\nARRAY/3, Y, SIZE=1\n\
        TFSISO/1, X=1, U=2, Y=3, NUMERATOR=3, DENOMINATOR=2,1";
    let deck = with_state(filter).replace("FUNCTION=DIF(1)", "FUNCTION=ARYVAL(3,1)");
    let found = values(
        &deck,
        "SIMULATE/DYNAMIC, END=1, STEPS=4\nDEACTIVATE/TFSISO, ID=1\nSIMULATE/DYNAMIC, END=2, STEPS=4",
    );
    let exact = 1.5 * (1.0 - (-1.0_f64).exp());
    assert!((at(&found, 0.5) - exact).abs() < 1e-4, "{found:?}");
    assert_eq!(at(&found, 1.5), 0.0, "{found:?}");
}

/// Arguments of solved statements that no code reads and that change no result.
const WITHOUT_EFFECT: &[(&str, &[&str])] = &[
    // Used for graphics and for masses computed by ADAMS/View.
    ("PART", &["MATERIAL"]),
    // Places a marker on a flexible body, which is not solved.
    ("MARKER", &["NODE_ID", "NODE_LABEL"]),
    // Settings of AUTOBALANCE trimming.
    ("VARIABLE", &["BEST", "WEIGHT", "PENALTY", "PENALTY1"]),
    // Selects a part of a file that is not read.
    ("MATRIX", &["NAME"]),
    ("SPLINE", &["CHANNEL"]),
    // Accuracy of event location. The event is located by an integration step that ends at it, and the integrator restarts there.
    (
        "SENSOR",
        &[
            "EVALUATE_ROUTINE",
            "BISECTION",
            "TIME_ERROR",
            "TERROR",
            "RESTART",
        ],
    ),
    // Parameters of formulations that are refused by name.
    ("FIELD", &["LENGTH_TOL"]),
    (
        "FRICTION",
        &[
            "STRIBECK_VELOCITY",
            "BRISTLE_STIFFNESS",
            "BRISTLE_DAMPING",
            "VISCOUS_COEFFICIENT",
            "DAMPING_EXPONENT",
        ],
    ),
    // The default; ACTIONONLY is its opposite.
    ("SFORCE", &["REACTION"]),
    // Selection of the output that is written.
    (
        "OUTPUT",
        &[
            "LOADS",
            "MODAL_DEFORMATION",
            "NODAL_DEFORMATION",
            "STRESS",
            "STRAIN",
            "NOCHART",
        ],
    ),
    (
        "RESULTS",
        &["NODATASTRUCTURES", "NOLINEAR", "NOTIRES", "NOCONTACTS"],
    ),
    ("REQUEST", &["CLABELS"]),
    // Settings of DYNAMIC equilibrium, or tolerances of ADVANCED equilibrium.
    (
        "EQUILIBRIUM",
        &[
            "STATIC",
            "ACCELERATION_ERROR",
            "KINETIC_ENERGY_ERROR",
            "GLOBAL_DAMPING",
            "SETTLING_TIME",
            "ATOL",
            "RTOL",
            "MAXITL",
            "ETAMAX",
            "ETA",
        ],
    ),
    // Named in the message file but without effect: initial conditions are met to rounding error.
    ("IC", &["AERROR", "AMAXIT", "APATTERN", "VERROR"]),
];

/// Checks that every argument of a solved statement is read by some code, is reported as unsupported, or is listed as without effect.
#[test]
fn no_argument_is_dropped_without_a_word() {
    use admire_syntax::grammar::{Role, Solved};
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut read = String::new();
    for folder in ["solver/model/lower", "session", "solver/system"] {
        let files = crate::common::files_below(&root.join(folder), "rs");
        // The selection of the solver and the `check` command do not count: an argument that only they name has no effect on a solution.
        let aside = ["backend", "check"].map(|room| root.join("session").join(room));
        for file in files
            .into_iter()
            .filter(|file| !aside.iter().any(|room| file.starts_with(room)))
        {
            read += &std::fs::read_to_string(file).unwrap();
        }
    }
    for file in ["solver/model/constraint.rs", "syntax/overlay.rs"] {
        read += &std::fs::read_to_string(root.join(file)).unwrap();
    }
    for def in STATEMENTS {
        if def.role == Role::Command || !matches!(def.solved, Solved::Native(_)) {
            continue;
        }
        let left_out: Vec<&str> = def
            .left_out
            .iter()
            .flat_map(|left| left.arguments.iter().copied())
            .collect();
        let harmless = WITHOUT_EFFECT.iter().find(|(kind, _)| *kind == def.name);
        let harmless = harmless.map_or(&[][..], |(_, names)| names);
        let of_laws: Vec<&str> = def
            .laws
            .iter()
            .flat_map(|law| law.arguments.iter().copied())
            .collect();
        for argument in def.arguments {
            let name = argument.name;
            let known = [
                &["LIST", "DEFAULT", "ROUTINE"][..],
                harmless,
                &left_out,
                &of_laws,
            ];
            assert!(
                known.iter().any(|names| names.contains(&name))
                    || read.contains(&format!("\"{name}\"")),
                "{name} of {} is read nowhere",
                def.name
            );
        }
    }
}
