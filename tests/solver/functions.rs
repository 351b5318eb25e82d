//! Every natively solved function of the grammar: its derivatives with respect to the state, compared with finite differences of the residual.

use std::collections::BTreeSet;
use std::fmt::Write;

use admire_solver::statics::{Solver, StaticSettings, Tangent};
use admire_solver::system::System;
use admire_syntax::grammar::{FUNCTIONS, FunctionDef, Solved};

use crate::deck::{HEAD, read};
use crate::differences::{along, richardson};

/// Returns parts on bushings, and between them one element of every kind that a function can read.
fn elements() -> String {
    let mut deck = format!("{HEAD}ACCGRAV/KGRAV=-9806.65\n");
    for id in 2..7 {
        let (x, y, z) = (90 * id, 25 * (id % 3), 40 - 11 * id);
        writeln!(
            deck,
            "PART/{id}, QG={x},{y},{z}, MASS={id}, CM={id}00, IP=4000,5000,6000\nMARKER/{id}00, PART={id}, QP=7,-3,5\n\
             MARKER/{id}01, PART={id}, QP=20,-10,15, REULER=30D,20D,10D\nMARKER/{id}03, PART={id}, QP=5,9,-8, REULER=25D,28D,14D\n\
             MARKER/{id}05, PART={id}, REULER=30D,20D,10D\nMARKER/{id}06, PART={id}, QP={dx},3,7, REULER=30D,20D,10D\n\
             MARKER/{id}02, PART=1, QP={},{},{}, REULER=25D,22D,13D\n\
             BUSHING/{id}, I={id}01, J={id}02, K=200,300,150, KT=3E5,2E5,4E5, FORCE=5,-3,8",
            x + 20,
            y - 10,
            z + 15,
            dx = if id % 2 == 0 { 90 } else { 0 },
        )
        .unwrap();
    }
    let diagonal = |n: usize, values: [f64; 6]| -> String {
        let all = (0..n * n).map(|k| {
            let own = if k % (n + 1) == 0 {
                values[(k / (n + 1)) % 6]
            } else {
                0.0
            };
            format!("{}", own + 0.3 / (1.0 + k as f64))
        });
        all.collect::<Vec<_>>().join("\n,")
    };
    let stiff = [20.0, 30.0, 15.0, 3e4, 2e4, 4e4];
    let six = diagonal(6, stiff);
    writeln!(
        deck,
        "BUSHING/1, I=203, J=303, K=20,30,40, KT=1E4,2E4,3E4, FORCE=500,0,0\n\
         BEAM/1, I=203, J=303, LENGTH=80, AREA=2, IXX=3, IYY=1.5, IZZ=2.5, EMODULUS=200, GMODULUS=80\n\
         FIELD/1, I=203, J=303, KMATRIX={six}\n, LENGTH=1,2,-1,0,0,0, FORCE=3,4,5,60,70,80\n\
         SPRINGDAMPER/1, I=203, J=303, TRANSLATIONAL, K=20, LENGTH=70\n\
         SFORCE/1, I=203, J=303, TRANSLATIONAL, FUNCTION=25-3*(DM(203,303)-95)\n\
         MARKER/399, PART=3, FLOATING\n\
         GFORCE/1, I=203, JFLOAT=399, RM=401, FX=-2*DX(203,303,401)\\, FY=30\\, TX=200\\, TZ=100*AZ(203,303)\n\
         VFORCE/1, I=203, JFLOAT=399, RM=303, FX=20\\, FY=-DX(203,303)\n\
         VTORQUE/1, I=203, JFLOAT=399, RM=303, TX=500\\, TY=-8*DZ(203,303)\n\
         MATRIX/1, FULL=RORDER, ROWS=6, COLUMNS=6, VALUES={six}\nNFORCE/1, I=203, J=303, KMATRIX=1\n\
         JOINT/1, TRANSLATIONAL, I=406, J=505\nMOTION/1, JOINT=1, FUNCTION=1.5\nJPRIM/1, INPLANE, I=600, J=500\n\
         FRICTION/1, JOINT=1, REACTION_ARM=20, INITIAL_OVERLAP=30, MU_STATIC=0.3, MU_DYNAMIC=0.2, INACTIVE=STATIC\n\
         SPLINE/1, X=0,1,2,3,4, Y=0,1,4,2,1\nVARIABLE/1, FUNCTION=0.8+0.002*DX(200,300)\nVARIABLE/2, FUNCTION=DZ(303)\n\
         ARRAY/1, U, SIZE=2, VARIABLES=2,1\nDIFF/1, IC=1, FUNCTION=DY(303)-3*DIF(1)\n\
         DIFF/2, IC=2, STATIC_HOLD, FUNCTION=DX(303)*DIF(2)\n\
         PINPUT/1, VARIABLES=2\nPOUTPUT/1, VARIABLES=1\nSENSOR/1, GE, VALUE=1, ERROR=0.1, FUNCTION=TIME",
    )
    .unwrap();
    deck
}

