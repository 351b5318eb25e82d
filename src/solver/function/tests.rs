//! Tests of every function against closed-form values and central differences.

use super::{
    Curves, EvalError, EvaluationMemory, ExpressionCompiler, Fault, Input, Program, ProgramNumbers,
};
use crate::mechanics::{Mat3, Vec3};
use crate::model::{
    ArrayData, ArrayKind, Bushing, Header, Marker, MarkerIx, Model, Orientation, PartIx, Spline,
    Variable,
};
use admire_syntax::Expression;
use admire_syntax::diagnostic::Code;

mod derivatives;
mod pieces;
mod splines;

fn header(id: u32) -> Header {
    Header {
        id,
        active: true,
        ..Header::default()
    }
}

fn spline(id: u32, x: &[f64], z: &[f64], y: &[&[f64]], linear_extrapolate: bool) -> Spline {
    Spline {
        header: header(id),
        x: x.to_vec(),
        z: z.to_vec(),
        y: y.iter().map(|row| row.to_vec()).collect(),
        linear_extrapolate,
        is_of_file: false,
    }
}

/// Example of Akima's paper (J. ACM 17, 1970, p. 600).
const AKIMA_Y: [f64; 11] = [
    10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.5, 15.0, 50.0, 60.0, 85.0,
];

/// Returns a model with markers 1 to 5, variables 1 to 3, an array, a bushing and splines.
fn model() -> Model {
    let count: Vec<f64> = (0..11).map(f64::from).collect();
    let function =
        crate::model::Function::Expression(Expression::parse_str("0").expect("a number").into());
    Model {
        markers: (1..=5)
            .map(|id| Marker {
                header: header(id),
                part: PartIx(0),
                qp: Vec3::zeros(),
                orientation: Orientation::Reuler([0.0; 3]),
                R: Mat3::identity(),
                floating: false,
                relative: None,
            })
            .collect(),
        variables: (1..=3)
            .map(|id| Variable {
                header: header(id),
                ic: 0.0,
                function: function.clone(),
            })
            .collect(),
        arrays: vec![
            ArrayData {
                header: header(1),
                kind: ArrayKind::Numbers(vec![1.5, -2.5]),
            },
            ArrayData {
                header: header(2),
                kind: ArrayKind::Variables(vec![3, 1]),
            },
        ],
        bushings: vec![Bushing {
            header: header(7),
            i: MarkerIx(0),
            j: MarkerIx(1),
            k: [0.0; 3],
            kt: [0.0; 3],
            c: [0.0; 3],
            ct: [0.0; 3],
            force: [0.0; 3],
            torque: [0.0; 3],
        }],
        splines: vec![
            spline(1, &count, &[0.0], &[&AKIMA_Y], false),
            // y = x^2 and y = 3 - x^2 on a uniform grid, where Akima's rule is exact for parabolas.
            spline(
                2,
                &[0.0, 1.0, 2.0, 3.0],
                &[-1.0, 1.0],
                &[&[0.0, 1.0, 4.0, 9.0], &[3.0, 2.0, -1.0, -6.0]],
                false,
            ),
            spline(3, &[0.0, 1.0, 2.0], &[0.0], &[&[0.0, 1.0, 0.0]], false),
            spline(
                4,
                &[0.0, 1.0, 3.0, 4.0],
                &[0.0],
                &[&[0.0, 1.0, 0.0, 2.0]],
                true,
            ),
            spline(
                5,
                &[1.0, 0.0, 3.0, 4.0],
                &[0.0],
                &[&[0.0, 1.0, 0.0, 2.0]],
                true,
            ),
            spline(
                6,
                &[1.0, 2.0, 3.0, 4.0],
                &[0.0],
                &[&[0.0, 2.0, 1.0, 3.0]],
                false,
            ),
        ],
        ..Model::default()
    }
}

struct Case {
    program: Program,
    literals: Vec<f64>,
    curves: Curves,
    text: String,
}

fn compile(text: &str) -> Case {
    let expression = Expression::parse_str(text).unwrap_or_else(|e| panic!("{text}: {e:?}"));
    let model = model();
    let compiler = ExpressionCompiler::new(&model);
    let program = compiler.compile(&expression);
    Case {
        program: program.unwrap_or_else(|e| panic!("{text}: {}", e.message)),
        curves: compiler.curves(),
        literals: expression.literals.iter().map(|l| l.value).collect(),
        text: text.to_string(),
    }
}

