//! Equations, states and lists of a dataset at rest, and what is held or left out, against closed forms.

use admire_solver::model::{Ignore, Model};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::Code;
use admire_syntax::text::Source;

use crate::deck::{HEAD, Solved, solve};

/// The value of a function in the equilibrium of a deck.
fn value(deck: &str, function: &str) -> f64 {
    shown(deck, function).shown(0)
}

fn shown(deck: &str, function: &str) -> Solved {
    solve(&format!("{deck}\nREQUEST/1, F2={function}"))
}

fn close(value: f64, expected: f64) {
    assert!(
        (value - expected).abs() < 1e-9 * expected.abs().max(1.0),
        "{value} instead of {expected}"
    );
}

/// v = cos v has one solution (Dottie's number).
#[test]
fn an_implicit_variable() {
    let v = value("VARIABLE/1, IC=1, FUNCTION=COS(VARVAL(1))", "VARVAL(1)");
    close(v, 0.739_085_133_215_160_6);
}

/// Two variables that read each other: a + b = 10, a - b = 4.
#[test]
fn variables_that_read_each_other() {
    let deck = "VARIABLE/1, FUNCTION=10-VARVAL(2)\nVARIABLE/2, FUNCTION=VARVAL(1)-4";
    close(value(deck, "VARVAL(1)"), 7.0);
    close(value(deck, "VARVAL(2)"), 3.0);
}

/// A state comes to rest where its derivative is zero; an implicit one where its function is, with the derivative zero.
#[test]
fn differential_equations_at_rest() {
    close(value("DIFF/1, IC=9, FUNCTION=3-2*DIF(1)", "DIF(1)"), 1.5);
    let implicit = "DIFF/1, IC=1, IMPLICIT, FUNCTION=DIF1(1)+2*DIF(1)-8";
    close(value(implicit, "DIF(1)"), 4.0);
    close(value(implicit, "DIF1(1)"), 0.0);
}

/// With STATIC_HOLD the state keeps its IC, and its derivative is whatever the function gives.
#[test]
fn held_states() {
    let deck = "DIFF/1, IC=9, STATIC_HOLD, FUNCTION=3-2*DIF(1)";
    close(value(deck, "DIF(1)"), 9.0);
    close(value(deck, "DIF1(1)"), -15.0);
}

const LSE: &str = "VARIABLE/1, FUNCTION=3\n\
    ARRAY/1, X, SIZE=2\nARRAY/2, U, SIZE=1, VARIABLES=1\nARRAY/3, Y, SIZE=1\nARRAY/4, IC, SIZE=2, NUMBERS=0.5,-0.25\n\
    MATRIX/1, FULL=RORDER, ROWS=2, COLUMNS=2, VALUES=-2,1,0,-4\n\
    MATRIX/2, FULL=RORDER, ROWS=2, COLUMNS=1, VALUES=1,2\n\
    MATRIX/3, FULL=RORDER, ROWS=1, COLUMNS=2, VALUES=1,1\n\
    MATRIX/4, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=5\n";

/// x = -A^-1 B u, y = C x + D u: with u = 3, x2 = 2 u / 4, x1 = (x2 + u) / 2.
#[test]
fn linear_states_at_rest() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, C=3, D=4");
    close(value(&deck, "ARYVAL(1,2)"), 1.5);
    close(value(&deck, "ARYVAL(1,1)"), 2.25);
    close(value(&deck, "ARYVAL(3,1)"), 3.75 + 15.0);
}

/// STATIC_HOLD keeps the states at the IC array.
#[test]
fn held_linear_states() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, C=3, D=4, STATIC_HOLD");
    close(value(&deck, "ARYVAL(1,1)"), 0.5);
    close(value(&deck, "ARYVAL(1,2)"), -0.25);
    close(value(&deck, "ARYVAL(3,1)"), 0.25 + 15.0);
}

/// A transfer function at rest is its gain: (3 + 2 s) / (5 + 4 s + s^2) of u = 2.
#[test]
fn a_transfer_function_at_rest() {
    let deck = "VARIABLE/1, FUNCTION=2\n\
        ARRAY/1, X, SIZE=2\nARRAY/2, U, SIZE=1, VARIABLES=1\nARRAY/3, Y, SIZE=1\n\
        TFSISO/1, X=1, U=2, Y=3, NUMERATOR=3,2, DENOMINATOR=5,4,1";
    close(value(deck, "ARYVAL(3,1)"), 1.2);
}

