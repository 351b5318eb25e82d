//! Numbers at the limits of their range, and other units: the result is an equilibrium or a refusal, and never a wrong number.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use admire_solver::mechanics::{Pose, Vec3, euler313, exp};
use admire_solver::model::{Model, PartIx};
use admire_solver::system::{Scratch, System};
use admire_syntax::text::{Edit, Source, Span, apply_edits};
use admire_syntax::{Dataset, Value};
use rayon::prelude::*;

use crate::run::{Results, folder, mdi_with};

/// A block held only by forces, with every law that needs no multiplier; its force balance can be evaluated from its position.
const BLOCK: &str = "\
A block held by forces
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
MARKER/11, PART=1, QP=0, 0, -50
MARKER/12, PART=1, QP=5, 6, -7, REULER=10D, 20D, 30D
MARKER/9, PART=1, FLOATING
PART/2, QG=1, 2, 3, REULER=1D, 2D, 3D, MASS=2, CM=20, IP=100, 110, 120
MARKER/20, PART=2
MARKER/21, PART=2, QP=100, 0, 0
MARKER/22, PART=2, QP=3, 4, 50, REULER=5D, 6D, 7D
BUSHING/1, I=22, J=12, K=100, 200, 300, KT=3E5, 2E5, 4E5, C=1, 2, 3, CT=1, 2, 3, FORCE=1, 2, 3, TORQUE=4, 5, 6
BEAM/1, I=21, J=1, LENGTH=100, IXX=980, IYY=490, IZZ=490, AREA=78.5, ASY=1.11, ASZ=1.11
, EMODULUS=2.07E+05, GMODULUS=8.0E+04, CRATIO=0.01
FIELD/1, I=20, J=1, KMATRIX=100,0,0,0,0,0,0,100,0,0,0,0,0,0,100,0,0,0,0,0,0,1E6,0,0,0,0,0,0,1E6,0,0,0,0,0,0,1E6
, LENGTH=1,0,0,0D,0D,5D
SPRINGDAMPER/1, TRANSLATIONAL, I=22, J=11, K=10, C=1, LENGTH=100, FORCE=2
SFORCE/1, TRANSLATIONAL, I=21, J=11, FUNCTION=STEP(DM(21,11), 50, 0, 200, 10)+IMPACT(DX(21,1), VX(21,1), 120, 10, 1.5, 1, 0.1)
SPLINE/1, X=-10, 0, 10, 20, 30, Y=-100, 0, 100, 250, 300
VFORCE/1, I=20, JFLOAT=9, RM=1, FX=-AKISPL(DX(20,1), 0, 1)\\, FY=3\\, FZ=BISTOP(DZ(20,1), VZ(20,1), -50, 50, 1E3, 1.5, 1, 0.1)
VARIABLE/1, FUNCTION=2*DX(20,1)
ACCGRAV/KGRAV=-9806.65
EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8, MAXIT=100
RESULTS/FORMATTED, XRF
END
";

const EDGES: [&str; 9] = [
    "0",
    "-1",
    "1E-320",
    "1E308",
    "-1E308",
    "1E400",
    "NaN",
    "-Infinity",
    "1.#IND",
];

/// Returns the spans of all numbers of a deck, including those in functions, with the kinds of their statements.
fn numbers(text: &str) -> Vec<(Span, String)> {
    let dataset = Dataset::parse(Source::new("block.adm", text)).value;
    let mut all = Vec::new();
    for statement in dataset.statements() {
        for argument in &statement.arguments {
            let found = match &argument.value {
                Value::Numbers(numbers) => numbers.iter().map(|number| number.span).collect(),
                Value::Function(function) => {
                    let literals = function.literals.iter();
                    literals.map(|number| number.span).collect()
                }
                _ => Vec::new(),
            };
            let kind = statement.kind().unwrap_or_default();
            all.extend(found.into_iter().map(|span| (span, kind.to_string())));
        }
    }
    all
}

