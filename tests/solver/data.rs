//! Equations, states and lists of a dataset at rest, compared with closed forms, and statements that statics holds or leaves out.

use admire_solver::model::{Ignore, Model};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::Code;
use admire_syntax::text::Source;

use crate::deck::{HEAD, Solved, solve};

/// Returns the value of a function in the equilibrium of a deck.
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

/// Checks v = cos v, which has one solution (Dottie's number).
#[test]
fn an_implicit_variable() {
    let v = value("VARIABLE/1, IC=1, FUNCTION=COS(VARVAL(1))", "VARVAL(1)");
    close(v, 0.739_085_133_215_160_6);
}

/// Checks two variables that read each other: a + b = 10, a - b = 4.
#[test]
fn variables_that_read_each_other() {
    let deck = "VARIABLE/1, FUNCTION=10-VARVAL(2)\nVARIABLE/2, FUNCTION=VARVAL(1)-4";
    close(value(deck, "VARVAL(1)"), 7.0);
    close(value(deck, "VARVAL(2)"), 3.0);
}

/// Checks that a state comes to rest where its derivative is zero. An implicit state comes to rest where its function is zero with a zero
/// derivative.
#[test]
fn differential_equations_at_rest() {
    close(value("DIFF/1, IC=9, FUNCTION=3-2*DIF(1)", "DIF(1)"), 1.5);
    let implicit = "DIFF/1, IC=1, IMPLICIT, FUNCTION=DIF1(1)+2*DIF(1)-8";
    close(value(implicit, "DIF(1)"), 4.0);
    close(value(implicit, "DIF1(1)"), 0.0);
}

/// Checks that STATIC_HOLD keeps the state at its IC, whatever derivative the function gives.
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

/// Checks x = -A^-1 B u, y = C x + D u: with u = 3, x2 = 2 u / 4 and x1 = (x2 + u) / 2.
#[test]
fn linear_states_at_rest() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, C=3, D=4");
    close(value(&deck, "ARYVAL(1,2)"), 1.5);
    close(value(&deck, "ARYVAL(1,1)"), 2.25);
    close(value(&deck, "ARYVAL(3,1)"), 3.75 + 15.0);
}

/// Checks that STATIC_HOLD keeps the states at the IC array.
#[test]
fn held_linear_states() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, C=3, D=4, STATIC_HOLD");
    close(value(&deck, "ARYVAL(1,1)"), 0.5);
    close(value(&deck, "ARYVAL(1,2)"), -0.25);
    close(value(&deck, "ARYVAL(3,1)"), 0.25 + 15.0);
}

/// Checks that a transfer function at rest equals its gain: (3 + 2 s) / (5 + 4 s + s^2) of u = 2.
#[test]
fn a_transfer_function_at_rest() {
    let deck = "VARIABLE/1, FUNCTION=2\n\
        ARRAY/1, X, SIZE=2\nARRAY/2, U, SIZE=1, VARIABLES=1\nARRAY/3, Y, SIZE=1\n\
        TFSISO/1, X=1, U=2, Y=3, NUMERATOR=3,2, DENOMINATOR=5,4,1";
    close(value(deck, "ARYVAL(3,1)"), 1.2);
}

/// Checks that PINVAL and POUVAL return the variables of the lists.
#[test]
fn inputs_and_outputs_of_a_plant() {
    let deck = "VARIABLE/11, FUNCTION=4\nVARIABLE/12, FUNCTION=VARVAL(11)+3\n\
                PINPUT/1, VARIABLES=12,11\nPOUTPUT/1, VARIABLES=11";
    close(value(deck, "PINVAL(1,1)"), 7.0);
    close(value(deck, "PINVAL(1,2)"), 4.0);
    close(value(deck, "POUVAL(1,1)"), 4.0);
}

/// Checks that a sensor that has not fired returns zero.
#[test]
fn a_sensor_at_rest() {
    let deck = "SENSOR/1, GE, VALUE=5, ERROR=0.1, FUNCTION=TIME\\, EVALUATE=8";
    close(value(deck, "SENVAL(1)"), 0.0);
}

/// A part on a rail, to be held by a MOTION. The part has mass, so that nothing is singular.
const RAIL: &str = "PART/2, MASS=1, CM=20, IP=100,100,100, QG=0,0,30\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
                    JOINT/1, TRANSLATIONAL, I=21, J=1\n";