const FORCES_AT_MARKERS: [&str; 8] = ["FX", "FY", "FZ", "FM", "TX", "TY", "TZ", "TM"];

/// Returns true for functions that do not depend on the state: constants, whole numbers, rates and friction (zero in statics), and stored values
/// of sensors.
fn is_flat(def: &FunctionDef) -> bool {
    let rate = ["VM", "VR", "VX", "VY", "VZ", "WM", "WX", "WY", "WZ"].contains(&def.name)
        || def.name.starts_with("ACC")
        || def.name.starts_with("WDT");
    let constant = ["TIME", "MODE", "PI", "RTOD", "DTOR", "SENVAL", "FRICTION"].contains(&def.name);
    let whole = ["AINT", "ANINT", "INT", "NINT"].contains(&def.name);
    rate || constant || whole
}

/// Returns an argument that depends on the state, with a value near the given one.
fn follows(value: f64, k: usize) -> String {
    let axis = ["DX", "DY", "DZ"][k % 3];
    let marker = 201 + 100 * (k % 4);
    format!("({value}+0.0003*({axis}({marker},602)+7*{axis}({marker},500)*0.1))")
}

/// Returns the value of a real argument that is in the domain of every function, and away from kinks.
fn value(name: &str, k: usize) -> f64 {
    match name {
        "x" => 0.6 + 0.07 * k as f64,
        "y" => 0.35,
        "xdot" => 0.2,
        "x0" => 0.1,
        "x1" => 1.4,
        "x2" => 1.9,
        "d" | "dx" => 0.9,
        "w" | "a" | "cmax" => 1.3,
        _ => 0.7 + 0.4 * k as f64,
    }
}

/// Returns calls of a function with all forms of its whole-number arguments.
fn calls(def: &FunctionDef) -> Vec<String> {
    if def.name == "IF" {
        let branches = [follows(1.0, 0), follows(2.0, 1), follows(3.0, 2)].join(",");
        return vec![
            format!("IF({}: {branches})", follows(-0.9, 1)),
            format!("IF({}: {branches})", follows(0.9, 1)),
        ];
    }
    if def.count.max == Some(0) {
        return vec![format!("{}+{}", def.name, follows(1.0, 0))];
    }
    let names = def.arguments.split([',', '[', ']']);
    let names: Vec<&str> = names.map(str::trim).filter(|n| !n.is_empty()).collect();
    let choices: Vec<Vec<String>> = names
        .iter()
        .enumerate()
        .filter(|(_, name)| **name != "...")
        .map(|(k, name)| {
            let all: &[&str] = match *name {
                "i" => &["203"],
                // Without j, the function means all forces at i.
                "j" if FORCES_AT_MARKERS.contains(&def.name) => &["303", "0"],
                "j" => &["303"],
                "k" if def.name == "INCANG" => &["401"],
                "k" | "rm" => &["0", "401"],
                "l" => &["1"],
                "at_marker" => &["203", "303"],
                "id" if def.name == "DIF1" => &["2"],
                "id" | "method" | "component" if def.name != "ORIENT" => &["1"],
                "comp" => &["1", "2", "3", "4", "5", "6", "7", "8"],
                "jflag" | "iord" => &["0", "1"],
                "component" => &["1", "2", "3"],
                "index" => return (1..=26).map(|index| format!("{index}")).collect(),
                "z" => &["0"],
                "type" => return (1..25).chain([27]).map(|t| format!("{t}")).collect(),
                _ => return vec![follows(value(name, k), k)],
            };
            all.iter().map(ToString::to_string).collect()
        })
        .collect();
    let mut out = vec![String::new()];
    for choice in &choices {
        out = out
            .iter()
            .flat_map(|call| choice.iter().map(move |c| format!("{call},{c}")))
            .collect();
    }
    out.iter()
        .map(|arguments| format!("{}({})", def.name, &arguments[1..]))
        .collect()
}