/// Returns the remaining force and torque on the block at the pose computed by a run.
///
/// Each comes with the size of the loads that cancel, and with its change for a change of the pose in its last digits.
fn left(deck: &str, at: &[f64; 6]) -> [(Vec3, f64, f64); 2] {
    let dataset = Dataset::parse(Source::new("block.adm", deck)).value;
    let model = Model::lower(&dataset).value;
    let system = System::compile(&model).value;
    let parameters = system.parameters();
    let loads = |pose: Pose| {
        let mut state = system.state();
        state.poses[1] = pose;
        let mut scratch = Scratch::new(&system);
        let mut here = system
            .evaluate(&parameters, &state, &mut scratch)
            .expect("functions with values");
        let mut sums = [(Vec3::zeros(), 0.0), (Vec3::zeros(), 0.0)];
        for load in here.loads().expect("loads with values") {
            if load.part == PartIx(1) {
                let arm = load.point - pose.p;
                sums[0].0 += load.force;
                sums[0].1 += load.force.amax();
                sums[1].0 += load.torque_about(&pose.p);
                sums[1].1 += load.torque.amax() + arm.amax() * load.force.amax();
            }
        }
        sums
    };
    let pose = Pose {
        p: Vec3::new(at[0], at[1], at[2]),
        R: euler313(at[3], at[4], at[5]),
    };
    let sums = loads(pose);
    let mut noise = [0.0_f64; 2];
    for direction in 0..3 {
        let mut step = Vec3::zeros();
        step[direction] = 1e-13;
        let moved = Pose {
            p: pose.p + step * (100.0 + pose.p.norm()),
            R: pose.R,
        };
        let turned = Pose {
            p: pose.p,
            R: exp(&step) * pose.R,
        };
        for near in [moved, turned] {
            for (noise, (near, here)) in noise.iter_mut().zip(loads(near).iter().zip(&sums)) {
                *noise = noise.max((near.0 - here.0).amax());
            }
        }
    }
    [0, 1].map(|k| (sums[k].0, sums[k].1, noise[k]))
}

/// Checks every number of the deck at every limit, one at a time: `mdi` must end in time and without a panic.
///
/// A solution must have finite numbers and forces that cancel; otherwise a reason must be given.
#[test]
fn every_number_at_its_edges() {
    let numbers = numbers(BLOCK);
    assert!(numbers.len() > 100, "{}", numbers.len());
    let cases: Vec<_> = numbers
        .iter()
        .flat_map(|number| EDGES.map(|edge| (number, edge)))
        .collect();
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|((span, kind), edge)| {
            let edits = [Edit::new(*span, *edge)];
            let deck = apply_edits(BLOCK.as_bytes(), &edits).expect("one edit");
            let deck = String::from_utf8(deck).expect("text");
            let told = |what: String| {
                let line = BLOCK[..span.start()].lines().count();
                let column = BLOCK[..span.start()]
                    .rfind('\n')
                    .map_or(0, |end| span.start() - end);
                Some(format!(
                    "{kind}, line {line} column {column}, {edge}: {what}"
                ))
            };
            let place = folder(&[
                ("block.adm", &deck),
                ("run.acf", "\nfile/model=block\nSIM/STAT\nSTOP\n"),
            ]);
            let start = Instant::now();
            let ran = mdi_with(place.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
            if start.elapsed() > Duration::from_secs(60) {
                return told(format!("took {:?}", start.elapsed()));
            }
            if ran.stderr.contains("panicked") || !(0..=3).contains(&ran.code) {
                return told(format!("code {}: {}", ran.code, ran.stderr));
            }
            if ran.code != 0 {
                let said = ran.stdout.contains("---- START: ERROR ----");
                return if said {
                    None
                } else {
                    told(format!("code {} and no reason: {}", ran.code, ran.stdout))
                };
            }
            let results = Results::read(place.path(), "block.res");
            let Some(step) = results.steps.last() else {
                return told("code 0 and no step".to_string());
            };
            if step.iter().any(|x| !x.is_finite()) {
                return told(format!("no number among {step:?}"));
            }
            // EQUILIBRIUM may have any tolerances.
            if kind == "EQUILIBRIUM" {
                return None;
            }
            let at = ["X", "Y", "Z", "PSI", "THETA", "PHI"].map(|component| {
                *results
                    .column("PART_2_XFORM", component)
                    .last()
                    .expect("a step")
            });
            for (left, size, noise) in left(&deck, &at) {
                // A NaN must not pass.
                let allowed = 1e-6 + 1e-7 * size + noise;
                if !(left.amax() <= allowed && allowed.is_finite()) {
                    return told(format!(
                        "{left:?} left of {size:e}, {noise:e} by the last digits of {at:?}"
                    ));
                }
            }
            None
        })
        .collect();
    println!("{} cases", cases.len());
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
}

