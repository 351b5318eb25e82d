//! Tests of the typed model, built from real decks and from small ones.

use admire_solver::model::{Definitions, Function, JointKind, Model, Orientation, RequestKind};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::lint::{self, Options};
use admire_syntax::text::{Source, Span};
use admire_syntax::{CommandFile, Dataset};

use super::lossless::real_files;

pub fn dataset(text: &str) -> Checked<Dataset> {
    Dataset::parse(Source::new("test.adm", text.as_bytes().to_vec()))
}

pub fn model(text: &str) -> Model {
    let parsed = dataset(text);
    assert!(!parsed.has_errors(), "{:?}", parsed.diagnostics);
    let lowered = Model::lower(&parsed.value);
    assert!(!lowered.has_errors(), "{:?}", lowered.diagnostics);
    lowered.value
}

pub fn redefine(model: &mut Model, definitions: &mut Definitions, text: &str) -> Vec<Code> {
    let source = Source::new("test.acf", format!("\n{text}\n").into_bytes());
    let parsed = CommandFile::parse(source.clone());
    assert!(parsed.diagnostics.is_empty(), "{:?}", parsed.diagnostics);
    let mut codes = Vec::new();
    for command in parsed.value.commands() {
        let complaints = definitions.redefine(model, command, &source);
        codes.extend(complaints.iter().map(|complaint| complaint.code));
    }
    codes
}

#[test]
fn real_decks_are_resolved_without_complaint() {
    for (name, bytes) in real_files("adm") {
        let parsed = Dataset::parse(Source::new(name.as_str(), bytes)).value;
        let lowered = Model::lower(&parsed);
        assert_eq!(lowered.diagnostics, [], "{name}");
        assert_eq!(
            lowered.value.parts.len(),
            parsed
                .statements()
                .iter()
                .filter(|s| matches!(s.kind(), Some("PART" | "FE_PART" | "POINT_MASS")))
                .count()
        );
    }
}

const SMALL: &str = "small
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
!  adams_view_name='ground'
PART/01, GROUND
MARKER/0101, PART=01, QP=1,2,3, REULER=90D,0,0
PART/2, MASS=2, CM=0201, IP=1,2,3
, QG=10,0,0
!  adams_view_name='hub'
MARKER/0201
, PART=2, ZP=1,0,0, XP=0,1,0
BUSHING/7, I=201, J=101, K=1,2,3, KT=4,5,6D
JOINT/1, REVOLUTE, I=101, J=201
SFORCE/3, I=201, J=101, TRANSLATIONAL
, FUNCTION = 5*
, DM(201,101)
REQUEST/1, F2=DX(201,101)\\F3=1,C=two
MOTION/4, JOINT=1, FUNCTION=30D*TIME
ACCGRAV/KGRAV=-9806.65
END
";

#[test]
fn a_small_deck_is_read_with_its_units_names_and_frames() {
    let model = model(SMALL);
    assert_eq!(model.units.ucf, 1000.0);
    assert_eq!(model.gravity.z, -9806.65);
    assert_eq!(model.parts[0].header.name, "ground");
    assert_eq!(model.parts[1].header.name, "PART_2");
    let hub = &model.markers[1];
    assert_eq!(hub.header.name, "hub");
    assert_eq!(hub.orientation, Orientation::Points);
    // The z axis is along x of the part, and the x axis along y of the part.
    assert!((hub.R.column(2) - nalgebra::Vector3::x()).norm() < 1e-15);
    assert!((hub.R.column(0) - nalgebra::Vector3::y()).norm() < 1e-15);
    assert_eq!(
        model.markers[0].orientation,
        Orientation::Reuler([std::f64::consts::FRAC_PI_2, 0.0, 0.0])
    );
    let bushing = &model.bushings[0];
    assert_eq!(bushing.k, [1.0, 2.0, 3.0]);
    assert_eq!(bushing.kt, [4.0, 5.0, 6f64.to_radians()]);
    assert_eq!(bushing.torque, [0.0; 3]);
    assert_eq!(model.joints[0].kind, JointKind::Revolute);
    assert_eq!(model.motions[0].joint, Some(0));
    match &model.sforces[0].function {
        Function::Expression(expression) => assert_eq!(expression.literals.len(), 3),
        Function::User(text) => panic!("{text}"),
    }
    match &model.requests[0].kind {
        RequestKind::Functions(functions) => {
            assert!(functions[0].is_none() && functions[1].is_some() && functions[2].is_some());
        }
        kind => panic!("{kind:?}"),
    }
    assert_eq!(model.requests[0].comment, "two");
}

