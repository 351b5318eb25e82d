//! Template of a `kc.toml` for kinematics and compliance (K&C) tests of a deck: its wheels, and the loads on them that the deck contains.

use std::fmt::Write as _;

use admire_solver::mechanics::Vec3;
use admire_solver::model::{Function, MarkerIx, Model, PartIx, VectorForceKind};
use admire_syntax::expression::Node;

/// Words that occur in the names of parts and markers at a wheel, in English, German, French, Italian and Spanish.
pub(super) const WHEEL_WORDS: [&str; 22] = [
    "wheel",
    "hub",
    "knuckle",
    "upright",
    "spindle",
    "carrier",
    "tire",
    "tyre",
    "rim",
    "radtr",
    "radmitt",
    "radnabe",
    "radlager",
    "achsschenkel",
    "schwenklager",
    "moyeu",
    "fusee",
    "roue",
    "mozzo",
    "ruota",
    "mangueta",
    "rueda",
];

/// Words for "centre" that occur in the names of markers.
pub(super) const CENTRE_WORDS: [&str; 3] = ["cent", "mitte", "zentrum"];

/// Returns the value of a FUNCTION that is a plain number; `None` for any other FUNCTION. Load cases can drive a FUNCTION that is a plain
/// number.
pub(super) fn number(function: &Function) -> Option<f64> {
    let Function::Expression(expression) = function else {
        return None;
    };
    let literal = |k: &usize| expression.literals.get(*k).map(|literal| literal.value);
    match &expression.root {
        Node::Literal(k) => literal(k),
        Node::Negate(inner) => match &**inner {
            Node::Literal(k) => literal(k).map(|value| -value),
            _ => None,
        },
        _ => None,
    }
}

/// Returns true if a FUNCTION is a plain number.
pub(super) fn is_number(function: &Function) -> bool {
    number(function).is_some()
}

/// Words for the left and for the right side that occur in names, in English, German and French.
const SIDES: [&[&str]; 2] = [
    &["left", "links", "gauche"],
    &["right", "rechts", "droite", "droit"],
];

/// Returns true if the names around a wheel state a side (left or right) that contradicts the axes of Adams/Car (X rearward, Y right). The axes
/// then probably follow ISO 8855.
pub(super) fn looks_like_iso(model: &Model, wheel: MarkerIx) -> bool {
    let part = &model.parts[part_of(model, wheel).0];
    let names = [
        &model.markers[wheel.0].header.name,
        &part.header.name,
        &model.title,
    ];
    let said = names.into_iter().find_map(|name| {
        let name = name.to_lowercase();
        let of = |words: &[&str]| {
            let mut tokens = name.split(|c: char| !c.is_alphanumeric());
            tokens.any(|token| words.contains(&token))
        };
        match SIDES.map(of) {
            [true, false] => Some(1.0),
            [false, true] => Some(-1.0),
            _ => None,
        }
    });
    // In the axes of Adams/Car, the left side of the vehicle has negative y.
    said.is_some_and(|side| side * place(model, wheel).y > 0.0)
}

/// Returns the position of a marker in ground, in the design position of the deck.
fn place(model: &Model, at: MarkerIx) -> Vec3 {
    let marker = &model.markers[at.0];
    model.parts[marker.part.0].pose.point(&marker.qp)
}

fn part_of(model: &Model, at: MarkerIx) -> PartIx {
    model.markers[at.0].part
}

/// Returns the centre marker of the opposite wheel. It must be near the mirror image of this wheel centre in the plane y = 0, on another part
/// whose name contains a wheel word.
fn other_wheel(model: &Model, wheel: MarkerIx) -> Option<MarkerIx> {
    /// Tolerance of the mirrored position, as a fraction of the distance from the plane y = 0.
    const NEAR: f64 = 0.02;
    let here = place(model, wheel);
    let image = Vec3::new(here.x, -here.y, here.z);
    let like = |part: PartIx| {
        let name = model.parts[part.0].header.name.to_lowercase();
        WHEEL_WORDS.iter().any(|word| name.contains(word))
    };
    let candidates = (0..model.markers.len()).map(MarkerIx).filter(|&at| {
        let part = part_of(model, at);
        part != part_of(model, wheel) && !model.markers[at.0].floating && like(part)
    });
    let apart = |at: &MarkerIx| (place(model, *at) - image).norm();
    let nearest = candidates.min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    (apart(&nearest) < NEAR * here.y.abs()).then_some(nearest)
}

