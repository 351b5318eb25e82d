//! All kinds of objects that have results, and the options that select what is written.

use admire_results::XrfReader;

use crate::car_deck;
use crate::run::{Ran, Results, SLIDER, folder, mdi, run_deck, text};

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-6, "{found:?} {expected:?}");
    }
}

fn run(deck: &str, commands: &str) -> (tempfile::TempDir, Ran) {
    let acf = format!("\nfile/model=slider\n{commands}\n");
    let folder = folder(&[("slider.adm", deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    (folder, ran)
}

/// The slider with one object of every other kind that has results; only the NFORCE (K = 10 along z) affects its motion.
fn of_every_kind() -> String {
    let more = "\
MARKER/30, PART=2
MARKER/31, PART=1
MARKER/32, PART=1, FLOATING
MARKER/33, PART=1, FLOATING
MARKER/34, PART=1, FLOATING
POINT_MASS/3, MASS=1, CM=40, QG=5, 0, 0
MARKER/40, POINT_MASS=3
PART/4, MASS=1, CM=50, IP=1, 1, 1, QG=0, 50, 0
MARKER/50, PART=4
MARKER/51, PART=1, QP=0, 50, 0
PART/5, MASS=1, CM=60, IP=1, 1, 1, QG=0, 90, 0
MARKER/60, PART=5
MARKER/61, PART=1, QP=0, 90, 0
JPRIM/1, ATPOINT, I=40, J=1002
MARKER/1002, PART=1, QP=5, 0, 0
JOINT/4, TRANSLATIONAL, I=50, J=51
JOINT/5, TRANSLATIONAL, I=60, J=61
MOTION/5, JOINT=5, FUNCTION=7
COUPLER/1, JOINTS=4, 5, TYPE=T:T, SCALES=1, 1
BUSHING/1, I=30, J=31, KT=1, 1, 1
FIELD/1, I=30, J=31, LENGTH=0,0,0,0,0,0
, KMATRIX=0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0
BEAM/1, I=60, J=61, LENGTH=1, AREA=1, IXX=1, IYY=1, IZZ=1, EMODULUS=1E-9, GMODULUS=1E-9
SPRINGDAMPER/2, ROTATIONAL, I=20, J=1, KT=3
VFORCE/1, I=30, JFLOAT=32, FX=0\\FY=0\\FZ=2
VTORQUE/1, I=30, JFLOAT=33, TX=0\\TY=0\\TZ=0
GFORCE/1, I=30, JFLOAT=34, FZ=-2
MATRIX/1, FULL=RORDER, ROWS=6, COLUMNS=6, VALUES=
, 0,0,0,0,0,0, 0,0,0,0,0,0, 0,0,10,0,0,0, 0,0,0,0,0,0, 0,0,0,0,0,0, 0,0,0,0,0,0
NFORCE/1, I=30, J=31, KMATRIX=1
VARIABLE/1, FUNCTION=3+TIME
VARIABLE/2, FUNCTION=DZ(20,1)
PINPUT/1, VARIABLES=1
POUTPUT/1, VARIABLES=2, 1
DIFF/1, IC=1, FUNCTION=DIF(1)-4
ARRAY/1, X, SIZE=1
ARRAY/2, U, SIZE=1, VARIABLES=1
ARRAY/3, Y, SIZE=1
MATRIX/2, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=-2
MATRIX/3, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=1
MATRIX/4, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=10
LSE/1, X=1, U=2, Y=3, A=2, B=3, C=4
ARRAY/11, X, SIZE=1
ARRAY/12, U, SIZE=1, VARIABLES=1
ARRAY/13, Y, SIZE=1
TFSISO/1, X=11, U=12, Y=13, NUMERATOR=6, DENOMINATOR=2, 1
PART/6, MASS=1, CM=70, IP=1, 1, 1, QG=0, 0, 30
MARKER/70, PART=6
MARKER/71, PART=1, QP=0, 0, 30
JOINT/6, TRANSLATIONAL, I=70, J=71
GCON/1, I=70, FUNCTION=DZ(70,71)-2*DZ(20,1)
SFORCE/6, TRANSLATIONAL, ACTIONONLY, I=70, J=71, FUNCTION=0
FRICTION/1, JOINT=1, MU_STATIC=0.1, MU_DYNAMIC=0.1, STICTION_TRANSITION_VELOCITY=0.1, REACTION_ARM=1, INACTIVE=STATIC
REQUEST/1";
    SLIDER.replacen("REQUEST/1", more, 1)
}

#[test]
fn every_kind_of_object_has_its_entity() {
    let (folder, ran) = run(
        &of_every_kind(),
        "SFORCE/1, FUNCTION=40\nSFORCE/6, FUNCTION=5\nSIM/STAT\nSTOP",
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let reader = XrfReader::open(
        "r",
        std::fs::File::open(folder.path().join("slider.res")).unwrap(),
    )
    .unwrap();
    let mut kinds: Vec<String> = Vec::new();
    for entity in &reader.catalogue().entities {
        let kind = entity.ent_type.clone().unwrap_or_default();
        if kinds.last() != Some(&kind) {
            kinds.push(kind);
        }
    }
    // The order of guide/formats.md 12 and of the maps in 6.2; all objects of a kind are adjacent.
    assert_eq!(
        kinds,
        [
            "",
            "Part",
            "Point_Mass",
            "Differential_Equation",
            "Joint",
            "Primitive_Joint",
            "Motion",
            "Coupler",
            "General_Constraint",
            "Single_Component_Force",
            "Translational_Spring_Damper",
            "Rotational_Spring_Damper",
            "Bushing",
            "Beam",
            "Field",
            "Request",
            "ADAMS_Variable",
            "Plant_Input",
            "Plant_Output",
            "Transfer_Function",
            "Linear_State_Equation",
            "Multi_Point_Force",
            "Force_Vector",
            "Torque_Vector",
            "General_Force",
            "Friction",
            "Floating_Marker",
        ]
    );
    let results = Results::read(folder.path(), "slider.res");
    let column = |entity: &str, component: &str| results.column(entity, component)[0];
    // Spring and NFORCE have 10 N/mm each. The GCON moves part 6 twice as far, so that its 5 N act as 10 N on the slider: z = (40 + 10) /
    // 20.
    near(
        &[column("block_XFORM", "Z"), column("PART_6_XFORM", "Z")],
        &[2.5, 35.0],
    );
    near(
        &[column("NFORCE_1", "FZ"), column("NFORCE_1", "TX")],
        &[-25.0, 0.0],
    );
    // The GCON holds part 6 against its load of 5 newton along z.
    near(
        &["FX", "FY", "FZ", "TX", "TY", "TZ"].map(|c| column("GCON_1", c)),
        &[0.0, 0.0, -5.0, 0.0, 0.0, 0.0],
    );
    near(
        &[
            column("PINPUT_1", "IN1"),
            column("POUTPUT_1", "OUT1"),
            column("POUTPUT_1", "OUT2"),
        ],
        &[3.0, 2.5, 3.0],
    );
    near(
        &[column("DIFF_1", "Q"), column("DIFF_1", "DQ")],
        &[4.0, 0.0],
    );
    // At rest 0 = -2 x + u with u = 3 and y = 10 x; the gain of 6/(2 + s) for a constant 3 is 9.
    near(
        &[column("LSE_1", "X1"), column("LSE_1", "Y1")],
        &[1.5, 15.0],
    );
    near(&[column("TFSISO_1", "Y1")], &[9.0]);
    near(&[column("FRICTION_1", "FX")], &[0.0]);
    // VFORCE and GFORCE cancel; each is reported at I in ground axes.
    near(
        &[column("VFORCE_1", "FZ"), column("GFORCE_1", "FZ")],
        &[2.0, -2.0],
    );
}

#[test]
fn options_of_results_take_kinds_out() {
    let options = [
        ("NODISPLACEMENTS", "name=\"X\" unitsValue"),
        ("NOVELOCITIES", "name=\"VX\""),
        ("NOACCELERATIONS", "name=\"ACCX\""),
        ("NOREACTIONFORCES", "entType=\"Joint\""),
        ("NOAPPLIEDFORCES", "entType=\"Bushing\""),
        ("NOSYSTEMELEMENTS", "entType=\"ADAMS_Variable\""),
        ("NOREQUESTS", "entType=\"Request\""),
        ("NOFLOATINGMARKERS", "entType=\"Floating_Marker\""),
    ];
    for (option, gone) in options {
        // FRICTION is removed because it has its own columns VX to WZ.
        let deck = of_every_kind()
            .replace("XRF", &format!("XRF, {option}"))
            .replace("FRICTION/1", "!");
        let (folder, ran) = run(&deck, "SIM/STAT");
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let res = text(folder.path(), "slider.res");
        for (other, there) in options {
            // Floating markers have their own columns called X.
            if other == "NODISPLACEMENTS" && option != "NOFLOATINGMARKERS" {
                continue;
            }
            assert_eq!(
                res.contains(there),
                other != option && there != gone,
                "{option}: {there}"
            );
        }
        let mut reader = XrfReader::open("r", res.as_bytes()).unwrap();
        let columns = reader.catalogue().len();
        let mut values = Vec::new();
        while let Some(step) = reader.next_step().unwrap() {
            step.values(&mut values).unwrap();
            assert_eq!(values.len(), columns);
        }
    }
    // Without displacements the velocities remain.
    let (folder, _) = run(
        &SLIDER.replace("XRF", "XRF, NODISPLACEMENTS"),
        "SFORCE/1, FUNCTION=5\nSIM/STAT",
    );
    let results = Results::read(folder.path(), "slider.res");
    near(&results.column("block_XFORM", "VX"), &[0.0]);
    assert!(!text(folder.path(), "slider.res").contains("name=\"PSI\""));
    near(&results.column("travel", "dz"), &[0.5]);
}

#[test]
fn decimal_places_and_comment_of_results() {
    let deck = SLIDER.replace("XRF", "XRF, DECIMALPLACES=3, COMMENT=a third of it");
    let (folder, ran) = run(&deck, "SFORCE/1, FUNCTION=10/3\nSIM/STAT");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let res = text(folder.path(), "slider.res");
    assert!(res.contains("a third of it"));
    assert!(res.contains(" 0.333 ") && !res.contains("0.3333"), "{res}");
}

#[test]
fn what_is_asked_for_and_not_written_is_said() {
    let (folder, ran) = run(&SLIDER.replace("FORMATTED, XRF", "FORMATTED"), "SIM/STAT");
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(
        ran.stdout
            .contains("writes a plain text results file; admire writes XML")
            && ran.stdout.contains("[output-not-written]")
    );
    assert_eq!(Results::read(folder.path(), "slider.res").steps.len(), 1);
    let (_folder, ran) = run(
        &SLIDER.replace("RESULTS/FORMATTED, XRF", "RESULTS/"),
        "SIM/STAT",
    );
    assert!(
        ran.stdout
            .contains("writes a binary results file; admire writes XML"),
        "{}",
        ran.stdout
    );
    for (option, said) in [
        ("CHART", "OUTPUT/CHART asks for charts"),
        ("MATSAVE", "a file for MATLAB"),
        ("DSCALE=2", "OUTPUT/DSCALE"),
    ] {
        let (_folder, ran) = run(
            &SLIDER.replace("OUTPUT/REQSAVE", &format!("OUTPUT/REQSAVE, {option}")),
            "SIM/STAT",
        );
        assert_eq!(ran.code, 0);
        assert!(ran.stdout.contains(said), "{option}: {}", ran.stdout);
    }
    let (_folder, ran) = run(
        &SLIDER.replace("RESULTS/FORMATTED, XRF", "RESULTS/XRF, ROUNDOFF"),
        "SIM/STAT",
    );
    assert!(
        ran.stdout.contains("RESULTS/ROUNDOFF is ignored"),
        "{}",
        ran.stdout
    );
    let (_folder, ran) = run(SLIDER, "SIM/STAT");
    assert!(
        !ran.stdout.contains("[output-not-written]"),
        "{}",
        ran.stdout
    );
}

#[test]
fn options_of_output_shape_tables_and_requests() {
    let request = "REQUEST/2, DISPLACEMENT, I=80, J=1\nREQUEST/3, FORCE, I=21, J=11\nMARKER/80, PART=2, REULER=30D,20D,10D\nREQUEST/1";
    let deck = SLIDER.replacen("REQUEST/1", request, 1);
    let commands = "SFORCE/1, FUNCTION=0.05\nSIM/STAT\nSIM/STAT";
    let out = |options: &str| {
        let deck = deck.replace("OUTPUT/REQSAVE", &format!("OUTPUT/REQSAVE{options}"));
        let (folder, ran) = run(&deck, commands);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let results = Results::read(folder.path(), "slider.res");
        (
            text(folder.path(), "slider.out"),
            results,
            text(folder.path(), "slider.req"),
        )
    };
    let (usual, results, _) = out("");
    // PSI, THETA, PHI of the marker equal the given angles.
    let degrees = |results: &Results, names: [&str; 3]| {
        names.map(|n| results.column("REQUEST_2", n)[0].to_degrees())
    };
    near(
        &degrees(&results, ["PSI", "THETA", "PHI"]),
        &[30.0, 20.0, 10.0],
    );
    assert!(usual.lines().any(|line| line.len() > 100) && usual.contains("5.00000E-03"));
    // Each of the two simulations has its own table for each of the three requests.
    assert_eq!(usual.matches("0REQUEST/").count(), 6);
    let (merged, ..) = out(", NOSEPARATOR");
    assert_eq!(merged.matches("0REQUEST/").count(), 3);
    let (narrow, ..) = out(", TELETYPE");
    let tables: Vec<&str> = narrow
        .lines()
        .filter(|line| !line.contains("PAGE"))
        .collect();
    assert!(tables.iter().all(|line| line.len() <= 72), "{narrow}");
    assert!(narrow.contains("THETA"));
    let (fixed, ..) = out(", FIXED");
    assert!(
        fixed.contains("      0.00500") && !fixed.contains("5.00000E-03"),
        "{fixed}"
    );
    let (none, ..) = out(", NOPRINT");
    assert_eq!(none, "");
    // R = Rz(30) Rx(20) Rz(10) as 3-2-1 angles: yaw = atan2(R21, R11), pitch = asin(R31), roll = atan2(R32, R33).
    let (_, results, _) = out(", YPR");
    let [psi, theta, phi] = [30_f64, 20.0, 10.0].map(f64::to_radians);
    let r11 = psi.cos() * phi.cos() - psi.sin() * theta.cos() * phi.sin();
    let r21 = psi.sin() * phi.cos() + psi.cos() * theta.cos() * phi.sin();
    let (r31, r32, r33) = (
        theta.sin() * phi.sin(),
        theta.sin() * phi.cos(),
        theta.cos(),
    );
    let expected = [r21.atan2(r11), r31.asin(), r32.atan2(r33)].map(f64::to_degrees);
    near(&degrees(&results, ["YAW", "PITCH", "ROLL"]), &expected);
    // Displacements below 0.01 become zero; DZERO does not apply to forces.
    let (_, results, req) = out(", DZERO=0.01");
    near(&results.column("REQUEST_2", "Z"), &[0.0, 0.0]);
    near(&results.column("REQUEST_3", "FZ"), &[-0.05, -0.05]);
    assert!(!req.contains("5.00000E-03\n"));
}

/// A bushing of Adams/Car in results and messages: its forces under its own name, and how it was read.
#[test]
fn a_bushing_of_adams_car_is_a_field_in_results() {
    let mut axes = car_deck::PLAIN;
    axes[0] = [1.5, 40.0, 0.0, 1.0];
    let load = [
        1.5 * car_deck::curve(0, 4.0) - 40.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    let deck = [
        "small\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n",
        &car_deck::part(load),
        &car_deck::splines(),
        &car_deck::arrays(&axes),
        &car_deck::field(car_deck::PARAMETERS),
        "EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8\nRESULTS/XRF\nEND\n",
    ]
    .concat();
    // The scale of the curve is changed by a command: the part goes where the load needs it.
    let commands =
        "SIMULATE/STATIC\nARRAY/31, NUMBERS = 2, 0, 3, 1, 0, 1, 40, 0, 1, 0, 1\nSIMULATE/STATIC";
    let (results, ran, messages) = run_deck(&deck, commands);
    assert_eq!(ran.code, 0, "{messages}");
    let column = |entity: &str, component: &str| results.column(entity, component);
    let field = "field";
    near(
        &[column(field, "FX")[0], column(field, "FX")[1]],
        &[-load[0], -load[0]],
    );
    near(&[column("PART_2_XFORM", "X")[0]], &[4.0]);
    assert!(column("PART_2_XFORM", "X")[1] < 3.0);
    let warning = "1 FIELD is read as a bushing of Adams/Car";
    assert!(messages.contains(warning), "{messages}");
}
