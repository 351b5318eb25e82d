//! The rig of Adams/Car as parts of a deck: a table below each wheel, and a tyre between table and wheel. `admire kc` must find the same wheels
//! without tables and tyres.
//!
//! The loads are implemented independently, from the height of the table: the tyre measures its distance to the road, and the heading is an
//! angle.

use admire_kc::{Drive, Inputs, Side, Variant};
use admire_session::backend::{compile, tight_settings};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_solver::statics::Solver;
use admire_syntax::Dataset;
use admire_syntax::text::Source;

use crate::axles::{Axle, DOUBLE_WISHBONE, double_wishbone};

const RADIUS: f64 = 300.0;
const RATE: f64 = 200.0;
const HELD: Variant = Variant {
    height_held: true,
    steering_locked: true,
};

/// Inputs of the rig for both wheels.
#[derive(Clone, Copy, Default)]
struct Case {
    /// Rise of the tables above the height at which the tyres touch them without load at design.
    table: [f64; 2],
    /// Forces on each wheel: to the right and rearward at the contact patch, and forward at the wheel centre.
    lateral: [f64; 2],
    braking: [f64; 2],
    driving: [f64; 2],
}

/// Returns the statements of one table with its tyre. Ids begin with `base`. Part 1 is the ground, and `part` carries the wheel with its centre
/// `centre`. `inboard` is a marker on the spin axis, 100 mm inboard.
fn table(side: Side, case: &Case) -> String {
    let k = side.index();
    let [part, base] = [[13, 9000], [23, 9100]][k];
    let (centre, inboard) = (10 * part, 10 * part + 4);
    let y = side.outboard_sign() * 760.0;
    let top = 330.0 - RADIUS;
    let out = side.outboard_sign();
    let Case {
        table,
        lateral,
        braking,
        driving,
    } = case;
    let (rise, fy, fx, drive) = (table[k], lateral[k], braking[k], driving[k]);
    let id = |n: u32| base + n;
    let v = |n: u32| format!("VARVAL({})", base + n);
    let (ox, oy, oz, c, r, n, l, angle) = (v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8));
    let (wx, wy, wz) = (v(9), v(10), v(11));
    let (fx_at, fy_at) = (v(12), v(13));
    let mut text = format!(
        "PART/{base}, MASS = 1, CM = {base}, IP = 1, 1, 1
MARKER/{base}, PART = {base}, QP = -267, {y}, {top}
MARKER/{}, PART = 1, QP = -267, {y}, {top}
MARKER/{}, PART = {base}, FLOATING
JOINT/{base}, TRANSLATIONAL, I = {base}, J = {}
MOTION/{base}, JOINT = {base}, TRANSLATIONAL, FUNCTION = {rise}
",
        id(1),
        id(2),
        id(1),
    );
    let mut variable = |n: u32, function: String| {
        text += &format!("VARIABLE/{}, FUNCTION = {function}\n", base + n);
    };
    variable(1, format!("DX({centre},{inboard},1)/100"));
    variable(2, format!("DY({centre},{inboard},1)/100"));
    variable(3, format!("DZ({centre},{inboard},1)/100"));
    variable(4, format!("SQRT({ox}**2+{oy}**2)"));
    variable(5, format!("DZ({centre},{base},1)/{c}"));
    variable(6, format!("{RATE}*({RADIUS}-{r})*{c}"));
    variable(7, format!("MIN({r},{RADIUS})"));
    variable(8, format!("ATAN2({out}*{oy},{out}*{ox})"));
    variable(9, format!("{oz}*{ox}/{c}"));
    variable(10, format!("{oz}*{oy}/{c}"));
    variable(11, format!("-{c}"));
    variable(12, format!("{fy}*COS({angle})+{fx}*SIN({angle})"));
    variable(13, format!("{fy}*SIN({angle})-{fx}*COS({angle})"));
    text += &format!(
        "GFORCE/{base}, I = {centre}, JFLOAT = {}, RM = 1
, FX = {fx_at}-{drive}*SIN({angle})\\
, FY = {fy_at}+{drive}*COS({angle})\\
, FZ = {n}\\
, TX = {l}*({wy}*{n}-{wz}*{fy_at})\\
, TY = {l}*({wz}*{fx_at}-{wx}*{n})\\
, TZ = {l}*({wx}*{fy_at}-{wy}*{fx_at})
",
        id(2)
    );
    text
}

