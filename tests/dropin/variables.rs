//! VARIABLEs as parameters, as measures, and as expressions of each other.

use std::fmt;
use std::time::{Duration, Instant};

use crate::run::run_deck as run;

/// Returns a deck of a part of 1 kg on a bushing of 1000 N/m, with further statements.
fn on_a_bushing(statements: &str) -> String {
    format!(
        "variables
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/1, PART=1
MARKER/20, PART=2
BUSHING/1, I=20, J=1, K=1E3,1E3,1E3, KT=1E3,1E3,1E3, C=30,30,30, CT=1,1,1
{statements}
EQUILIBRIUM/ERROR=1E-10, IMBALANCE=1E-8
RESULTS/FORMATTED, XRF
END
"
    )
}

fn pull(function: &str) -> String {
    format!("SFORCE/1, TRANS, ACTIONONLY, I=20, J=1, FUNCTION={function}")
}

#[test]
fn a_variable_is_a_parameter_from_the_first_evaluation_on() {
    let parameter = "VARIABLE/1, FUNCTION=2\n";
    for (function, force) in [
        ("10/VARVAL(1)", 5.0),
        ("STEP(TIME,-1,0,VARVAL(1)-2.5,10)", 10.0),
        ("LOG(VARVAL(1))", 2.0_f64.ln()),
        ("SQRT(VARVAL(1)-1)", 1.0),
    ] {
        let deck = on_a_bushing(&format!("{parameter}{}", pull(function)));
        for command in ["SIM/STAT", "SIM/DYN, END=3, STEPS=3", "SIM/INITIAL"] {
            let (results, ran, _) = run(&deck, command);
            assert_eq!(ran.code, 0, "{function}: {}", ran.stdout);
            assert!(!ran.stdout.contains("ERROR"), "{function}: {}", ran.stdout);
            let z = *results.column("PART_2_XFORM", "Z").last().unwrap();
            let expected = if command == "SIM/INITIAL" {
                0.0
            } else {
                force / 1e3
            };
            assert!(
                (z - expected).abs() < 1e-6,
                "{function} {command}: {z} {expected}"
            );
            let value = *results.column("VARIABLE_1", "Q").last().unwrap();
            assert!((value - 2.0).abs() < 1e-12, "{value}");
        }
    }
}

#[test]
fn reactions_and_outputs_have_a_value_before_functions_divide_by_them() {
    // The reaction of the fixed part is its weight.
    let ratio = "PART/3, MASS=1, CM=30, IP=1,1,1
MARKER/30, PART=3
JOINT/1, FIXED, I=30, J=1
ACCGRAV/KGRAV=-9.81";
    for function in [
        "5*JOINT(1,0,4,0)/JOINT(1,0,1,0)",
        "5*VARVAL(1)",
        // The second reaction has a value once the first ratio has one.
        "5*JOINT(2,0,1,0)/JOINT(2,0,1,0)",
    ] {
        let deck = on_a_bushing(&format!(
            "{ratio}
VARIABLE/1, FUNCTION=JOINT(1,0,4,0)/JOINT(1,0,1,0)
PART/4, MASS=1, CM=40, IP=1,1,1
MARKER/40, PART=4
JOINT/2, FIXED, I=40, J=1
SFORCE/2, TRANS, ACTIONONLY, I=40, J=1, FUNCTION=JOINT(1,0,4,0)/JOINT(1,0,1,0)
{}",
            pull(function)
        ));
        for command in ["SIM/STAT", "SIM/DYN, END=3, STEPS=3"] {
            let (results, ran, _) = run(&deck, command);
            assert!(!ran.stdout.contains("ERROR"), "{function}: {}", ran.stdout);
            let z = *results.column("PART_2_XFORM", "Z").last().unwrap();
            assert!(
                (z - (5.0 - 9.81) / 1e3).abs() < 1e-6,
                "{function} {command}: {z}"
            );
        }
    }
    // x' = -x + u is 1 at rest, and 0 before the first solution.
    let linear = "ARRAY/1, X, SIZE=1
ARRAY/2, U, VARIABLES=1
ARRAY/3, Y, SIZE=1
VARIABLE/1, FUNCTION=1
MATRIX/1, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=-1
MATRIX/2, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=1
LSE/1, X=1, U=2, Y=3, A=1, B=2, C=2
VARIABLE/2, FUNCTION=1/ARYVAL(3,1)
";
    let deck = on_a_bushing(&format!("{linear}{}", pull("3/ARYVAL(3,1)")));
    let (results, ran, _) = run(&deck, "SIM/STAT");
    assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
    let z = *results.column("PART_2_XFORM", "Z").last().unwrap();
    assert!((z - 3e-3).abs() < 1e-9, "{z}");
    let value = *results.column("VARIABLE_2", "Q").last().unwrap();
    assert!((value - 1.0).abs() < 1e-9, "{value}");
    // A variable that is only output may have no value at the start.
    let deck = on_a_bushing(linear);
    let (_, ran, _) = run(&deck, "SIM/DYN, END=1, STEPS=2");
    assert_eq!(ran.code, 0);
    assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
}