/// Checks a prescribed speed, which has no meaning in statics: the part stays at its position or at ICDISP, with a message.
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
                == "MOTION/1 prescribes a velocity or acceleration, which has no meaning in statics: its displacement is held at 30 mm"),
        "{:?}",
        solved.told
    );
    let held = format!("{RAIL}MOTION/1, JOINT=1, VELOCITY, ICDISP=45, FUNCTION=100");
    close(value(&held, "DZ(21,1)"), 45.0);
    let held = format!("{RAIL}MOTION/1, JOINT=1, ACCELERATION, ICDISP=-5, FUNCTION=100");
    close(value(&held, "DZ(21,1)"), -5.0);
}

/// Checks that functions without j sum all forces that act at a marker, as in the C++ solver (`cfunc_fx`). On a body held at one marker only,
/// this is its weight. The direction marker of an action-only force carries no force.
#[test]
fn forces_at_one_marker() {
    let head = "PART/2, MASS=2, CM=20, IP=10,10,10\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
                MARKER/11, PART=1\nMARKER/12, PART=1\nACCGRAV/KGRAV=-9806.65\n\
                SFORCE/1, I=21, J=1, TRANSLATIONAL, ACTIONONLY, FUNCTION=30\n\
                BUSHING/2, I=12, J=21, K=500,500,500, KT=1E5,1E5,1E5\n";
    let bushing = "BUSHING/1, I=21, J=11, K=1000,1000,1000, KT=1E5,1E5,1E5";
    // The same element as a linear force between one pair of markers.
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

/// Checks that friction, which exerts no force in statics, is reported unless the deck or the user switches this message off.
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
        told.starts_with("FRICTION/1 exerts no friction in statics"),
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

/// Checks that an initial displacement of a joint is used as a start and not as a condition, with a message that it is not applied.
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

/// Checks a force that reads itself, which has no initial value: it is refused with a remedy, and with this remedy it is solved.
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
        Some("define the force in a VARIABLE, which may depend on itself")
    );
    // F = 20 + F / 2 gives 40 N, on a spring of 10 N/mm with length 25.
    let carried = format!("{}VARIABLE/1, FUNCTION=GFORCE(1,0,4,0)", force("VARVAL(1)"));
    close(value(&carried, "DZ(21,1)"), 29.0);
}

/// Checks that user subroutines are refused with their number and names in one line, and that none of them is replaced by zero.
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
        Some(
            "use the command backend, which runs real ADAMS with the library of these subroutines"
        )
    );
}

/// Checks that wrong sizes are reported when the model is built, each at its position. Nothing is solved, and there is no panic.
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
            "the size of the array X is 3, but there are 2 states of A",
        ),
        (
            "NUMBERS=0.5,-0.25",
            "NUMBERS=0.5",
            "the size of the array IC is 1",
        ),
        (
            "B=2",
            "B=3",
            "the number of rows of B is 1, not 2, the number of states",
        ),
        (
            "B=2",
            "B=1",
            "the number of columns of B is 2, not 1, the number of elements in U",
        ),
        (
            "C=3",
            "C=4",
            "the number of columns of C is 1, not 2, the number of states",
        ),
        (
            "D=4",
            "D=2",
            "the number of rows of D is 2, not 1, the number of elements in Y",
        ),
        ("U=2, ", "", "B of LSE/1 needs U"),
        (
            "U, SIZE=1, VARIABLES=1",
            "U",
            "the size of U, the array of inputs, is unknown; B needs it",
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
    assert_eq!(
        messages(&sparse),
        ["MATRIX/1: I contains 3, but must be between 1 and 2"]
    );
    let transfer = "VARIABLE/1, FUNCTION=3\nVARIABLE/2, FUNCTION=3\nARRAY/1, X, SIZE=2\nARRAY/2, U, VARIABLES=1,2\n\
        ARRAY/3, Y, SIZE=1\nTFSISO/1, X=1, U=2, Y=3, NUMERATOR=1, DENOMINATOR=1,2";
    assert_eq!(
        messages(transfer),
        [
            "TFSISO/1: the size of the array X is 2, but there is 1 state of the denominator",
            "TFSISO/1: the size of the array U is 2, but there is 1 signal of a transfer function"
        ]
    );
}

/// Checks outputs without a matrix C: y = D u.
#[test]
fn outputs_by_the_inputs_alone() {
    let deck = format!("{LSE}LSE/1, X=1, U=2, Y=3, IC=4, A=1, B=2, D=4");
    close(value(&deck, "ARYVAL(3,1)"), 15.0);
}