/// A mechanism with joints, a motion and an integrator.
const MECHANISM: &str = "\
A mechanism
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
MARKER/2, PART=1, REULER=90D, 90D, 0D
MARKER/11, PART=1, QP=0, 0, -50
PART/2, MASS=2, CM=20, IP=100, 110, 120, VZ=1
MARKER/20, PART=2
MARKER/21, PART=2, QP=0, 0, 50
JOINT/1, TRANSLATIONAL, I=20, J=1, IC=1, ICTRAN=0.5
SPRINGDAMPER/1, TRANSLATIONAL, I=21, J=11, K=10, C=0.1, LENGTH=100
PART/3, QG=100, 0, 0, MASS=1.5, CM=30, IP=50, 60, 70
MARKER/30, PART=3, QP=0, 0, -20
MARKER/31, PART=3, REULER=90D, 90D, 0D
MARKER/12, PART=1, QP=100, 0, 0, REULER=90D, 90D, 0D
JOINT/2, REVOLUTE, I=31, J=12
MOTION/1, JOINT=2, FUNCTION=0.3*SIN(2*TIME)
PART/4, QG=0, 100, 0, MASS=1, CM=40, IP=10, 10, 10
MARKER/40, PART=4
MARKER/41, PART=4, QP=0, 30, 0
MARKER/13, PART=1, QP=0, 100, 0
JOINT/3, SPHERICAL, I=40, J=13
SFORCE/1, ROTATIONAL, ACTIONONLY, I=41, J=13, FUNCTION=5*AZ(40,13)
SPRINGDAMPER/2, TRANSLATIONAL, I=41, J=21, K=3, LENGTH=90
GCON/1, FUNCTION=DX(40,13)*0+AX(40,13)
ACCGRAV/KGRAV=-9806.65
INTEGRATOR/ERROR=1E-3, HMAX=0.01
EQUILIBRIUM/ERROR=1E-8, IMBALANCE=1E-6, MAXIT=50
RESULTS/FORMATTED, XRF
END
";

