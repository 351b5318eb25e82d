//! Every element and constraint in one deck: tangent and sensitivities compared with finite differences, and balance of every part.

use std::fmt::Write;

use admire_solver::model::Model;
use admire_solver::statics::{Solver, StaticSettings};
use admire_solver::system::System;

use crate::balance;
use crate::deck;
use crate::derivatives::{check_slot, check_tangent};

/// Deck of parts, each on a bushing to ground, with elements that connect them.
struct Deck {
    text: String,
    parts: u32,
}

impl Deck {
    fn new() -> Self {
        Self {
            text: "every element\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\n\
                   PART/1, GROUND\nMARKER/1, PART=1\nACCGRAV/IGRAV=900, JGRAV=-400, KGRAV=-9806.65\n"
                .to_string(),
            parts: 1,
        }
    }

    fn origin(id: u32) -> [f64; 3] {
        let k = f64::from(id);
        [100.0 * k, 30.0 * (k * 1.7).sin(), 40.0 * (k * 0.9).cos()]
    }

    /// Adds a part on a bushing: markers 100 id (CM), +1 (bushing I), +2 (bushing J on ground).
    fn part(&mut self) -> u32 {
        self.parts += 1;
        let id = self.parts;
        let [x, y, z] = Self::origin(id);
        let (gx, gy, gz) = (x + 20.0, y - 10.0, z + 15.0);
        writeln!(
            self.text,
            "PART/{id}, QG={x},{y},{z}, MASS={mass}, CM={cm}, IP=4000,5000,6000\n\
             MARKER/{cm}, PART={id}, QP=11,-7,5\n\
             MARKER/{i}, PART={id}, QP=20,-10,15, REULER=30D,20D,10D\n\
             MARKER/{j}, PART=1, QP={gx},{gy},{gz}, REULER=25D,22D,13D\n\
             BUSHING/{id}, I={i}, J={j}, K=200,300,150, KT=3e5,2e5,4e5, FORCE=5,-3,8, TORQUE=100,50,-80",
            mass = 2.0 + f64::from(id % 3),
            cm = 100 * id,
            i = 100 * id + 1,
            j = 100 * id + 2,
        )
        .unwrap();
        id
    }

    /// Adds a marker at a position in ground, on a part. The parts are unrotated at the design position.
    fn marker(&mut self, part: u32, number: u32, at: [f64; 3], reuler: &str) -> u32 {
        let o = if part == 1 {
            [0.0; 3]
        } else {
            Self::origin(part)
        };
        let id = if part == 1 {
            10 + number
        } else {
            100 * part + number
        };
        writeln!(
            self.text,
            "MARKER/{id}, PART={part}, QP={},{},{}, REULER={reuler}",
            at[0] - o[0],
            at[1] - o[1],
            at[2] - o[2]
        )
        .unwrap();
        id
    }

    /// Adds two parts with coincident markers between them.
    fn pair(&mut self, reuler_i: &str, reuler_j: &str) -> (u32, u32) {
        let (a, b) = (self.part(), self.part());
        let (p, q) = (Self::origin(a), Self::origin(b));
        let at = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]) + 12.0);
        (
            self.marker(a, 50, at, reuler_i),
            self.marker(b, 50, at, reuler_j),
        )
    }

    fn add(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn model(&self) -> Model {
        deck::read(&format!("{}END\n", self.text))
    }
}