impl Case {
    fn numbers(&self) -> ProgramNumbers<'_> {
        ProgramNumbers {
            literals: &self.literals,
            curves: &self.curves,
        }
    }

    /// Returns the inputs for given values of VARIABLE/1, 2, 3 and TIME.
    fn inputs(&self, state: [f64; 4]) -> Vec<f64> {
        self.program
            .inputs
            .iter()
            .map(|input| match input {
                Input::Variable(index) => state[*index],
                Input::Time => state[3],
                other => panic!("{}: {other:?}", self.text),
            })
            .collect()
    }

    fn at(&self, state: [f64; 4]) -> Result<f64, EvalError> {
        self.program.eval(
            &self.inputs(state),
            self.numbers(),
            &mut EvaluationMemory::default(),
        )
    }
}

fn value(text: &str) -> f64 {
    compile(text).at([0.5, -1.25, 2.0, 0.75]).unwrap()
}

fn fault(text: &str) -> EvalError {
    compile(text).at([0.5, -1.25, 2.0, 0.75]).unwrap_err()
}

fn refused(text: &str) -> (Code, String) {
    let expression = Expression::parse_str(text).unwrap();
    let diagnostic = ExpressionCompiler::new(&model())
        .compile(&expression)
        .unwrap_err();
    (diagnostic.code, diagnostic.message)
}

#[track_caller]
fn near(text: &str, expected: f64) {
    let found = value(text);
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
        "{text} = {found}, not {expected}"
    );
}

#[test]
fn the_degree_in_some_inputs_is_that_of_the_text() {
    use super::Degree::{self, Higher, Linear, Nothing};
    for (text, expected) in [
        ("TIME", Nothing),
        ("VARVAL(1)", Linear),
        ("3", Nothing),
        ("2*VARVAL(1)/(1+TIME)-SIN(VARVAL(3))*(VARVAL(2)+1)", Linear),
        ("-(VARVAL(1)-VARVAL(2))*TIME**2", Linear),
        ("IF(TIME-1:VARVAL(1),2*VARVAL(2),3)", Linear),
        ("IF(TIME-1:0,VARVAL(1)**2,3)", Higher),
        ("IF(VARVAL(1):0,0,1)", Higher),
        ("VARVAL(1)*VARVAL(2)", Higher),
        ("TIME/VARVAL(1)", Higher),
        ("ABS(VARVAL(1))", Higher),
        ("MAX(TIME,VARVAL(3))", Nothing),
        ("STEP(TIME,0,0,1,VARVAL(1))", Higher),
    ] {
        let case = compile(text);
        let of = |input: &Input| match input {
            Input::Variable(0 | 1) => Degree::Linear,
            _ => Degree::Nothing,
        };
        assert_eq!(case.program.degree(of), expected, "{text}");
    }
}

#[test]
fn operators_are_those_of_fortran() {
    near("-2**2", -4.0);
    near("2**3**2", 512.0);
    near("(-2)**3", -8.0);
    near("1/2", 0.5);
    near("2*3-4/8*2", 5.0);
    near("180D", std::f64::consts::PI);
    near("90D*RTOD + PI*0", 90.0);
    near("DTOR", std::f64::consts::PI / 180.0);
    near("TIME*4", 3.0);
}