#[test]
fn a_force_divided_by_a_variable_of_places_is_balanced() {
    let deck = "VARIABLE divides in a force
UNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = MILLIMETER, TIME = SECOND
PART/1, GROUND
MARKER/1, PART = 1
PART/2, QG = 0, 0, 0, MASS = 1, CM = 2, IP = 1, 1, 1
MARKER/2, PART = 2
JOINT/1, TRANSLATIONAL, I = 2, J = 1
VARIABLE/1, FUNCTION = SQRT(DZ(2,1)**2+1)
SFORCE/1, I = 2, J = 1, TRANSLATION, ACTIONONLY, FUNCTION = -10*DZ(2,1)/VARVAL(1)
ACCGRAV/KGRAV = -9806.65
RESULTS/FORMATTED, XRF
END
";
    let (results, ran, _) = run(deck, "SIM/STAT");
    assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
    // Equilibrium: 10 z / sqrt(z^2 + 1) = -9.80665
    let s = 0.980665_f64;
    let z = *results.column("PART_2_XFORM", "Z").last().unwrap();
    assert!((z + s / (1.0 - s * s).sqrt()).abs() < 1e-4, "{z}");
}

/// A small expression that can be printed and evaluated.
enum Node {
    Number(f64),
    Time,
    Variable(usize),
    Binary(char, Box<Self>, Box<Self>),
    /// One of LOG(2 + x^2), SQRT(1 + x^2) and EXP(-x^2).
    Call(&'static str, Box<Self>),
    /// The function STEP(TIME, a^2, 1, 1 + a^2 + b^2, 2).
    Step(Box<Self>, Box<Self>),
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "({x})"),
            Self::Time => write!(f, "TIME"),
            Self::Variable(k) => write!(f, "VARVAL({k})"),
            Self::Binary('/', a, b) => write!(f, "(({a})/(1+({b})**2))"),
            Self::Binary(operator, a, b) => write!(f, "(({a}){operator}({b}))"),
            Self::Call("LOG", x) => write!(f, "LOG(2+({x})**2)"),
            Self::Call("SQRT", x) => write!(f, "SQRT(1+({x})**2)"),
            Self::Call(_, x) => write!(f, "(1/EXP(0.1*({x})**2))"),
            Self::Step(a, b) => write!(f, "STEP(TIME,({a})**2,1,1+({a})**2+({b})**2,2)"),
        }
    }
}

impl Node {
    fn value(&self, time: f64, variables: &[Node]) -> f64 {
        let inner = |node: &Self| node.value(time, variables);
        match self {
            Self::Number(x) => *x,
            Self::Time => time,
            Self::Variable(k) => inner(&variables[k - 1]),
            Self::Binary('+', a, b) => inner(a) + inner(b),
            Self::Binary('-', a, b) => inner(a) - inner(b),
            Self::Binary('*', a, b) => inner(a) * inner(b),
            Self::Binary(_, a, b) => inner(a) / (1.0 + inner(b).powi(2)),
            Self::Call("LOG", x) => (2.0 + inner(x).powi(2)).ln(),
            Self::Call("SQRT", x) => (1.0 + inner(x).powi(2)).sqrt(),
            Self::Call(_, x) => 1.0 / (0.1 * inner(x).powi(2)).exp(),
            Self::Step(a, b) => {
                let (from, width) = (inner(a).powi(2), 1.0 + inner(b).powi(2));
                let u = ((time - from) / width).clamp(0.0, 1.0);
                1.0 + u * u * (3.0 - 2.0 * u)
            }
        }
    }
}

/// A small linear congruential generator.
struct Draw(u64);