fn forces() -> Deck {
    let mut deck = Deck::new();
    let turned = "40D,15D,-20D";
    let (i, j) = deck.pair(turned, "38D,12D,-25D");
    let stiffness: Vec<String> = (0..36)
        .map(|k| {
            let (r, c) = (k % 6, k / 6);
            let scale: f64 = [30.0, 3e4][usize::from(r > 2)] * [1.0, 30.0][usize::from(c > 2)];
            format!(
                "{}",
                scale
                    * if r == c {
                        10.0
                    } else {
                        1.0 / (1.0 + f64::from(k))
                    }
            )
        })
        .collect();
    deck.add(&format!(
        "FIELD/1, I={i}, J={j}, KMATRIX={}\n, LENGTH=1,2,-1,0.01,-0.02,0.03, FORCE=3,4,5,60,70,80",
        stiffness.join("\n,")
    ));
    let (i, j) = deck.pair("0D,0D,0D", "5D,3D,0D");
    deck.add(&format!(
        "BEAM/1, I={i}, J={j}, LENGTH=8, AREA=2, IXX=3, IYY=1.5, IZZ=2.5, EMODULUS=2e4, GMODULUS=8e3, ASY=1.2, ASZ=1.1"
    ));
    let (a, b) = (deck.part(), deck.part());
    let (i, j) = (100 * a + 1, 100 * b);
    deck.add(&format!(
        "SPRINGDAMPER/1, I={i}, J={j}, TRANSLATIONAL, K=20, LENGTH=90, FORCE=30"
    ));
    let (i, j) = deck.pair(turned, turned);
    deck.add(&format!(
        "SPRINGDAMPER/2, I={i}, J={j}, ROTATIONAL, KT=3e4, ANGLE=5D, TORQUE=300"
    ));
    let (i, j) = (100 * a, 100 * b + 1);
    deck.add(&format!(
        "SFORCE/1, I={i}, J={j}, TRANSLATIONAL, FUNCTION=25-3*(DM({i},{j})-95)"
    ));
    let (i, j) = deck.pair(turned, turned);
    deck.add(&format!(
        "SFORCE/2, I={i}, J={j}, ROTATIONAL, FUNCTION=-2e4*(AZ({i},{j})-0.1)+50"
    ));
    deck.add(&format!("SFORCE/3, I={i}, J={j}, TRANSLATIONAL, ACTIONONLY, FUNCTION=40+0.5*DX({i},{j},{j})*DX({i},{j},{j})"));
    let (i, j) = deck.pair(turned, "10D,50D,-20D");
    let c = deck.part();
    deck.add(&format!(
        "MARKER/{f}, PART={p}, FLOATING\nGFORCE/1, I={i}, JFLOAT={f}, RM={rm}\n, FX=-2*DX({i},{j},{rm})+VARVAL(1)\\\n, FY=30*SIN(PSI({i},{j}))\\\n, FZ=12\\\n, TX=200\\\n, TY=-1E3*AY({i},{j})\\\n, TZ=150*PITCH({i},{j})",
        f = 100 * (j / 100) + 60,
        p = j / 100,
        rm = 100 * c + 1,
    ));
    let (i, j) = deck.pair(turned, turned);
    deck.add(&format!(
        "MARKER/{f}, PART={p}, FLOATING\nVFORCE/1, I={i}, JFLOAT={f}, RM={i}, FX=20\\, FY=-10\\, FZ=5*INCANG({i},1,{j})\n\
         MARKER/{g}, PART=1, FLOATING\nVTORQUE/1, I={i}, JFLOAT={g}, RM=1, TX=500\\, TY=-800\\, TZ=BUSH({b},0,6,{i})/10",
        f = 100 * (j / 100) + 60,
        p = j / 100,
        g = 9,
        b = j / 100,
    ));
    let (i, j) = deck.pair(turned, turned);
    let (a, b) = (i / 100, deck.part());
    let multi: Vec<String> = (0..144)
        .map(|k| {
            let (r, c) = (k % 12, k / 12);
            let scale = [5.0, 5e3][usize::from(r % 6 > 2)] * [1.0, 30.0][usize::from(c % 6 > 2)];
            format!(
                "{}",
                scale
                    * if r == c {
                        10.0
                    } else {
                        1.0 / (1.0 + f64::from(k))
                    }
            )
        })
        .collect();
    deck.add(&format!(
        "MATRIX/1, FULL=CORDER, ROWS=12, COLUMNS=12, VALUES={}\n\
         MATRIX/2, FULL=CORDER, ROWS=12, COLUMNS=1, VALUES=1,2,3,0,0,0,4,5,6,0.1,0,0\n\
         MATRIX/3, FULL=CORDER, ROWS=12, COLUMNS=1, VALUES=1,2,3,4,5,6,7,8,9,10,11,12\n\
         NFORCE/1, I={},{}, J={j}, KMATRIX=1, LENGTH=2, FORCE=3",
        multi.join("\n,"),
        100 * a + 1,
        100 * b + 1,
    ));
    deck.add("VARIABLE/1, IC=3, FUNCTION=10+SIN(VARVAL(1))+0.2*DZ(200,300)");
    deck.add("VARIABLE/2, FUNCTION=VARVAL(1)*2+SFORCE(1,1,2,0)+FZ(201,202,200)+JOINT(1,0,7,0)*0+SPDP(2,0,8,1)");
    deck.add("SFORCE/4, I=300, J=200, TRANSLATIONAL, FUNCTION=0.05*VARVAL(2)+DIF(1)");
    deck.add("DIFF/1, IC=1, FUNCTION=VARVAL(1)-3*DIF(1)");
    deck.add("DIFF/2, IC=2, STATIC_HOLD, FUNCTION=DIF(1)");
    deck.add("SFORCE/5, I=300, J=200, TRANSLATIONAL, FUNCTION=DIF(2)+DIF1(2)");
    deck.add(
        "MARKER/7, PART=1, QP=1,2,3\nJOINT/1, SPHERICAL, I=203, J=8\nMARKER/203, PART=2, QP=0,0,0",
    );
    let [x, y, z] = Deck::origin(2);
    deck.add(&format!("MARKER/8, PART=1, QP={x},{y},{z}"));
    deck.add("POINT_MASS/1, MASS=1.5, CM=5, QG=50,60,70\nMARKER/5, POINT_MASS=1\nSPRINGDAMPER/9, I=5, J=200, TRANSLATIONAL, K=5, LENGTH=60\nSPRINGDAMPER/10, I=5, J=300, TRANSLATIONAL, K=5, LENGTH=60\nSPRINGDAMPER/11, I=5, J=1, TRANSLATIONAL, K=5, LENGTH=60");
    deck
}