#[test]
fn intrinsics_have_their_fortran_values() {
    // guide/formats.md 3.5.
    for (text, expected) in [
        ("ABS(-3.5)", 3.5),
        ("AINT(-2.7)", -2.0),
        ("ANINT(2.5)", 3.0),
        ("ANINT(-2.5)", -3.0),
        ("NINT(0.49)", 0.0),
        ("INT(3.99)", 3.0),
        ("DIM(5,3)", 2.0),
        ("DIM(3,5)", 0.0),
        ("MOD(-7,3)", -1.0),
        ("MOD(7.5,-2)", 1.5),
        ("SIGN(3,-0.1)", -3.0),
        ("SIGN(-3,0)", 3.0),
        ("MAX(1,5,3)", 5.0),
        ("MIN(1,-5)", -5.0),
        ("LOG(EXP(2))", 2.0),
        ("LOG10(1000)", 3.0),
        ("SQRT(16)", 4.0),
        ("ATAN2(1,-1)", 0.75 * std::f64::consts::PI),
        ("ATAN2(0,-1)", std::f64::consts::PI),
        // The table of cfunc_atan2.
        ("ATAN2(0,0)", 0.0),
        ("ATAN2(1E-200,0)", 0.5 * std::f64::consts::PI),
        ("ACOS(0)+ASIN(1)", std::f64::consts::PI),
        ("ATAN(1)", std::f64::consts::FRAC_PI_4),
        ("COSH(1)**2-SINH(1)**2", 1.0),
        ("TANH(1)", 1f64.tanh()),
        ("SIN(30D)+COS(60D)+TAN(45D)", 2.0),
    ] {
        near(text, expected);
    }
}

#[test]
fn steps_have_their_levels_and_middle() {
    // guide/formats.md 3.6. The midpoint of every shape is the mean; the quarter points are 5/32, 53/512, (1 - cos 45)/2.
    for (name, quarter) in [
        ("STEP", 5.0 / 32.0),
        ("STEP5", 53.0 / 512.0),
        ("HAVSIN", 0.5 - std::f64::consts::FRAC_1_SQRT_2 / 2.0),
    ] {
        near(&format!("{name}(0,1,10,3,20)"), 10.0);
        near(&format!("{name}(3,1,10,3,20)"), 20.0);
        near(&format!("{name}(9,1,10,3,20)"), 20.0);
        near(&format!("{name}(2,1,10,3,20)"), 15.0);
        near(&format!("{name}(1.5,1,10,3,20)"), 10.0 + 10.0 * quarter);
        // Descending ends give the mirrored step.
        near(&format!("{name}(1.5,3,20,1,10)"), 10.0 + 10.0 * quarter);
        assert_eq!(fault(&format!("{name}(1,2,0,2,1)")).fault, Fault::EqualEnds);
    }
}

#[test]
fn impacts_push_and_never_pull() {
    // guide/formats.md 3.6 (the printed definitions of the SolidWorks Motion help).
    near("IMPACT(3,0,2,100,1.5,10,0.1)", 0.0);
    near("IMPACT(1,0,2,100,1.5,10,0.1)", 100.0);
    near("IMPACT(-2,0,2,100,1.5,10,0.1)", 800.0);
    // Full damping applies beyond d. Approach speeds add to the force, separation speeds reduce it down to zero.
    near("IMPACT(1,-2,2,100,1.5,10,0.1)", 120.0);
    near("IMPACT(1,2,2,100,1.5,10,0.1)", 80.0);
    near("IMPACT(1,20,2,100,1.5,10,0.1)", 0.0);
    // Half of the damping at half of d.
    near("IMPACT(1.95,-2,2,0,1.5,10,0.1)", 10.0);
    near("BISTOP(1,0,2,4,100,2,10,0.1)", 100.0);
    near("BISTOP(3,0,2,4,100,2,10,0.1)", 0.0);
    near("BISTOP(7,0,2,4,100,2,10,0.1)", -900.0);
    near("BISTOP(5,2,2,4,100,2,10,0.1)", -120.0);
    near("BISTOP(5,-20,2,4,100,2,10,0.1)", 0.0);
    near("BISTOP(1,-2,2,4,100,2,10,0.1)", 120.0);
}

