//! Reads just enough of the reference decks to build a model by hand.

use admire::mechanics::{Pose, Vec3, euler313};
use admire::model::{
    Bushing, Function, Header, Joint, JointKind, Marker, MarkerIx, Model, Orientation, Part,
    PartIx, PartKind, Sforce, SforceKind, SpringDamper, SpringKind,
};
use admire::syntax::expression::Node;
use admire::syntax::{Expression, Number};
use admire::text::Span;
use admire::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Units};

pub fn constant(value: f64) -> Function {
    let span = Span { start: 0, end: 0 };
    Function::Expression(Expression {
        root: Node::Literal(0),
        text: value.to_string(),
        span,
        literals: vec![Number {
            value,
            degrees: false,
            span,
        }],
    })
}

struct Statement {
    kind: String,
    id: u32,
    name: String,
    arguments: Vec<(String, Vec<String>)>,
}

impl Statement {
    fn has(&self, key: &str) -> bool {
        self.arguments.iter().any(|(k, _)| k.starts_with(key))
    }

    fn numbers(&self, key: &str, count: usize) -> Vec<f64> {
        self.arguments.iter().find(|(k, _)| k == key).map_or_else(
            || vec![0.0; count],
            |(_, v)| v.iter().map(|s| number(s)).collect(),
        )
    }

    fn number(&self, key: &str) -> f64 {
        self.numbers(key, 1)[0]
    }

    fn header(&self) -> Header {
        Header {
            id: self.id,
            name: self.name.clone(),
            origin: 0,
            active: true,
        }
    }
}

fn number(text: &str) -> f64 {
    match text.strip_suffix('D') {
        Some(degrees) => degrees.parse::<f64>().unwrap().to_radians(),
        None => text.parse().unwrap(),
    }
}

fn statements(text: &str) -> Vec<Statement> {
    let mut out: Vec<Statement> = Vec::new();
    let mut name = String::new();
    for line in text.lines().skip(1) {
        if let Some((_, rest)) = line.split_once("adams_view_name='") {
            name = rest.trim_end_matches('\'').to_string();
        }
        let line = line.split('!').next().unwrap().trim();
        if line.is_empty() || line == "END" {
            continue;
        }
        let rest = if let Some(rest) = line.strip_prefix(',') {
            rest.to_string()
        } else {
            let (kind, rest) = line.split_once('/').unwrap();
            let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
            out.push(Statement {
                kind: kind.to_string(),
                id: digits.parse().unwrap_or(0),
                name: std::mem::take(&mut name),
                arguments: Vec::new(),
            });
            rest[digits.len()..].to_string()
        };
        let arguments = &mut out.last_mut().unwrap().arguments;
        for piece in rest.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            match piece.split_once('=') {
                Some((key, value)) => {
                    arguments.push((key.trim().to_string(), vec![value.trim().to_string()]));
                }
                None if piece.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
                    arguments.last_mut().unwrap().1.push(piece.to_string());
                }
                None => arguments.push((piece.to_string(), Vec::new())),
            }
        }
    }
    out
}

fn frame(s: &Statement, position: &str) -> (Vec3, [f64; 3]) {
    let p = s.numbers(position, 3);
    let a = s.numbers("REULER", 3);
    (Vec3::new(p[0], p[1], p[2]), [a[0], a[1], a[2]])
}

pub fn read(text: &str) -> Model {
    let statements = statements(text);
    let mut model = Model {
        units: Units::new(
            FORCE_UNITS[0],
            MASS_UNITS[0],
            LENGTH_UNITS[0],
            TIME_UNITS[0],
        ),
        ..Model::default()
    };
    let of = |kind: &'static str| statements.iter().filter(move |s| s.kind == kind);
    for s in of("PART") {
        let (p, a) = frame(s, "QG");
        let ip = s.numbers("IP", 6);
        model.parts.push(Part {
            header: s.header(),
            kind: if s.has("GROUND") {
                PartKind::Ground
            } else {
                PartKind::Rigid
            },
            mass: s.number("MASS"),
            cm: None,
            ip: std::array::from_fn(|k| ip.get(k).copied().unwrap_or(0.0)),
            pose: Pose {
                p,
                R: euler313(a[0], a[1], a[2]),
            },
            exact: [false; 6],
        });
    }
    for s in of("MARKER") {
        let (qp, a) = frame(s, "QP");
        let part = s.number("PART") as u32;
        let part = model.parts.iter().position(|p| p.header.id == part);
        model.markers.push(Marker {
            header: s.header(),
            part: PartIx(part.unwrap()),
            qp,
            orientation: Orientation::Reuler(a),
            R: euler313(a[0], a[1], a[2]),
            floating: false,
        });
    }
    for (s, k) in of("PART").zip(0..) {
        if s.has("CM") {
            model.parts[k].cm = model.marker(s.number("CM") as u32);
        }
    }
    let marker =
        |s: &Statement, key: &str| -> MarkerIx { model.marker(s.number(key) as u32).unwrap() };
    let three = |s: &Statement, key: &str| -> [f64; 3] { s.numbers(key, 3).try_into().unwrap() };
    let bushings = of("BUSHING")
        .map(|s| Bushing {
            header: s.header(),
            i: marker(s, "I"),
            j: marker(s, "J"),
            k: three(s, "K"),
            kt: three(s, "KT"),
            force: three(s, "FORCE"),
            torque: three(s, "TORQUE"),
        })
        .collect();
    let springdampers = of("SPRINGDAMPER")
        .map(|s| SpringDamper {
            header: s.header(),
            i: marker(s, "I"),
            j: marker(s, "J"),
            kind: SpringKind::Translational,
            stiffness: s.number("K"),
            reference: s.number("LENGTH"),
            preload: s.number("FORCE"),
        })
        .collect();
    let sforces = of("SFORCE")
        .map(|s| Sforce {
            header: s.header(),
            i: marker(s, "I"),
            j: marker(s, "J"),
            kind: if s.has("ROT") {
                SforceKind::Rotational
            } else {
                SforceKind::Translational
            },
            action_only: s.has("ACTIONONLY"),
            function: constant(s.number("FUNCTION")),
        })
        .collect();
    let joints = of("JOINT")
        .map(|s| Joint {
            header: s.header(),
            kind: match s.arguments[0].0.as_str() {
                "SPHERICAL" => JointKind::Spherical,
                "REVOLUTE" => JointKind::Revolute,
                "CYLINDRICAL" => JointKind::Cylindrical,
                "UNIVERSAL" => JointKind::Universal,
                other => panic!("{other}"),
            },
            i: marker(s, "I"),
            j: marker(s, "J"),
        })
        .collect();
    model.bushings = bushings;
    model.springdampers = springdampers;
    model.sforces = sforces;
    model.joints = joints;
    for s in of("ACCGRAV") {
        model.gravity = Vec3::new(s.number("IGRAV"), s.number("JGRAV"), s.number("KGRAV"));
    }
    model
}