fn constraints() -> Deck {
    let mut deck = Deck::new();
    let same = "40D,15D,-20D";
    for (id, kind) in (1..).zip([
        "SPHERICAL",
        "REVOLUTE",
        "TRANSLATIONAL",
        "CYLINDRICAL",
        "PLANAR",
        "FIXED",
        "HOOKE",
        "CONVEL",
        "SCREW, PITCH=5",
        "RACKPIN, PD=30",
    ]) {
        // Rack and pinion are at right angles, with xi along zj.
        let (turned_i, turned_j) = match kind {
            "RACKPIN, PD=30" => ("180D,90D,90D", "0D,0D,0D"),
            _ => (same, same),
        };
        let (i, j) = deck.pair(turned_i, turned_j);
        deck.add(&format!("JOINT/{id}, {kind}, I={i}, J={j}"));
    }
    let (i, j) = deck.pair("0D,90D,0D", "0D,0D,0D");
    deck.add(&format!("JOINT/11, UNIVERSAL, I={i}, J={j}"));
    for (id, kind) in (1..).zip([
        "ATPOINT",
        "INLINE",
        "INPLANE",
        "ORIENTATION",
        "PARALLEL_AXES",
    ]) {
        let (i, j) = deck.pair(same, same);
        deck.add(&format!("JPRIM/{id}, {kind}, I={i}, J={j}"));
    }
    let (i, j) = deck.pair("0D,90D,0D", "0D,0D,0D");
    deck.add(&format!("JPRIM/6, PERPENDICULAR, I={i}, J={j}"));
    deck.add("COUPLER/1, JOINTS=3,2, TYPE=T:R, SCALES=1,7");
    deck.add("MOTION/1, JOINT=4, TRANSLATIONAL, FUNCTION=2+TIME");
    deck.add("MOTION/2, JOINT=4, ROTATIONAL, FUNCTION=3D");
    for (k, axis) in ["X", "Y", "Z", "B1", "B2", "B3"].iter().enumerate() {
        if k % 3 == 0 {
            deck.pair(same, "45D,15D,-20D");
        }
        let (i, j) = (100 * (deck.parts - 1) + 50, 100 * deck.parts + 50);
        deck.add(&format!(
            "MOTION/{}, I={i}, J={j}, {axis}, FUNCTION={}D*5",
            k + 3,
            0.5 * k as f64 - 0.7
        ));
    }
    let (a, b) = (deck.part(), deck.part());
    let (i, j) = (100 * a, 100 * b);
    deck.add(&format!(
        "GCON/1, FUNCTION=DM({i},{j})-104.5+0.2*AX({i},{j})"
    ));
    // Two gears on one carrier.
    let (c, a, b) = (deck.part(), deck.part(), deck.part());
    let [x, y, z] = Deck::origin(a);
    let (pa, pb) = ([x, y, z], [x + 60.0, y, z]);
    let (ia, ja) = (
        deck.marker(a, 50, pa, "0D,0D,0D"),
        deck.marker(c, 50, pa, "0D,0D,0D"),
    );
    let (ib, jb) = (
        deck.marker(b, 50, pb, "0D,0D,0D"),
        deck.marker(c, 51, pb, "0D,0D,0D"),
    );
    let cv = deck.marker(c, 52, [x + 20.0, y, z], "0D,-90D,0D");
    deck.add(&format!(
        "JOINT/21, REVOLUTE, I={ia}, J={ja}\nJOINT/22, REVOLUTE, I={ib}, J={jb}\nGEAR/1, JOINTS=21,22, CV={cv}"
    ));
    deck
}