/// Checks every number of a moving mechanism at its limits: the run must end in time, with finite numbers or with a reason.
#[test]
fn every_number_of_a_mechanism_at_its_edges() {
    let numbers = numbers(MECHANISM);
    assert!(numbers.len() > 80, "{}", numbers.len());
    let edges = ["0", "-1", "1E-320", "1E308", "1E400", "NaN", "-Infinity"];
    let cases: Vec<_> = numbers
        .iter()
        .flat_map(|number| edges.map(|edge| (number, edge)))
        .collect();
    let answered = AtomicUsize::new(0);
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|((span, kind), edge)| {
            let deck =
                apply_edits(MECHANISM.as_bytes(), &[Edit::new(*span, *edge)]).expect("one edit");
            let deck = String::from_utf8(deck).expect("text");
            let acf = "\nfile/model=mechanism\nSIM/DYN, END=0.05, STEPS=3\nSTOP\n";
            let place = folder(&[("mechanism.adm", &deck), ("run.acf", acf)]);
            let start = Instant::now();
            let ran = mdi_with(place.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
            let what = if start.elapsed() > Duration::from_secs(60) {
                format!("took {:?}", start.elapsed())
            } else if ran.stderr.contains("panicked") || !(0..=3).contains(&ran.code) {
                format!("code {}: {}", ran.code, ran.stderr)
            } else if ran.code != 0 {
                if ran.stdout.contains("---- START: ERROR ----") {
                    return None;
                }
                format!("code {} and no reason", ran.code)
            } else {
                answered.fetch_add(1, Ordering::Relaxed);
                let results = Results::read_all(place.path(), "mechanism.res");
                let whole = results.steps.len() >= 4
                    && results.steps.iter().flatten().all(|x| x.is_finite());
                if whole {
                    return None;
                }
                "no whole answer".to_string()
            };
            let line = MECHANISM[..span.start()].lines().count();
            Some(format!("{kind}, line {line}, {edge}: {what}"))
        })
        .collect();
    assert!(answered.into_inner() > 100);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks that the shipped half axle has the same poses in millimetres, metres and inches, to a part in 1e9.
#[test]
fn other_units_give_the_same_answer() {
    let shipped =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson/reference.adm");
    let deck = std::fs::read_to_string(shipped).unwrap();
    let place = folder(&[("mm.adm", &deck)]);
    let commands = "\nfile/model=NAME\nEQUILIBRIUM/ERROR=1E-12, IMBALANCE=1E-9\nSFORCE/1, FUNCTION=300\nSFORCE/3, FUNCTION=4000\nSIM/STAT\nSTOP\n";
    let mut answers = Vec::new();
    for (name, to, length) in [
        ("mm", "mmks", 1.0),
        ("m", "mks", 1000.0),
        ("in", "inch,newton,kilogram", 25.4),
    ] {
        let file = format!("{name}.adm");
        if name != "mm" {
            let converted = Command::new(env!("CARGO_BIN_EXE_admire"))
                .current_dir(place.path())
                .args(["convert-units", "mm.adm", "--to", to, "-o", &file])
                .output()
                .unwrap();
            assert!(converted.status.success(), "{converted:?}");
        }
        std::fs::write(place.path().join("run.acf"), commands.replace("NAME", name)).unwrap();
        let ran = mdi_with(place.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        let results = Results::read(place.path(), &format!("{name}.res"));
        answers.push((results, length));
    }
    let (first, _) = &answers[0];
    let entities: Vec<_> = first
        .entities()
        .into_iter()
        .filter(|name| name.ends_with("_XFORM"))
        .collect();
    assert!(entities.len() >= 3, "{entities:?}");
    for (other, length) in &answers[1..] {
        for entity in &entities {
            for (component, scale) in [
                ("X", *length),
                ("Y", *length),
                ("Z", *length),
                ("PSI", 1.0),
                ("THETA", 1.0),
                ("PHI", 1.0),
            ] {
                let (a, b) = (
                    first.column(entity, component),
                    other.column(entity, component),
                );
                assert_eq!(a.len(), 1);
                let (a, b) = (a[0], b[0] * scale);
                let turned = (a - b).abs() - std::f64::consts::TAU;
                let apart = (a - b)
                    .abs()
                    .min(if scale == 1.0 { turned.abs() } else { f64::MAX });
                assert!(
                    apart <= 1e-9 * (1.0 + a.abs()),
                    "{entity} {component}: {a} and {b}, in units of {length} mm"
                );
            }
        }
    }
}

/// Checks the sine of 1e22 (Ng, Argument reduction for huge arguments: good to the last bit, 1992).
///
/// C libraries with pi to 64 bits get none of its digits right.
#[test]
fn angles_of_many_turns_keep_their_digits() {
    let turned = euler313(1e22, 0.0, 0.0);
    assert!(
        (turned[(1, 0)] + 0.852_200_849_767_188_8).abs() < 1e-15,
        "{turned}"
    );
}

/// Checks a rotated bushing with stiffnesses that differ by up to 1e12: `p = A K^-1 A' F`, each axis with its own precision.
///
/// The run must either report the remaining forces, or refuse and name the part, the direction and the stiffness.
#[test]
fn stiffnesses_may_be_apart_by_1e12() {
    let axes = euler313(0.7, 1.1, -0.4);
    let mut answered = 0;
    for soft in [1.0, 1e-2, 1e-3, 1e-7] {
        let along = Vec3::new(2e3, -30.0, 1.5 * soft);
        let expected = along.component_div(&Vec3::new(1e9, 1e3, soft));
        let force = axes * along;
        let deck = format!(
            "A block on an uneven bushing\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n\
             MARKER/1, PART=1, REULER=0.7, 1.1, -0.4\nMARKER/2, PART=1\nMARKER/9, PART=1, FLOATING\n\
             PART/2, MASS=1, CM=20, IP=100, 100, 100\nMARKER/20, PART=2, REULER=0.7, 1.1, -0.4\n\
             BUSHING/1, I=20, J=1, K=1E9, 1E3, {soft:?}, KT=1E12, 1E6, 1\n\
             VFORCE/1, I=20, JFLOAT=9, RM=2, FX={:?}\\, FY={:?}\\, FZ={:?}\nRESULTS/FORMATTED, XRF\nEND\n",
            force.x, force.y, force.z
        );
        let acf = "\nfile/model=uneven\nSIM/STAT\nSTOP\n";
        let place = folder(&[("uneven.adm", &deck), ("run.acf", acf)]);
        let ran = mdi_with(place.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
        let message = crate::run::text(place.path(), "uneven.msg");
        let n = axes.column(2);
        let direction = format!(
            "the ground direction ({:.4}, {:.4}, {:.4})",
            -n.x, -n.y, -n.z
        );
        let held = |how: &str| message.contains(&format!("PART/2 {how} along {direction}"));
        if ran.code == 3 {
            assert!(held("has almost no stiffness"), "{direction}: {message}");
            let figures =
                "its stiffness of 1.0e-3, in units of the deck, is 1e-12 of the largest stiffness";
            assert!(message.contains(figures), "{message}");
            continue;
        }
        assert_eq!(ran.code, 0, "{}", ran.stdout);
        if soft < 1e-5 {
            // At 1e-16 of the largest stiffness and a force below IMBALANCE, the block stays in place along this axis, and a message states
            // this.
            assert!(held("is free to translate"), "{direction}: {message}");
            continue;
        }
        answered += 1;
        let results = Results::read(place.path(), "uneven.res");
        let last = |component| *results.column("PART_2_XFORM", component).last().unwrap();
        let p = axes.transpose() * Vec3::new(last("X"), last("Y"), last("Z"));
        // The soft displacement of 1.5 mm has 15 digits; the stiff one, 2e-6 mm, has the remaining digits.
        for (axis, within) in [(2, 1e-9), (1, 1e-9), (0, 1e-14)] {
            let apart = (p[axis] - expected[axis]).abs();
            assert!(apart < within, "{soft}: {p} instead of {expected}");
        }
        assert!(message.contains("Recomputed force balance"), "{message}");
    }
    assert!(answered >= 2, "{answered}");
}