#[test]
fn commands_change_only_what_they_give() {
    let lowered = Definitions::lower(&dataset(SMALL).value, &Files::default());
    let (mut model, mut definitions) = lowered.value;
    let before = model.clone();
    let mut redefine = |model: &mut Model, text: &str| redefine(model, &mut definitions, text);
    let codes = redefine(
        &mut model,
        "BUSHING/7, K=10,20,30\nEQUIL/ERR=1E-8, PATTERN=T:F\nSFORCE/3, FUNC=-4000.0\nPART/2, MASS=3\nACCG/IGRAV=1\nDEACT/MOTION, ID=4",
    );
    assert_eq!(codes, []);
    assert_eq!(model.bushings[0].k, [10.0, 20.0, 30.0]);
    assert_eq!(model.bushings[0].kt, before.bushings[0].kt);
    assert_eq!(model.equilibrium.error, 1e-8);
    assert_eq!(model.equilibrium.pattern, [true, false]);
    assert_eq!(model.equilibrium.imbalance, 1e-4);
    assert_eq!(model.parts[1].mass, 3.0);
    assert_eq!(model.parts[1].pose, before.parts[1].pose);
    assert_eq!((model.gravity.x, model.gravity.z), (1.0, -9806.65));
    assert!(!model.motions[0].header.active);
    let text = |model: &Model| match &model.sforces[0].function {
        Function::Expression(expression) => expression.text.clone(),
        Function::User(text) => text.clone(),
    };
    assert_eq!(text(&before), "5* DM(201,101)");
    assert_eq!(text(&model), "-4000.0");
    assert_eq!(
        redefine(&mut model, "EQUIL/DEFAULT\nACTIVATE/MOTION, RANGE=1,9"),
        []
    );
    assert_eq!(model.equilibrium, before.equilibrium);
    assert!(model.motions[0].header.active);
    assert_eq!(
        redefine(
            &mut model,
            "SFORCE/4, FUNCTION=0\nMARKER/999, QP=1,2,3\nBUSHING/7, J=55"
        ),
        [Code::UndefinedId; 3]
    );
}

const REDEFINED: &str = "redefined
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/11, PART=1
MARKER/12, PART=1, QP=1,2,3, REULER=90D,0,0
MARKER/13, PART=1, QP=1,0,0, RM=12
PART/2, MASS=2, CM=21
MARKER/21, PART=2
GFORCE/1, I=21, JFLOAT=22, RM=11, FUNCTION=USER(1)
MARKER/22, PART=1, FLOATING
REQUEST/1, F2=1, F3=2
REQUEST/2, DISPLACEMENT, I=21, J=11
MOTION/1, I=21, J=11, Z, FUNCTION=0
JOINT/1, I=21, J=11, TRANSLATIONAL
SPLINE/1, X=1,2,3,4, Y=1,2,3,4
INTEGRATOR/WSTIFF, ERROR=1E-5
INTEGRATOR/HMAX=0.1
END
";