impl Draw {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    /// Returns a random expression of TIME and the given VARIABLEs.
    fn node(&mut self, depth: usize, read: &[usize]) -> Node {
        let inner = |draw: &mut Self| Box::new(draw.node(depth - 1, read));
        match self.below(if depth == 0 { 3 } else { 9 }) {
            0 => Node::Number((self.below(40) as f64 - 20.0) / 8.0),
            1 => Node::Time,
            2 => match read {
                [] => Node::Number(1.5),
                read => Node::Variable(read[self.below(read.len())]),
            },
            k @ 3..=6 => {
                let operator = ['+', '-', '*', '/'][k - 3];
                Node::Binary(operator, inner(self), inner(self))
            }
            7 => Node::Call(["LOG", "SQRT", "EXP"][self.below(3)], inner(self)),
            _ => Node::Step(inner(self), inner(self)),
        }
    }
}

#[test]
fn random_expressions_of_variables_are_what_they_say() {
    const COUNT: usize = 6;
    for seed in 0..60 {
        let mut draw = Draw(seed);
        // Each variable reads only later ones of a random order, which differs from the order of ids.
        let mut order: Vec<usize> = (1..=COUNT).collect();
        for k in (1..COUNT).rev() {
            order.swap(k, draw.below(k + 1));
        }
        let mut variables: Vec<Node> = (0..COUNT).map(|_| Node::Time).collect();
        for (at, id) in order.iter().enumerate() {
            variables[id - 1] = draw.node(3, &order[at + 1..]);
        }
        let force = draw.node(3, &order);
        let mut statements = pull(&format!("{force}"));
        for (k, node) in variables.iter().enumerate() {
            statements += &format!("\nVARIABLE/{}, FUNCTION={node}", k + 1);
        }
        // Lines of a deck must be short.
        let deck = on_a_bushing(&folded(&statements));
        for command in ["SIM/STAT, END=2, STEPS=4", "SIM/DYN, END=2, STEPS=4"] {
            let (results, ran, _) = run(&deck, command);
            assert!(
                ran.code == 0 && !ran.stdout.contains("ERROR"),
                "{seed} {command}: {}\n{deck}",
                ran.stdout
            );
            let times = results.column("time", "TIME");
            let z = results.column("PART_2_XFORM", "Z");
            for k in 0..COUNT {
                let values = results.column(&format!("VARIABLE_{}", k + 1), "Q");
                for (time, value) in times.iter().zip(&values) {
                    let expected = variables[k].value(*time, &variables);
                    assert!(
                        (value - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                        "{seed} {command} VARIABLE/{} at {time}: {value} {expected}",
                        k + 1
                    );
                }
            }
            if command.contains("STAT") {
                for (time, z) in times.iter().zip(&z) {
                    let expected = force.value(*time, &variables) / 1e3;
                    assert!(
                        (z - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                        "{seed} at {time}: {z} {expected}"
                    );
                }
            }
        }
    }
}

/// Breaks long lines of statements into continuation lines.
fn folded(statements: &str) -> String {
    let mut out = String::new();
    for line in statements.lines() {
        let mut length = 0;
        for c in line.chars() {
            out.push(c);
            length += 1;
            if length > 60 && "()+-*,".contains(c) {
                // A comma at the start of a line only marks a continuation.
                out.push_str("\n,");
                length = 0;
            }
        }
        out.push('\n');
    }
    out
}

/// Returns a deck of a chain of bodies on ball joints, each with the given measures.
fn chain(measures: &[&str]) -> String {
    let mut deck = "measures
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
MARKER/1, PART=1
ACCGRAV/KGRAV=-9.81
"
    .to_string();
    let mut before = 1;
    for k in 2..10 {
        let (a, b) = (10 * k, 10 * k + 1);
        deck += &format!(
            "PART/{k}, MASS=1, CM={b}, IP=0.1,0.2,0.3, QG={}, 0, 0
MARKER/{a}, PART={k}
MARKER/{b}, PART={k}, QP=0.5, 0.1, 0.05
MARKER/{c}, PART={k}, QP=1, 0, 0
JOINT/{k}, SPHERICAL, I={a}, J={before}
",
            k - 2,
            c = b + 1
        );
        before = b + 1;
        for (m, measure) in measures.iter().enumerate() {
            let function = measure.replace("{}", &b.to_string());
            deck += &format!("VARIABLE/{}, FUNCTION={function}\n", 100 * k + m);
        }
    }
    deck + "RESULTS/FORMATTED, XRF\nEND\n"
}

/// Checks that variables which nothing reads are evaluated only for output: the motion takes the same steps in nearly the same time.
#[test]
fn what_only_measures_costs_no_steps() {
    const MEASURES: [&str; 12] = [
        "DX({},1)",
        "DM({},1)",
        "PSI({},1)",
        "VX({},1)",
        "VM({},1)",
        "WZ({},1)",
        "ACCX({},1)",
        "ACCM({},1)",
        "WDTZ({},1)",
        "SQRT(1+VZ({},1)**2)",
        "IF(DZ({},1):-1,0,1)",
        "LOG(DM({},1))",
    ];
    let (plain, measured) = (chain(&[]), chain(&MEASURES));
    let mut fastest = [Duration::MAX; 2];
    let mut messages = [String::new(), String::new()];
    for _ in 0..3 {
        for (k, deck) in [&plain, &measured].into_iter().enumerate() {
            let begun = Instant::now();
            let (_, ran, message) = run(deck, "SIM/DYN, END=0.5, STEPS=10");
            fastest[k] = fastest[k].min(begun.elapsed());
            assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
            messages[k] = message;
        }
    }
    // Simulation time, step size, function evaluations and steps of every row of the table.
    let table = |message: &str| -> Vec<Vec<String>> {
        let rows = message
            .lines()
            .filter(|line| line.starts_with("   ") && line.contains("E-"));
        let words = |line: &str| line.split_whitespace().take(4).map(String::from).collect();
        rows.map(words).collect()
    };
    assert!(table(&messages[0]).len() > 3, "{}", messages[0]);
    assert_eq!(table(&messages[0]), table(&messages[1]));
    let ratio = fastest[1].as_secs_f64() / fastest[0].as_secs_f64();
    assert!(ratio < 2.0, "{fastest:?}");
}

#[test]
fn a_variable_that_reads_itself_is_solved_for() {
    // v = 1 + v/2, w = v - u/4, u = w: 2 and 1.6; the force reads itself through variable 4.
    let deck = on_a_bushing(&format!(
        "VARIABLE/1, FUNCTION=1+0.5*VARVAL(1)
VARIABLE/2, FUNCTION=VARVAL(1)-0.25*VARVAL(3)
VARIABLE/3, FUNCTION=VARVAL(2)
VARIABLE/4, FUNCTION=1+0.5*SFORCE(1,0,4,0)
{}",
        pull("VARVAL(4)+VARVAL(3)")
    ));
    for command in ["SIM/STAT", "SIM/DYN, END=3, STEPS=3"] {
        let (results, ran, _) = run(&deck, command);
        assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
        // f = 1 + f/2 + 1.6
        for (column, expected) in [
            ("VARIABLE_1", 2.0),
            ("VARIABLE_3", 1.6),
            ("VARIABLE_4", 3.6),
        ] {
            let value = *results.column(column, "Q").last().unwrap();
            assert!(
                (value - expected).abs() < 1e-8,
                "{command} {column}: {value}"
            );
        }
        let z = *results.column("PART_2_XFORM", "Z").last().unwrap();
        assert!((z - 5.2e-3).abs() < 1e-6, "{command}: {z}");
    }
}

#[test]
fn a_motion_of_a_rate_may_read_a_variable_of_the_time() {
    let deck = "rate
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND
PART/1, GROUND
PART/2, MASS=1, CM=20, IP=1,1,1
MARKER/1, PART=1
MARKER/20, PART=2
JOINT/1, TRANSLATIONAL, I=20, J=1
VARIABLE/3, FUNCTION=2*VARVAL(4)
VARIABLE/4, FUNCTION=0.5*TIME
PINPUT/1, VARIABLES=3
MOTION/1, JOINT=1, VELOCITY, FUNCTION=VARVAL(3)
RESULTS/FORMATTED, XRF
END
";
    let (results, ran, _) = run(
        deck,
        "SIM/KIN, END=2, STEPS=4\nVARIABLE/3, FUNCTION=3\nSIM/KIN, END=3, STEPS=2",
    );
    assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
    let z = results.column("PART_2_XFORM", "Z");
    // The integral of TIME up to 2 s, then three more.
    assert!(
        (z[z.len() - 3] - 2.0).abs() < 1e-9 && (z[z.len() - 1] - 5.0).abs() < 1e-9,
        "{z:?}"
    );
}