/// Solves the deck with both tables. Returns centre and outboard spin axis of both wheels, and the normal forces of the tyres.
fn solved(case: &Case) -> ([(Vec3, Vec3); 2], [f64; 2]) {
    let deck = double_wishbone();
    let deck = deck.trim_end().strip_suffix("END").unwrap();
    let tables = Side::BOTH.map(|side| table(side, case)).concat();
    // The tables replace the motions of the wheel centres.
    let travel = |deck: &str, motion: &str| {
        let (before, after) = deck.split_once(motion).unwrap();
        let (_, after) = after.split_once("FUNCTION = 0").unwrap();
        format!("{before}{after}")
    };
    let deck = travel(&travel(deck, "MOTION/2\n"), "MOTION/3\n");
    let deck = format!("{deck}{tables}END\n");
    let dataset = Dataset::parse(Source::new("rig.adm", deck.as_bytes())).value;
    let lowered = Model::lower(&dataset);
    let wrong = lowered.diagnostics.iter();
    let wrong: Vec<_> = wrong
        .filter(|d| d.severity == admire_syntax::diagnostic::Severity::Error)
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    let model = lowered.value;
    let system = compile(&model).unwrap_or_else(|why| panic!("{why}"));
    let mut state = system.state();
    Solver::new(&system)
        .solve(
            &system,
            &system.parameters(),
            &mut state,
            &tight_settings(&system),
        )
        .unwrap_or_else(|why| panic!("{why}"));
    let place = |id: u32| {
        let frame = &model.markers[model.marker(id).unwrap().0];
        state.poses[frame.part.0]
            .compose(&Pose {
                p: frame.qp,
                R: frame.R,
            })
            .p
    };
    let wheels = [(130, 134), (230, 234)].map(|(centre, inboard)| {
        let (p, q) = (place(centre), place(inboard));
        (p, (p - q) / 100.0)
    });
    let load = [9000, 9100].map(|id| place(id).z);
    let load = [0, 1].map(|k| {
        let (centre, o): (Vec3, Vec3) = wheels[k];
        let tilt = o.x.hypot(o.y);
        RATE * (RADIUS * tilt - (centre.z - load[k]))
    });
    (wheels, load)
}

#[test]
fn admire_kc_finds_the_wheels_of_a_whole_rig() {
    let axle = Axle::new(&double_wishbone(), DOUBLE_WISHBONE);
    let mut bench = axle.bench();
    let cases = [
        Case {
            table: [25.0; 2],
            ..Case::default()
        },
        Case {
            table: [70.0, 40.0],
            ..Case::default()
        },
        // The tyres are in tension.
        Case {
            table: [-90.0, -110.0],
            lateral: [300.0, -200.0],
            ..Case::default()
        },
        Case {
            table: [30.0, 20.0],
            lateral: [3000.0, 2500.0],
            ..Case::default()
        },
        Case {
            table: [20.0, 20.0],
            lateral: [-1500.0, 1000.0],
            braking: [2500.0, 1500.0],
            ..Case::default()
        },
        Case {
            table: [20.0, 30.0],
            driving: [2000.0, 2500.0],
            ..Case::default()
        },
    ];
    let (mut far, mut pulls) = (0.0, 0);
    for case in &cases {
        let (wheels, tyres) = solved(case);
        let drives = case.driving != [0.0; 2];
        let mut inputs = Inputs {
            vertical_at_patch: true,
            plane_at_patch: !drives,
            ..Inputs::default()
        };
        for k in 0..2 {
            inputs.height[k] = wheels[k].0.z - 330.0;
            let along = case.braking[k] - case.driving[k];
            inputs.loads[k] = [along, case.lateral[k], 0.0, 0.0];
        }
        let mut chain = bench.chain(HELD).unwrap();
        let seen = bench
            .observe(HELD, &mut chain, &inputs, Some(&Drive::default()), "rig")
            .unwrap();
        let contacts = seen.axle.contacts().unwrap();
        for k in 0..2 {
            let wheel = seen.axle.wheels[k].unwrap().wheel;
            let (centre, spin) = wheels[k];
            let apart = (wheel.centre - centre).norm();
            far = f64::max(far, apart);
            assert!(apart < 1e-9, "{apart:e} mm");
            assert!((wheel.spin - spin).norm() < 1e-11);
            assert!((seen.load[k] - tyres[k]).abs() < 1e-6, "{}", seen.load[k]);
            pulls += usize::from(tyres[k] < 0.0);
            // The contact point lies on the table.
            let road = 330.0 - RADIUS + case.table[k];
            assert!((contacts[k].z - road).abs() < 1e-9, "{}", contacts[k].z);
        }
    }
    println!("{far:.1e} mm");
    assert_eq!(pulls, 2);
}
