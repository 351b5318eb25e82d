//! USER forces that only read a property file, replaced by its curves. The deck is then solved and compared with closed forms.

use admire_solver::model::{Model, replace_user_forces};
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::System;
use admire_syntax::files::Files;
use admire_syntax::text::{Source, apply_edits};
use admire_syntax::{Address, Dataset};

const UNITS: &str =
    "[UNITS]\nLENGTH='mm'\nFORCE='newton'\nANGLE='degrees'\nMASS='kg'\nTIME='second'\n";

/// Returns a bushing file: 100, 200, 400 N/mm, 50 N.m per 5 degrees about z, all linear, and damping of 0.5.
fn bushing() -> String {
    let mut out = format!("[MDI_HEADER]\nFILE_TYPE='bus'\nFILE_VERSION=4.0\n{UNITS}");
    out += "[DAMPING]\nFX_DAMPING=0.5\nFY_DAMPING=0.5\nFZ_DAMPING=0.5\nTX_DAMPING=0\nTY_DAMPING=0\nTZ_DAMPING=0\n";
    for (block, slope) in [
        ("FX_CURVE", 100.0),
        ("FY_CURVE", 200.0),
        ("FZ_CURVE", 400.0),
        ("TX_CURVE", 1e4),
        ("TY_CURVE", 1e4),
        ("TZ_CURVE", 1e4),
    ] {
        out += &format!("[{block}]\n{{x y}}\n");
        for x in [-5.0, -2.0, 0.0, 1.0, 5.0] {
            out += &format!("{x} {}\n", slope * x);
        }
    }
    out
}

fn stiffening(kind: &str, extra: &str) -> String {
    let mut out = format!(
        "[MDI_HEADER]\nFILE_TYPE='{kind}'\nFILE_VERSION=4.0\n{UNITS}{extra}[CURVE]\n{{disp force}}\n"
    );
    for x in [-50.0, 0.0, 50.0, 100.0] {
        out += &format!("{x} {}\n", 20.0 * x);
    }
    out
}

const DECK: &str = "user forces\r\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\r\nPART/1, GROUND\r\nMARKER/1, PART=1\r\n\
    PART/2, MASS=1, CM=20, IP=100,100,100\r\nMARKER/20, PART=2\r\nMARKER/9, PART=1, FLOATING\r\n\
    ! the bushing of the arm\r\n\
    GFORCE/1\r\n, I = 20\r\n, JFLOAT = 9\r\n, RM = 1\r\n, FUNCTION = USER(900, 31, 0, 0)\\\r\n, ROUTINE = abgVDM::bushing\r\n\
    STRING/31, STRING = mdids://acar_shared/bushings.tbl/arm.bus\r\nSTRING/32, STRING = coil.spr\r\nSTRING/33, STRING = stop.bum\r\n\
    STRING/34, STRING = stop.reb\r\nSPLINE/40, X=0,1,2,3, Y=0,1,2,3\r\n";

fn files() -> Files {
    let mut files = Files::default();
    let spring = "[SPRING_DATA]\nFREE_LENGTH = 120\n";
    for (name, text) in [
        ("mdids://acar_shared/bushings.tbl/arm.bus", bushing()),
        ("coil.spr", stiffening("spr", spring)),
        ("stop.bum", stiffening("bum", "")),
        ("stop.reb", stiffening("bum", "")),
    ] {
        files.add(name, Source::new(name, text.into_bytes()));
    }
    files
}

/// Returns the deck with these statements after the replacement, and the messages.
fn replaced(more: &str, lengths: &[(Address, f64)]) -> (String, Vec<String>) {
    replaced_in(&format!("{DECK}{more}END\r\n"), lengths, &[])
}

fn replaced_in(text: &str, lengths: &[(Address, f64)], plain: &[Address]) -> (String, Vec<String>) {
    let dataset = Dataset::parse(Source::new("user.adm", text.as_bytes().to_vec())).value;
    let out = replace_user_forces(&dataset, &files(), lengths, plain);
    let bytes = apply_edits(dataset.source().bytes(), &out.edits).unwrap();
    let told = out.diagnostics.iter().map(|d| d.message.clone()).collect();
    (String::from_utf8(bytes).unwrap(), told)
}