#[test]
fn a_command_is_put_over_its_statement_which_is_lowered_again() {
    let lowered = Definitions::lower(&dataset(REDEFINED).value, &Files::default());
    let (mut model, mut definitions) = lowered.value;
    let names = |model: &Model| {
        let unsolved = model.unsolved.iter().map(|u| u.kind).collect::<Vec<_>>();
        (unsolved, model.vector_forces.len())
    };
    assert_eq!(names(&model), (vec!["GFORCE"], 0));
    // Repeated INTEGRATOR statements of a dataset are merged as well.
    assert_eq!(
        (model.integrator.method, model.integrator.hmax),
        ("WSTIFF", Some(0.1))
    );
    let mut redefine = |model: &mut Model, text: &str| redefine(model, &mut definitions, text);

    // A new argument that excludes the old one replaces it.
    assert_eq!(
        redefine(
            &mut model,
            "GFORCE/1, FX=1\nMOTION/1, JOINT=1\nREQUEST/2, F2=3\nREQUEST/1, F3=4\nINTEGRATOR/GSTIFF"
        ),
        []
    );
    assert_eq!(names(&model), (vec![], 1));
    assert_eq!(model.motions[0].joint, Some(0));
    let functions = |request: usize| match &model.requests[request].kind {
        RequestKind::Functions(all) => all.iter().flatten().count(),
        _ => 0,
    };
    assert_eq!((functions(0), functions(1)), (2, 1));
    let integrator = &model.integrator;
    assert_eq!(
        (integrator.method, integrator.error, integrator.hmax),
        ("GSTIFF", Some(1e-5), Some(0.1))
    );

    // A redefined marker keeps its reference frame, and a redefined object stays deactivated.
    let before = model.markers[2].qp;
    assert_eq!((before.x, before.y, before.z), (1.0, 3.0, 3.0));
    assert_eq!(
        redefine(
            &mut model,
            "MARKER/13, QP=2,0,0\nDEACTIVATE/JOINT, ID=1\nJOINT/1, REVOLUTE"
        ),
        []
    );
    let after = model.markers[2].qp;
    assert!((after - before - admire_solver::mechanics::Vec3::new(0.0, 1.0, 0.0)).norm() < 1e-14);
    assert_eq!(model.joints[0].kind, JointKind::Revolute);
    assert!(!model.joints[0].header.active);

    // A command with an error changes nothing.
    let before = model.clone();
    assert_eq!(
        redefine(&mut model, "PART/2, GROUND\nSPLINE/1, X=1,2"),
        [Code::NoGround, Code::MissingArgument]
    );
    assert_eq!(model, before);
}

#[test]
fn undefined_and_duplicate_ids_are_located() {
    let parsed = dataset(
        "t\nPART/1, GROUND\nMARKER/10, PART=2\nMARKER/10, PART=1\nSFORCE/1, I=10, J=100, ROT, FUN=DX(11)\nEND\n",
    );
    let lowered = Model::lower(&parsed.value);
    let shown: Vec<String> = lowered
        .diagnostics
        .iter()
        .map(|d| {
            let place = parsed.value.source().line_column(d.labels[0].span.start());
            format!("{}:{} {} {:?}", place.line, place.column, d.message, d.help)
        })
        .collect();
    assert_eq!(
        shown,
        [
            "4:8 MARKER/10 is defined twice; the first definition is used None",
            "3:17 MARKER/10 names PART/2, which is not in this dataset Some(\"did you mean PART/1?\")",
            "5:19 SFORCE/1 names MARKER/100, which is not in this dataset Some(\"did you mean MARKER/10?\")",
            "5:36 SFORCE/1 names MARKER/11, which is not in this dataset Some(\"did you mean MARKER/10?\")",
        ]
    );
}

/// Checks the rule of the ADAMS manual for a MARKER without PART: it belongs to the PART, POINT_MASS or FLEX_BODY before it. A marker on a
/// CURVE belongs to no body.
#[test]
fn markers_that_name_no_body_are_on_the_one_before_them() {
    let text = "deck
PART/1, GROUND
MARKER/10
PART/2, MASS=2, CM=20
MARKER/20
ACCGRAV/KGRAV=-9806.65
MARKER/21, QP=1,2,3
POINT_MASS/3, MASS=1, CM=30
MARKER/30
MARKER/11, PART=1
END
";
    let model = model(text);
    let on = |id: u32| {
        let marker = model.markers.iter().find(|m| m.header.id == id).unwrap();
        model.parts[marker.part.0].header.id
    };
    assert_eq!([10, 20, 21, 30, 11].map(on), [1, 2, 2, 3, 1]);

    let bare = dataset("deck\nMARKER/10\nPART/1, GROUND\nEND\n").value;
    let codes: Vec<Code> = Model::lower(&bare)
        .diagnostics
        .iter()
        .map(|d| d.code)
        .collect();
    assert_eq!(codes, [Code::MissingArgument]);

    let curve = text.replace(
        "MARKER/21, QP=1,2,3",
        "CURVE/1, CURVE_POINTS, MATRIX=1\nMATRIX/1, FILE=c.mtx, NAME=c\nMARKER/21, CURVE=1, RM=20",
    );
    let lowered = Model::lower(&dataset(&curve).value);
    assert!(!lowered.has_errors(), "{:?}", lowered.diagnostics);
    let kinds: Vec<&str> = lowered.value.unsolved.iter().map(|u| u.kind).collect();
    assert_eq!(kinds, ["CURVE", "MARKER"]);
}