fn examine(deck: &Deck) {
    let model = deck.model();
    let checked = System::compile(&model);
    assert!(!checked.has_errors(), "{:#?}", checked.diagnostics);
    let system = checked.value;
    let (parameters, mut state) = (system.parameters(), system.state());
    let mut solver = Solver::new(&system);
    let settings = StaticSettings::tight();
    let report = solver
        .solve(&system, &parameters, &mut state, &settings)
        .unwrap_or_else(|e| panic!("{e}: {e:#?}"));
    println!(
        "{} unknowns, {} iterations, {:.1e}, {:?} {:?}",
        system.unknowns(),
        report.iterations,
        report.imbalance,
        report.redundant,
        report.free_motions
    );
    assert!(report.redundant.is_empty() && report.free_motions.is_empty());
    balance::check(&model, &system, &parameters, &state, &report);
    check_tangent(&system, &parameters, &state, 1e-5);
    let mut tangent = solver.tangent(&system, &parameters, &state).unwrap();
    let mut worst = (0.0, String::new());
    for slot in system.catalogue().slots() {
        if parameters.get(slot).is_nan() {
            continue;
        }
        let info = system.catalogue().info(slot);
        // Ids in functions are numbers of the text as well.
        let error = check_slot(
            &system,
            &mut solver,
            &parameters,
            &state,
            slot,
            &mut tangent,
        );
        if error > 1e-5 {
            println!("{} {error}", info.address);
        }
        if error > worst.0 {
            worst = (error, info.address.to_string());
        }
    }
    println!("{} numbers, worst {worst:?}", system.catalogue().len());
    assert!(worst.0 < 1e-5, "{worst:?}");
}

#[test]
fn each_joint_alone() {
    let same = "40D,15D,-20D";
    let joints = [
        "REVOLUTE",
        "TRANSLATIONAL",
        "CYLINDRICAL",
        "PLANAR",
        "FIXED",
        "HOOKE",
        "CONVEL",
        "SCREW, PITCH=5",
    ];
    let motions = ["X", "Y", "Z", "B1", "B2", "B3"];
    for kind in joints.iter().chain(&motions) {
        let mut deck = Deck::new();
        let (i, j) = deck.pair(same, same);
        if motions.contains(kind) {
            deck.add(&format!("MOTION/1, I={i}, J={j}, {kind}, FUNCTION=0.02"));
        } else {
            deck.add(&format!("JOINT/1, {kind}, I={i}, J={j}"));
        }
        let model = deck.model();
        let system = System::compile(&model).value;
        let (parameters, mut state) = (system.parameters(), system.state());
        let settings = StaticSettings::tight();
        let report = Solver::new(&system).solve(&system, &parameters, &mut state, &settings);
        println!("{kind} {:?}", report.map(|r| r.iterations));
        let kind = kind.to_string();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            check_tangent(&system, &parameters, &state, 1e-6);
        }));
        assert!(result.is_ok(), "{kind}");
    }
}

#[test]
fn every_force() {
    examine(&forces());
}

#[test]
fn every_constraint() {
    examine(&constraints());
}