/// Returns the pose of the part at equilibrium.
fn place(text: &str) -> admire_solver::mechanics::Pose {
    let model: Model = crate::deck::read(text);
    let system = System::compile(&model);
    assert!(!system.has_errors(), "{:?}", system.diagnostics);
    let system = system.value;
    let mut state = system.state();
    Solver::new(&system)
        .solve(
            &system,
            &system.parameters(),
            &mut state,
            &StaticSettings::tight(),
        )
        .unwrap();
    state.poses[1]
}

const PULL: &str =
    "MARKER/8, PART=1, FLOATING\r\nGFORCE/2, I=20, JFLOAT=8, RM=1, FX=50\\, FZ=-100\\, TZ=2E4\r\n";

#[test]
fn a_bushing_file_becomes_splines() {
    let (text, told) = replaced(PULL, &[]);
    assert!(told.is_empty(), "{told:?}");
    assert!(text.contains("! the bushing of the arm\r\nGFORCE/1\r\n, I = 20\r\n"));
    assert!(text.contains(", FX = -AKISPL(DX(20,1,1), 0, 41)-0.5*VX(20,1,1,1)\\\r\n"));
    assert!(!text.contains("USER") && !text.contains("ROUTINE"));
    let pose = place(&text);
    assert!((pose.p.x - 0.5).abs() < 1e-9 && (pose.p.z + 0.25).abs() < 1e-9);
    // A torque of 2e4 N.mm at 1e4 N.mm per degree.
    let turn = admire_solver::mechanics::log(&pose.R).z.to_degrees();
    assert!((turn - 2.0).abs() < 1e-9, "{turn}");
}

const GUIDE: &str = "MARKER/21, PART=2\r\nMARKER/3, PART=1, QP=0,0,0\r\nJOINT/1, TRANSLATIONAL, I=21, J=3\r\nMARKER/4, PART=1, QP=0,0,-100\r\n\
    MARKER/7, PART=1, REULER=0D,180D,0D\r\nSFORCE/9, I=20, J=7, TRANSLATIONAL, ACTIONONLY, FUNCTION=600\r\n";

/// Returns a deck without the bushing: the guide, the downward load of 600 N, and one more force.
fn guided(force: &str, lengths: &[(Address, f64)]) -> (String, Vec<String>) {
    let (text, told) = replaced(&format!("{GUIDE}{force}\r\n"), lengths);
    let begin = text.find("! the bushing of the arm").unwrap();
    let end = text.find("STRING/31").unwrap();
    (format!("{}{}", &text[..begin], &text[end..]), told)
}

fn force(id: u32) -> Address {
    crate::reference::address("SFORCE", id)
}

#[test]
fn a_spring_file_acts_from_its_free_length() {
    let spring =
        "SFORCE/5, I=20, J=4, TRANSLATIONAL, FUNCTION=USER(32,0)\\, ROUTINE=abgVDM::spring";
    let (text, told) = guided(spring, &[]);
    assert!(told.is_empty(), "{told:?}");
    assert!(
        text.contains(", FUNCTION = AKISPL(120-DM(20,4), 0, "),
        "{text}"
    );
    // 20 (120 - r) = 600 gives r = 90, so the part is at -10.
    assert!((place(&text).p.z + 10.0).abs() < 1e-8);
    // The installed length of the deck overrides that of the file.
    let (text, _) = guided(spring, &[(force(5), 110.0)]);
    assert!((place(&text).p.z + 20.0).abs() < 1e-8);
}