/// Returns number `k` of a fixed sequence between -1 and 1.
fn spread(k: usize) -> f64 {
    let x = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
    x as f64 / f64::from(1_u32 << 23) - 1.0
}

/// Change of a function along one motion of all unknowns, by the tangent and by differences of the residual.
struct Change {
    call: String,
    flat: bool,
    by_differences: f64,
    error: f64,
    /// True if the differences halve with their step, as for a magnitude at its zero, which has no derivative.
    kink: bool,
}

fn changes(calls: &[(String, bool)]) -> Vec<Change> {
    let mut deck = elements();
    for (k, (call, _)) in calls.iter().enumerate() {
        // A VARIABLE that reads itself is an unknown with a row of its own.
        let id = 1000 + k;
        writeln!(deck, "VARIABLE/{id}, FUNCTION={call}+0*VARVAL({id})").unwrap();
    }
    let model = read(&format!("{deck}END\n"));
    let compiled = System::compile(&model);
    assert!(!compiled.has_errors(), "{:#?}", compiled.diagnostics);
    let system = compiled.value;
    let (parameters, mut state) = (system.parameters(), system.state());
    Solver::new(&system)
        .solve(&system, &parameters, &mut state, &StaticSettings::tight())
        .unwrap();
    let n = system.unknowns();
    let bodies = system.equations_start();
    let scale = |k: usize| match k {
        k if k < bodies && k % 6 < 3 => 1.0,
        k if k < bodies => 0.01,
        _ => 1.0,
    };
    let dx: Vec<f64> = (0..n).map(|k| spread(k) * scale(k)).collect();
    let (coarse, fine) = along(&system, &parameters, &state, &dx);
    let dg = richardson(&coarse, &fine);
    // The tangent converts the change of the residual back to the motion. The deviation at a variable is the error of its row.
    let mut back = dg.clone();
    Tangent::new(&system, &parameters, &state)
        .unwrap()
        .respond(&mut back);
    let row = |id: usize| {
        let name = format!("VARIABLE/{id}");
        (bodies..n)
            .find(|k| {
                let shown = system.equation_name(*k);
                shown.split([' ', '\'']).any(|word| word == name)
            })
            .unwrap_or_else(|| panic!("{name} is no unknown"))
    };
    calls
        .iter()
        .enumerate()
        .map(|(number, (call, flat))| {
            let k = row(1000 + number);
            Change {
                call: call.clone(),
                flat: *flat,
                // The row of a variable is the variable minus its function.
                by_differences: dx[k] - dg[k],
                error: -back[k] - dx[k],
                kink: (coarse[k] - fine[k]).abs() > 0.2 * (dx[k] - fine[k]).abs(),
            }
        })
        .collect()
}

#[test]
fn every_function_has_the_derivative_of_its_differences() {
    let calls: Vec<(String, bool)> = FUNCTIONS
        .iter()
        .filter(|def| matches!(def.solved, Solved::Native(_)))
        .flat_map(|def| calls(def).into_iter().map(|call| (call, is_flat(def))))
        .collect();
    let changes = changes(&calls);
    let mut worst = (0.0, String::new());
    let mut kinks = Vec::new();
    let (mut followed, mut still) = (BTreeSet::new(), BTreeSet::new());
    for change in &changes {
        let size = change.by_differences.abs().max(1e-3);
        let relative = change.error.abs() / size;
        if relative > 1e-5 && change.kink {
            kinks.push(&change.call);
            continue;
        }
        assert!(
            relative < 1e-5,
            "{}: {:e} off, changes by {:e}",
            change.call,
            change.error,
            change.by_differences
        );
        if relative > worst.0 {
            worst = (relative, change.call.clone());
        }
        let name = change.call.split(['(', '+']).next().unwrap_or_default();
        if !change.flat && change.by_differences.abs() > 1e-6 {
            followed.insert(name.to_string());
        } else {
            still.insert(name.to_string());
        }
    }
    // A function that never changes would pass with any derivative.
    let still: Vec<&String> = still.difference(&followed).collect();
    for name in still {
        let def = FUNCTIONS.iter().find(|def| def.name == name).unwrap();
        assert!(is_flat(def), "{name} was never seen to change");
    }
    println!("kinks {kinks:?}");
    let magnitudes = kinks.iter().all(|call| call.contains(",5,"));
    assert!(magnitudes && kinks.len() < 8, "{kinks:?}");
    println!("{} calls, worst {worst:?}", changes.len());
    assert!(changes.len() > 300, "{}", changes.len());
}