/// PINVAL and POUVAL are the variables of the lists.
#[test]
fn inputs_and_outputs_of_a_plant() {
    let deck = "VARIABLE/11, FUNCTION=4\nVARIABLE/12, FUNCTION=VARVAL(11)+3\n\
                PINPUT/1, VARIABLES=12,11\nPOUTPUT/1, VARIABLES=11";
    close(value(deck, "PINVAL(1,1)"), 7.0);
    close(value(deck, "PINVAL(1,2)"), 4.0);
    close(value(deck, "POUVAL(1,1)"), 4.0);
}

/// A sensor that has not fired gives zero.
#[test]
fn a_sensor_at_rest() {
    let deck = "SENSOR/1, GE, VALUE=5, ERROR=0.1, FUNCTION=TIME\\, EVALUATE=8";
    close(value(deck, "SENVAL(1)"), 0.0);
}

/// A part on a rail, held by a MOTION, with mass so that nothing is singular.
const RAIL: &str = "PART/2, MASS=1, CM=20, IP=100,100,100, QG=0,0,30\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
                    JOINT/1, TRANSLATIONAL, I=21, J=1\n";

/// A prescribed speed has no static meaning: the part stays where it is, or at ICDISP, and that is said.
#[test]
fn a_prescribed_speed_is_held() {
    let solved = shown(
        &format!("{RAIL}MOTION/1, JOINT=1, VELOCITY, FUNCTION=100"),
        "DZ(21,1)",
    );
    close(solved.shown(0), 30.0);
    assert!(
        solved
            .told
            .iter()
            .any(|t| t
                == "MOTION/1 prescribes a rate, which has no static meaning: it is held at 30"),
        "{:?}",
        solved.told
    );
    let held = format!("{RAIL}MOTION/1, JOINT=1, VELOCITY, ICDISP=45, FUNCTION=100");
    close(value(&held, "DZ(21,1)"), 45.0);
    let held = format!("{RAIL}MOTION/1, JOINT=1, ACCELERATION, ICDISP=-5, FUNCTION=100");
    close(value(&held, "DZ(21,1)"), -5.0);
}

/// Without j the C++ solver sums all that acts at a marker (`cfunc_fx`): on a body that is held at one marker only, its weight. The
/// direction marker of an action-only force feels nothing.
#[test]
fn forces_at_one_marker() {
    let head = "PART/2, MASS=2, CM=20, IP=10,10,10\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
                MARKER/11, PART=1\nMARKER/12, PART=1\nACCGRAV/KGRAV=-9806.65\n\
                SFORCE/1, I=21, J=1, TRANSLATIONAL, ACTIONONLY, FUNCTION=30\n\
                BUSHING/2, I=12, J=21, K=500,500,500, KT=1E5,1E5,1E5\n";
    let bushing = "BUSHING/1, I=21, J=11, K=1000,1000,1000, KT=1E5,1E5,1E5";
    // The same as a linear force of one pair of markers.
    let diagonal = [1e3, 1e3, 1e3, 1e5, 1e5, 1e5];
    let full: Vec<String> = (0..36)
        .map(|k| if k % 7 == 0 { diagonal[k / 7] } else { 0.0 }.to_string())
        .collect();
    let multi = format!(
        "MATRIX/1, FULL=CORDER, ROWS=6, COLUMNS=6, VALUES={}\n\
         MATRIX/2, FULL=CORDER, ROWS=6, COLUMNS=1, VALUES=0,0,0,0,0,0\n\
         NFORCE/1, I=21, J=11, KMATRIX=1, LENGTH=2, FORCE=2",
        full.join("\n,")
    );
    let (weight, z) = (2.0 * 9.80665, (30.0 - 2.0 * 9.80665) / 1500.0);
    for held in [bushing.to_string(), multi] {
        let deck = format!("{head}{held}");
        close(value(&deck, "FZ(21)"), weight);
        close(value(&deck, "FZ(21,0,11)"), weight);
        close(value(&deck, "FM(21)"), weight);
        close(value(&deck, "FZ(21,11)"), -1000.0 * z);
        close(value(&deck, "FZ(11,21)"), 1000.0 * z);
        close(value(&deck, "FZ(21,12)"), -500.0 * z);
        close(value(&deck, "FZ(12)"), 500.0 * z);
        close(value(&deck, "FZ(11)"), 1000.0 * z);
        close(value(&deck, "FZ(21,1)"), 30.0);
        close(value(&deck, "FZ(1)"), 0.0);
    }
}