/// Returns the axis of a marker that is closest to the y axis of ground, the lateral direction.
pub(super) fn spin_axis(model: &Model, at: MarkerIx) -> &'static str {
    let marker = &model.markers[at.0];
    let turned = model.parts[marker.part.0].pose.R * marker.R;
    let across = |axis: &usize| turned[(1, *axis)].abs();
    let best = (0..3).max_by(|a, b| across(a).total_cmp(&across(b)));
    ["x", "y", "z"][best.unwrap_or(1)]
}

/// Returns the addresses of the forces on the wheels' parts whose FUNCTION is a plain number. The rig replaces these loads.
fn own_loads(model: &Model, wheels: &[MarkerIx]) -> Vec<String> {
    let on = |at: MarkerIx| {
        wheels
            .iter()
            .any(|&w| part_of(model, w) == part_of(model, at))
    };
    let mut found = Vec::new();
    for force in &model.sforces {
        if force.header.active && on(force.i) && is_number(&force.function) {
            found.push(format!("SFORCE/{}", force.header.id));
        }
    }
    for force in &model.vector_forces {
        let mut all = force.components.iter().flatten();
        if force.header.active && on(force.i) && all.all(is_number) {
            let kind = match force.kind {
                VectorForceKind::Gforce => "GFORCE",
                VectorForceKind::Vforce => "VFORCE",
                VectorForceKind::Vtorque => "VTORQUE",
            };
            found.push(format!("{kind}/{}", force.header.id));
        }
    }
    found
}

/// Returns a commented `kc.toml` for this wheel, and for the opposite wheel if the deck has one.
pub(super) fn kc_toml(model: &Model, wheel: MarkerIx) -> String {
    let other = other_wheel(model, wheel);
    let wheels: Vec<MarkerIx> = std::iter::once(wheel).chain(other).collect();
    let quoted: Vec<String> = own_loads(model, &wheels)
        .iter()
        .map(|load| format!("\"{load}\""))
        .collect();
    let iso = looks_like_iso(model, wheel);
    let axes = if iso {
        "axes = \"iso\"                        # X forward, Y left, Z up, guessed from the names of the sides; CHECK; or \"adams-car\", \"sae\", [\"forward\", \"left\", \"up\"]"
    } else {
        "axes = \"adams-car\"                  # X rearward, Y right, Z up; CHECK; or \"iso\", \"sae\", [\"forward\", \"left\", \"up\"]"
    };
    let (length, force) = (model.units.length.word, model.units.force.word);
    let millimetre = 1e-3 / model.units.length.si;
    let mut text = format!(
        "# K&C tests of the axle: `admire kc` with this file; `admire explain wheels.left.centre` explains a key. In {length} and {force}.\n\n\
         [deck]\n\
         {axes}\n\
         without = [{}]  # the deck's own loads and drives of the wheels, which the rig replaces; CHECK\n\n\
         [wheels]\n",
        quoted.join(", ")
    );
    if other.is_none() {
        text += "mirror = true                       # the other wheel is the mirror image\n";
    }
    for at in &wheels {
        let side = if (place(model, *at).y < 0.0) == iso {
            "right"
        } else {
            "left"
        };
        let marker = &model.markers[at.0];
        let part = &model.parts[marker.part.0].header.name;
        _ = writeln!(
            text,
            "\n[wheels.{side}]\n\
             centre = \"MARKER/{}\"              # looks like the wheel centre, on {part}; CHECK that it is on the wheel carrier, which does not spin\n\
             spin = \"{}\"                         # axis of this marker along the spin axis\n\
             # steer_axis = [\"MARKER/..\", \"MARKER/..\"]  # lower and upper ball joint, for caster, kingpin, scrub and trail",
            marker.header.id,
            spin_axis(model, *at),
        );
    }
    _ = write!(
        text,
        "\n# [tyre]                            # without it all loads act at the wheel centre\n\
         # radius = {}                      # unloaded; FILL IN\n\
         # stiffness = {}                    # vertical, {force}/{length}\n\n\
         # [ride]\n\
         # load = ..                         # vertical load of each wheel at ride height; without it the design position counts\n\n\
         # [steering]\n\
         # lock = \"MOTION/1\"                 # what locks the steering\n\
         # drive = \"MOTION/1\"                # what steers\n",
        300.0 * millimetre,
        200.0 * 1e3 * model.units.length.si / model.units.force.si,
    );
    text
}