#[test]
fn series_are_their_sums() {
    near("POLY(3,1,5,4,3)", 5.0 + 4.0 * 2.0 + 3.0 * 4.0);
    near("CHEBY(1.5,1,1,2,3,4)", 1.0 + 2.0 * 0.5 + 3.0 * -0.5 - 4.0);
    near(
        "SHF(2,1,10,PI,30D,3)",
        10.0 * (std::f64::consts::PI * 5.0 / 6.0).sin() + 3.0,
    );
    near("SHF(1,1,10,PI,30D)", -5.0);
    // Worked example of the FORSIN page: a0 is the only constant term.
    let w = std::f64::consts::PI;
    let sum = |f: fn(f64) -> f64| f(w) + 2.0 * f(2.0 * w) + 3.0 * f(3.0 * w);
    near("FORSIN(0.75,-0.25,PI,7,1,2,3)", 7.0 + sum(f64::sin));
    near("FORCOS(0.75,-0.25,PI,7,1,2,3)", 7.0 + sum(f64::cos));
    // Sweep: at rest before x0, then f0 at x0 and f1 beyond x1; the phase is continuous.
    near("SWEEP(0.5,3,1,2,5,6,0.01)", 0.0);
    near(
        "SWEEP(3,3,1,2,5,6,0.01)",
        3.0 * (std::f64::consts::TAU * (6.0 + 4.0 * 4.0 / 8.0)).sin(),
    );
    let step =
        value("SWEEP(5.0000001,3,1,2.1,5,6.3,0.01)") - value("SWEEP(4.9999999,3,1,2.1,5,6.3,0.01)");
    assert!(step.abs() < 1e-4, "{step}");
}

#[test]
fn only_the_chosen_branch_is_evaluated() {
    near("IF(-1:10,20,30)", 10.0);
    near("IF(0:10,20,30)", 20.0);
    near("IF(1:10,20,30)", 30.0);
    // VARIABLE/2 is negative: the roots would fail.
    near("IF(VARVAL(2):VARVAL(1),1/0,SQRT(VARVAL(2)))", 0.5);
    near(
        "IF(VARVAL(1)-1:IF(VARVAL(2):IF(TIME:1,2,VARVAL(3)*7),5,6),8,9)+1",
        15.0,
    );
    near("VARVAL(1)*IF(1:0,0,4)*IF(-1:VARVAL(3),0,0)", 4.0);
    // MODE is 5 in statics.
    let case = compile("IF(MODE-5:0,7,0)");
    let modes = |mode: f64| {
        case.program
            .eval(&[mode], case.numbers(), &mut EvaluationMemory::default())
    };
    assert_eq!(case.program.inputs, [Input::Mode]);
    assert_eq!((modes(5.0), modes(4.0)), (Ok(7.0), Ok(0.0)));
}

#[test]
fn arrays_are_read() {
    near("ARYVAL(1,2)", -2.5);
    near("ARYVAL(2,1)", 2.0);
    assert_eq!(refused("ARYVAL(1,3)").0, Code::BadExpression);
    assert_eq!(refused("ARYVAL(1,0)").0, Code::BadExpression);
}

#[test]
fn faults_name_their_function() {
    for (text, function, fault_found) in [
        ("SQRT(VARVAL(2))", "SQRT", Fault::NotDefined),
        ("1/(VARVAL(1)-0.5)", "/", Fault::NotDefined),
        ("VARVAL(2)**0.5", "**", Fault::NotDefined),
        ("LOG(0)", "LOG", Fault::TooLarge),
        ("EXP(1000)", "EXP", Fault::TooLarge),
        ("ASIN(2)", "ASIN", Fault::NotDefined),
        ("MOD(1,0)", "MOD", Fault::NotDefined),
    ] {
        let error = fault(text);
        assert_eq!(
            (error.function, error.fault),
            (function, fault_found),
            "{text}"
        );
    }
    assert_eq!(
        fault("STEP(TIME,1,0,1,2)").to_string(),
        "STEP has x0 equal to x1"
    );
}