/// Friction exerts nothing in statics, which is told, unless the deck or the user says that it does not count.
#[test]
fn friction_at_rest_is_told() {
    let spring = "SPRINGDAMPER/1, I=21, J=1, TRANSLATIONAL, K=10, LENGTH=25\n";
    let deck = format!("{RAIL}{spring}FRICTION/1, JOINT=1, MU_STATIC=0.5, MU_DYNAMIC=0.4");
    let text = format!("{HEAD}{deck}\nEND\n");
    let dataset = Dataset::parse(Source::new("stick.adm", text.into_bytes())).value;
    let mut model = Model::lower(&dataset).value;
    let compiled = System::compile(&model);
    assert!(!compiled.has_errors());
    let told = &compiled.diagnostics[0].message;
    assert!(
        told.starts_with("FRICTION/1 exerts nothing in statics"),
        "{told}"
    );
    close(shown(&deck, "DZ(21,1)").shown(0), 25.0);
    assert!(
        model
            .leave_out(&Ignore::parse("CONTACT, FRICTION/2").unwrap())
            .is_empty()
    );
    assert_eq!(
        model.leave_out(&Ignore::parse("FRICTION/1").unwrap()).len(),
        1
    );
    assert!(System::compile(&model).diagnostics.is_empty());
    for off in [
        "INACTIVE=STATIC",
        "INACTIVE_DURING=STATIC",
        "EFFECT=SLIDING",
    ] {
        let solved = shown(&format!("{deck}, {off}"), "DZ(21,1)");
        close(solved.shown(0), 25.0);
        assert!(solved.told.is_empty(), "{:?}", solved.told);
    }
    let unknown = Ignore::parse("CONTACT, BUSHING").unwrap_err();
    assert!(
        unknown.contains("`BUSHING`") && unknown.contains("UCON"),
        "{unknown}"
    );
}

/// An initial displacement of a joint is a start, not a condition; that it is not applied is said.
#[test]
fn initial_displacements_of_joints_are_told() {
    let spring = "SPRINGDAMPER/1, I=21, J=1, TRANSLATIONAL, K=10, LENGTH=25\n";
    let deck = format!(
        "{}{spring}",
        RAIL.replace("TRANSLATIONAL, I", "TRANSLATIONAL, IC=12, I")
    );
    let solved = shown(&deck, "DZ(21,1)");
    close(solved.shown(0), 25.0);
    assert!(
        solved.told[0].starts_with("the initial displacement of JOINT/1 is not applied in statics"),
        "{:?}",
        solved.told
    );
}

/// A force that reads itself has no value to begin with: refused with the way out, and with that way taken it is solved.
#[test]
fn a_force_that_reads_itself() {
    use admire_solver::model::Model;
    use admire_solver::system::System;
    use admire_syntax::Dataset;
    use admire_syntax::text::Source;
    let spring =
        "SPRINGDAMPER/1, I=21, J=1, TRANSLATIONAL, K=10, LENGTH=25\nMARKER/9, PART=1, FLOATING\n";
    let force =
        |read: &str| format!("{RAIL}{spring}GFORCE/1, I=21, JFLOAT=9, RM=1, FZ=20+0.5*{read}\n");
    let text = format!("{}{}END\n", crate::deck::HEAD, force("GFORCE(1,0,4,0)"));
    let dataset = Dataset::parse(Source::new("circle.adm", text.into_bytes()));
    let compiled = System::compile(&Model::lower(&dataset.value).value);
    let said = compiled.diagnostics.last().unwrap();
    assert!(compiled.has_errors());
    assert_eq!(said.message, "the function of GFORCE/1 reads its own force");
    assert_eq!(
        said.help.as_deref(),
        Some("let a VARIABLE carry the force: it is solved for")
    );
    // F = 20 + F / 2: 40 N on a spring of 10 N/mm that is 25 long.
    let carried = format!("{}VARIABLE/1, FUNCTION=GFORCE(1,0,4,0)", force("VARVAL(1)"));
    close(value(&carried, "DZ(21,1)"), 29.0);
}