#[test]
fn a_stop_acts_only_beyond_its_clearance() {
    let stop = "SFORCE/6, I=20, J=4, TRANSLATIONAL, FUNCTION=USER(33)";
    let (text, told) = guided(stop, &[]);
    assert!(text.contains("USER(33)"));
    assert_eq!(
        told,
        [
            "SFORCE/6 keeps its subroutine: `stop.bum` does not state the length at which the force begins"
        ]
    );
    let (text, told) = guided(stop, &[(force(6), 85.0)]);
    assert!(told.is_empty(), "{told:?}");
    // The stop is free until r = 85; then 20 (85 - r) = 600 gives r = 55.
    assert!(
        text.contains("IF(85-DM(20,4): 0, 0, AKISPL(85-DM(20,4), 0, "),
        "{text}"
    );
    let from_below = text.replace("PART/2, MASS", "PART/2, QG=0,0,-40, MASS");
    assert!((place(&from_below).p.z + 45.0).abs() < 1e-8);
    // A rebound stop pulls. It hangs from above, with its other end 100 higher and the load downwards.
    let rebound =
        "MARKER/5, PART=1, QP=0,0,100\r\nSFORCE/7, I=20, J=5, TRANSLATIONAL, FUNCTION=USER(34)";
    let (text, _) = guided(rebound, &[(force(7), 95.0)]);
    // 20 (r - 95) = 600 gives r = 125.
    assert!((place(&text).p.z + 25.0).abs() < 1e-8);
}

/// Checks that the subroutine stays if the file has a further block, such as damping, because its contribution to the force is unknown.
#[test]
fn a_stop_with_a_block_of_its_own_keeps_its_subroutine() {
    let mut damped = files();
    let text = stiffening("bum", "[DAMPING]\nRATE = 2\n").into_bytes();
    damped.add("stop.bum", Source::new("stop.bum", text));
    let deck = format!("{DECK}SFORCE/6, I=20, J=1, TRANSLATIONAL, FUNCTION=USER(33)\r\nEND\r\n");
    let dataset = Dataset::parse(Source::new("user.adm", deck.into_bytes())).value;
    let done = replace_user_forces(&dataset, &damped, &[(force(6), 85.0)], &[]);
    let told = |text: &str| done.diagnostics.iter().any(|d| d.message == text);
    assert!(
        told(
            "SFORCE/6 keeps its subroutine: `stop.bum` has a block [DAMPING], whose effect on the force is unknown"
        ),
        "{:?}",
        done.diagnostics
    );
}

/// Checks that the force stays if the list has further parameters, whose meaning is unknown, until the user states that they have no effect.
#[test]
fn other_parameters_keep_the_subroutine() {
    let deck = DECK.replace("USER(900, 31, 0, 0)", "USER(900, 31, 7, 0, 1.5)");
    let text = format!("{deck}{PULL}END\r\n");
    let (same, told) = replaced_in(&text, &[], &[]);
    assert_eq!(same, text);
    let name = "mdids://acar_shared/bushings.tbl/arm.bus";
    assert_eq!(
        told,
        [format!(
            "GFORCE/1 keeps its subroutine: its parameters contain 7, 1.5 besides the id of `{name}`; these may include a preload, an offset or a scale"
        )]
    );
    let plain = [crate::reference::address("GFORCE", 1)];
    let (text, told) = replaced_in(&text, &[], &plain);
    assert!(told.is_empty(), "{told:?}");
    assert!((place(&text).p.x - 0.5).abs() < 1e-9);
}

#[test]
fn other_subroutines_stay() {
    let (text, told) = replaced(
        "SFORCE/6, I=20, J=1, TRANSLATIONAL, FUNCTION=USER(1,2,3)\r\nSFORCE/7, I=20, J=1, TRANSLATIONAL, FUNCTION=USER(31)\r\n\
         SFORCE/8, I=20, J=1, TRANSLATIONAL, FUNCTION=USER(32,33)\r\n",
        &[],
    );
    assert!(
        text.contains("USER(1,2,3)") && text.contains("USER(31)") && text.contains("USER(32,33)")
    );
    assert_eq!(
        told,
        [
            "SFORCE/6 keeps its subroutine: none of its parameters refers to a property file that was read",
            "SFORCE/7 keeps its subroutine: `mdids://acar_shared/bushings.tbl/arm.bus` does not describe a SFORCE",
            "SFORCE/8 keeps its subroutine: it reads two property files, `coil.spr` and `stop.bum`",
        ]
    );
}