#[test]
fn a_sparse_matrix_is_rows_columns_and_values() {
    let deck = |matrix: &str| {
        format!(
            "deck\nPART/1, GROUND\nARRAY/1, X, SIZE=2\nMATRIX/1, {matrix}, ROWS=2, COLUMNS=2\nLSE/1, X=1, A=1\nEND\n"
        )
    };
    let sparse = model(&deck("SPARSE, I=1,2, J=2,1, VALUES=5,-3"));
    let full = model(&deck("FULL=RORDER, VALUES=0,5,-3,0"));
    assert_eq!(sparse.linear_states[0].a, [[0.0, 5.0], [-3.0, 0.0]]);
    assert_eq!(sparse.linear_states[0].a, full.linear_states[0].a);
}

#[test]
fn a_joint_of_marker_zero_is_no_joint_that_may_be_forgotten() {
    let deck = |j: &str| {
        format!(
            "t\nPART/1, GROUND\nPART/2, MASS=1, CM=20\nMARKER/10, PART=1\nMARKER/20, PART=2\nJOINT/1, FIXED, I=20, J={j}\nREQUEST/1, DISPLACEMENT, I=20, J=0, RM=0\nEND\n"
        )
    };
    let found = |text: &str| {
        let parsed = dataset(text);
        Model::lower(&parsed.value).diagnostics
    };
    assert_eq!(found(&deck("10")), []);
    let complaints = found(&deck("0"));
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert_eq!(complaints[0].severity, Severity::Error);
    assert_eq!(
        complaints[0].message,
        "J of JOINT/1 must name a MARKER, not 0"
    );
}

/// Checks that `check` and the lowering report the faults found from the grammar alone with the same messages and positions.
#[test]
fn lint_and_lowering_tell_faults_in_the_same_words() {
    let text = "t
PART/1, GROUND
MARKER/10, PART=1
MARKER/20, PART=2
PART/2, MASS=1, CM=20
BUSHING/1, I=20, K=1,2, C=1,2,3, KT=1,2,3, CT=1,2,3
SFORCE/1, I=20.5, J=0, ROTATION, FUNCTION=DX(1.5, 77)
JOINT/1, FIXED, I=20, J=99
JOINT/2, REVOLUTE, PITCH=1, I=20, J=10
JPRIM/1, I=20, J=10
MOTION/1, I=20, Z, FUNCTION=0
SPRINGDAMPER/1, TRANSLATIONAL, ROTATIONAL, I=20, J=10
EQUILIBRIUM/MAXIT=25.5
END
";
    let parsed = dataset(text).value;
    let codes = [
        Code::MissingArgument,
        Code::ConflictingArguments,
        Code::WrongCount,
        Code::WrongType,
        Code::UndefinedId,
    ];
    let told = |all: Vec<Diagnostic>| -> Vec<(String, Option<Span>)> {
        let own = all.into_iter().filter(|d| codes.contains(&d.code));
        let mut told: Vec<_> = own
            .map(|d| (d.message, d.labels.first().map(|label| label.span)))
            .collect();
        told.sort();
        told
    };
    let lowered = told(Model::lower(&parsed).diagnostics);
    assert_eq!(lowered.len(), 12, "{lowered:#?}");
    assert_eq!(lowered, told(lint::check(&parsed, &Options::default())));
    // Faults of strings, of graphics and of print options change no result, so only `check` reports them.
    let drawn = "GRAPHICS/1, CIRCLE, CM=10, RADIUS=1, SEG=2.5\nDEBUG/EPRINT, NOEPRINT\nEND";
    let harmless = text.replace("END", drawn);
    let harmless = dataset(&harmless).value;
    assert_eq!(told(Model::lower(&harmless).diagnostics), lowered);
    assert_eq!(
        told(lint::check(&harmless, &Options::default())).len(),
        lowered.len() + 2
    );
}