/// How many statements need user subroutines and which, in one line; none of them is taken for zero.
#[test]
fn user_subroutines_are_refused_by_name() {
    use admire_solver::model::Model;
    use admire_solver::system::System;
    use admire_syntax::Dataset;
    use admire_syntax::text::Source;
    let text = format!(
        "{}{RAIL}SFORCE/1, I=21, J=1, ROTATIONAL, FUNCTION=USER(1,2)\n\
         VARIABLE/7, FUNCTION=USER(3)\nCOUPLER/1, JOINTS=1,1, FUNCTION=USER(4)\nEND\n",
        crate::deck::HEAD
    );
    let dataset = Dataset::parse(Source::new("user.adm", text.into_bytes()));
    let model = Model::lower(&dataset.value).value;
    let compiled = System::compile(&model);
    let said: Vec<&str> = compiled
        .diagnostics
        .iter()
        .map(|d| d.message.as_str())
        .collect();
    assert!(
        said.contains(
            &"3 statements need user-written subroutines: SFORCE/1, VARIABLE/7, COUPLER/1"
        ),
        "{said:?}"
    );
    assert!(compiled.has_errors());
    let help = compiled.diagnostics.last().unwrap().help.as_deref();
    assert_eq!(
        help,
        Some("the command backend runs them with real ADAMS and the library")
    );
}

/// Sizes that do not fit are told at lowering, each at its place: nothing is solved, and nothing panics.
#[test]
fn matrices_and_arrays_of_other_sizes_are_told() {
    let lse = "LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, C=3, D=4";
    let messages = |deck: &str| -> Vec<String> {
        let text = format!("{HEAD}{deck}\nEND\n");
        let dataset = Dataset::parse(Source::new("sizes.adm", text.into_bytes())).value;
        let lowered = Model::lower(&dataset);
        for diagnostic in &lowered.diagnostics {
            let is_missing = diagnostic.message.contains(" needs U");
            let code = if is_missing {
                Code::MissingArgument
            } else {
                Code::WrongCount
            };
            assert_eq!(diagnostic.code, code, "{diagnostic:?}");
            assert!(!diagnostic.labels.is_empty());
        }
        if !lowered.has_errors() {
            assert!(!System::compile(&lowered.value).has_errors());
        }
        lowered.diagnostics.into_iter().map(|d| d.message).collect()
    };
    let good = format!("{LSE}{lse}");
    assert_eq!(messages(&good), [""; 0]);
    for (part, other, told) in [
        (
            "A=1",
            "A=3",
            "A has 1 rows and 2 columns; it must be square",
        ),
        (
            "X, SIZE=2",
            "X, SIZE=3",
            "the array of X has 3 elements, and there are 2 states of A",
        ),
        (
            "NUMBERS=0.5,-0.25",
            "NUMBERS=0.5",
            "the array of IC has 1 elements",
        ),
        ("B=2", "B=3", "B has 1 rows, and there are 2 states"),
        (
            "B=2",
            "B=1",
            "B has 2 columns, and there are 1 elements in U",
        ),
        ("C=3", "C=4", "C has 1 columns, and there are 2 states"),
        ("D=4", "D=2", "D has 2 rows, and there are 1 elements in Y"),
        ("U=2, ", "", "B of LSE/1 needs U"),
        (
            "U, SIZE=1, VARIABLES=1",
            "U",
            "B needs the size of U, the array of inputs",
        ),
        (
            "VALUES=-2,1,0,-4",
            "VALUES=-2,1,0",
            "2 rows and 2 columns need 4 values, not 3",
        ),
        ("X, SIZE=2", "X", ""),
    ] {
        let found = messages(&good.replacen(part, other, 1));
        assert_eq!(found.is_empty(), told.is_empty(), "{other}: {found:?}");
        assert!(
            told.is_empty() || found.iter().any(|m| m.contains(told)),
            "{other}: {found:?}"
        );
    }
    let sparse = good.replace(
        "FULL=RORDER, ROWS=2, COLUMNS=2, VALUES=-2,1,0,-4",
        "SPARSE, ROWS=2, COLUMNS=2, I=1,3, J=1,2, VALUES=-2,-4",
    );
    assert_eq!(messages(&sparse), ["MATRIX/1: I names 3, and there are 2"]);
    let transfer = "VARIABLE/1, FUNCTION=3\nVARIABLE/2, FUNCTION=3\nARRAY/1, X, SIZE=2\nARRAY/2, U, VARIABLES=1,2\n\
        ARRAY/3, Y, SIZE=1\nTFSISO/1, X=1, U=2, Y=3, NUMERATOR=1, DENOMINATOR=1,2";
    assert_eq!(
        messages(transfer),
        [
            "TFSISO/1: the array of X has 2 elements, and there is 1 state of the denominator",
            "TFSISO/1: the array of U has 2 elements, and there is 1 signal of a transfer function"
        ]
    );
}

/// Outputs need no matrix C: y = D u.
#[test]
fn outputs_by_the_inputs_alone() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, D=4");
    close(value(&deck, "ARYVAL(3,1)"), 15.0);
}