#[test]
fn what_cannot_be_evaluated_is_refused_by_name() {
    for vector in ["[1,2,3]", "TIME%2", "MAG([1,2,3])"] {
        let (code, message) = refused(vector);
        assert_eq!(code, Code::NotSolvedNatively, "{vector}: {message}");
    }
    for (text, code, says) in [
        ("DX(99)", Code::UndefinedId, "MARKER/99"),
        ("VARVAL(9)", Code::UndefinedId, "VARIABLE/9"),
        ("DX(1+1)", Code::WrongType, "DX(i[,j][,k])"),
        ("DX(1.5)", Code::WrongType, "whole number"),
        ("FX(0)", Code::BadExpression, "must be the id of a marker"),
        ("BUSH(7,2,1,0)", Code::BadExpression, "jflag"),
        ("BUSH(7,0,9,0)", Code::BadExpression, "1 to 8"),
        ("BUSH(8,0,1,0)", Code::UndefinedId, "BUSHING/8"),
        ("2*USER(1,2)", Code::UserSubroutine, "user-written"),
        ("DELAY(TIME,1,0)", Code::NotSolvedNatively, "DELAY"),
        (
            "INVPSD(TIME,1,0,1,3,0,1)",
            Code::NotSolvedNatively,
            "INVPSD",
        ),
        ("CURVE(TIME,0,1,1)", Code::NotSolvedNatively, "CURVE"),
        ("CONTACT(1,0,1,0)", Code::NotSolvedNatively, "CONTACT"),
        ("ORIENT(26,1,1)", Code::NotSolvedNatively, "ORIENT"),
        ("ORIENT(1,4,1)", Code::BadExpression, "1 to 3"),
    ] {
        let (found, message) = refused(text);
        assert_eq!(found, code, "{text}: {message}");
        assert!(message.contains(says), "{text}: {message}");
    }
}

#[test]
fn rates_know_their_markers_and_equal_inputs_are_read_once() {
    use crate::function::{RateAxis, RateKind};
    use crate::model::MarkerIx;
    let case = compile("VX(1,2,3,1)+WZ(3)+ACCM(1,0,2)+VR(1,2)");
    let rates: Vec<_> = case
        .program
        .inputs
        .iter()
        .map(|input| match input {
            Input::Rate(rate) => (
                rate.kind,
                rate.axis,
                rate.markers.map(|m| m.map(|MarkerIx(k)| k)),
            ),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(
        rates,
        [
            (
                RateKind::Velocity,
                RateAxis::Axis(0),
                [Some(0), Some(1), Some(2), Some(0)]
            ),
            (
                RateKind::AngularVelocity,
                RateAxis::Axis(2),
                [Some(2), None, None, None]
            ),
            // A magnitude has no axes, so its third argument is the frame of the time derivative.
            (
                RateKind::Acceleration,
                RateAxis::Magnitude,
                [Some(0), None, None, Some(1)]
            ),
            (
                RateKind::Velocity,
                RateAxis::Along,
                [Some(0), Some(1), None, None]
            ),
        ]
    );
    let case = compile("DX(1,2)*DX(1,2)+DX(1,2,0)-DX(1,2,3)");
    assert_eq!(case.program.inputs.len(), 2);
}

#[test]
fn constants_follow_their_literals() {
    let case = compile("42");
    let mut by = [0.0];
    let found = case.program.eval_with_derivatives(
        &[],
        case.numbers(),
        &mut EvaluationMemory::default(),
        &mut [],
        &mut by,
    );
    assert_eq!((found, by), (Ok(42.0), [1.0]));
}

#[test]
fn ids_are_no_parameters() {
    let case = compile("BUSH(7,0,2,3)*2.5 + AKISPL(TIME,0,1)");
    // The parameters are 2.5 and the z of AKISPL, without ids and codes.
    let values: Vec<f64> = case
        .program
        .parameters
        .iter()
        .map(|&k| case.literals[k])
        .collect();
    assert_eq!(values, [2.5, 0.0]);
}

#[test]
fn a_function_of_a_real_deck_reads_as_meant() {
    // Form given in guide/formats.md 1.3: steps inside an IF on an angle in degrees.
    let case = compile(
        "IF( MOD(AZ(4,3),PI/2)-89D: STEP(TIME,0,0,1,28.57), 28.57, STEP(TIME,1,28.57,2,0) )",
    );
    let at = |angle: f64, time: f64| {
        let inputs: Vec<f64> = case
            .program
            .inputs
            .iter()
            .map(|input| if *input == Input::Time { time } else { angle })
            .collect();
        case.program
            .eval(&inputs, case.numbers(), &mut EvaluationMemory::default())
            .unwrap()
    };
    assert!((at(0.1, 0.5) - 14.285).abs() < 1e-12);
    assert!((at(89.5f64.to_radians(), 0.5) - 28.57).abs() < 1e-12);
    assert!((at(std::f64::consts::TAU + 0.1, 2.0) - 28.57).abs() < 1e-12);
}
