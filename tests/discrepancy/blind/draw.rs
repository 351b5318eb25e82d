//! Random planted effects: each seed draws cause, location, sign and size, and an axle with a load programme and a noise level.

use admire_rig::LoadTable;
use admire_solver::model::{JointKind, MarkerIx, Model};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::sized::{Form, Piece, Plant, shift, text};

/// The axle of a study.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axle {
    /// Axle with two bushings to be identified.
    McPherson,
    /// Axle with twelve bushings to be identified.
    Multilink,
}

impl Axle {
    /// Returns the name of the axle's study in the corpus.
    pub const fn name(self) -> &'static str {
        match self {
            Self::McPherson => "pseudo-mcpherson",
            Self::Multilink => "multilink",
        }
    }

    /// Returns the id of the wheel carrier part.
    const fn carrier(self) -> u32 {
        match self {
            Self::McPherson => 4,
            Self::Multilink => 3,
        }
    }
}

/// Kind of study, by what is planted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// One cause.
    Single,
    /// No cause.
    Clean,
    /// Two causes at once.
    Pair,
    /// A cause outside the catalogue of hypotheses.
    Outside,
}

/// A planned study, before it is measured.
#[derive(Clone, PartialEq, Debug)]
pub struct Plan {
    /// Seed of the study.
    pub seed: u64,
    /// Kind of the study.
    pub kind: Kind,
    /// Axle of the study.
    pub axle: Axle,
    /// Load programme.
    pub programme: LoadTable,
    /// Standard deviation of a mark coordinate, in mm.
    pub sigma: f64,
    /// True if hardpoints, load gains and the first session have small background errors.
    pub background: bool,
    /// Whether the wheel is measured, and whether two sensors are read.
    pub instruments: (bool, bool),
    /// Planted effects.
    pub plants: Vec<Plant>,
}

/// All causes of guide/study.md.
pub const CAUSES: [&str; 16] = [
    "progressive-stiffness",
    "dry-friction",
    "link-compliance",
    "body-compliance",
    "assembly-offset",
    "hardpoint-error",
    "bushing-orientation",
    "bushing-coupling",
    "element-parameter",
    "stop-contact",
    "load-gain",
    "load-crosstalk",
    "load-point-error",
    "frame-drift",
    "mark-outlier",
    "channel-fault",
];

/// Causes that may be planted by another law than the one of their hypothesis.
///
/// Examples are other growth of forces, compliance at both ends, brackets stiffer in one direction, and errors that grow with load or time.
/// A shifted point or a single wrong reading has no other law.
const OTHERWISE: [&str; 12] = [
    "progressive-stiffness",
    "dry-friction",
    "link-compliance",
    "body-compliance",
    "bushing-orientation",
    "bushing-coupling",
    "stop-contact",
    "load-gain",
    "load-crosstalk",
    "load-point-error",
    "frame-drift",
    "channel-fault",
];

/// Effects for which the catalogue has no hypothesis.
pub const OUTSIDE: [&str; 6] = [
    "creep",
    "free-play",
    "part-flexibility",
    "asymmetric-friction",
    "thermal-drift",
    "marks-exchanged",
];

/// Ranges of the displacements of an axle in a programme, which set the natural scale of an effect.
pub struct Ranges<'a> {
    /// Model of the deck.
    pub model: &'a Model,
    /// Returns the smallest and largest displacement of I from J along an axis of J.
    pub of: &'a dyn Fn((MarkerIx, MarkerIx), usize) -> (f64, f64),
    /// Returns the smallest and largest distance between two markers.
    pub length: &'a dyn Fn((MarkerIx, MarkerIx)) -> (f64, f64),
    /// Marked parts with the labels of their marks.
    pub marks: Vec<(String, Vec<String>)>,
    /// Ids of the bushings to be identified.
    pub identified: Vec<u32>,
}

/// Returns the plan of a seed, without its planted effects.
pub fn plan(kind: Kind, seed: u64) -> Plan {
    let mut random = stream(seed, kind, 0);
    // Multilinks are limited because they take longest: at most 12 of the 74 test studies (8 of 48 singles, 2 of 12 clean ones, one pair).
    let multilink = match kind {
        Kind::Single | Kind::Clean => seed % 6 == 5,
        Kind::Pair | Kind::Outside => seed % 8 == 7,
    };
    let programmes = [LoadTable::Table1, LoadTable::Table2, LoadTable::UpAndDown];
    let cause = CAUSES[seed as usize % 16];
    let channels = kind == Kind::Single && cause == "channel-fault";
    Plan {
        seed,
        kind,
        axle: if multilink {
            Axle::Multilink
        } else {
            Axle::McPherson
        },
        programme: programmes[random.random_range(0..3)],
        sigma: (random.random_range(0.02..0.05) * 1e4_f64).round() / 1e4,
        // Background errors of hardpoints and gains are causes of the catalogue. A study with them is therefore not clean. If an effect outside
        // the catalogue is planted as well, naming a background error would not be a false name.
        background: matches!(kind, Kind::Single | Kind::Pair) && (seed + seed / 6) % 3 == 2,
        instruments: (
            random.random_bool(0.5),
            random.random_bool(0.25) || channels,
        ),
        plants: Vec::new(),
    }
}

/// Returns `count` plans of a kind, with seeds from `first` on and at most `multilinks` multilinks, which take longest.
///
/// Further seeds of the other axle replace the multilinks that are left out.
pub fn plans(kind: Kind, first: u64, count: usize, multilinks: usize) -> Vec<Plan> {
    let mut taken = 0;
    let fits = |plan: &Plan| {
        taken += usize::from(plan.axle == Axle::Multilink);
        plan.axle == Axle::McPherson || taken <= multilinks
    };
    let seeds = (first..).map(|seed| plan(kind, seed));
    seeds.filter(fits).take(count).collect()
}

/// Kinds of studies in the test command, with the number of studies and the maximum number of multilinks. A multilink takes ten times as
/// long as the other axle.
pub const OF_TESTS: [(Kind, usize, usize); 4] = [
    (Kind::Single, 48, 2),
    (Kind::Clean, 12, 2),
    (Kind::Pair, 16, 0),
    (Kind::Outside, 6, 0),
];

fn stream(seed: u64, kind: Kind, purpose: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed.wrapping_mul(1000) + 100 * kind as u64 + purpose)
}

/// Draws the planted effects for the ranges of the axle. Another `attempt` draws other locations and sizes.
pub fn plants(plan: &Plan, ranges: &Ranges<'_>, cases: &[String], attempt: u64) -> Vec<Plant> {
    let mut random = stream(plan.seed, plan.kind, 1 + attempt);
    let draw = |random: &mut Pcg64, cause| drawn(plan, ranges, cases, cause, random);
    match plan.kind {
        Kind::Clean => Vec::new(),
        Kind::Single => vec![draw(&mut random, CAUSES[plan.seed as usize % 16])],
        Kind::Outside => vec![draw(&mut random, OUTSIDE[plan.seed as usize % 6])],
        Kind::Pair => {
            // Two different causes; channel faults are excluded because not every rig has sensors.
            let mut causes = stream(plan.seed, plan.kind, 99);
            let first = causes.random_range(0..15);
            let second = (first + causes.random_range(1..15)) % 15;
            vec![
                draw(&mut random, CAUSES[first]),
                draw(&mut random, CAUSES[second]),
            ]
        }
    }
}

fn pick<'a, T>(from: &'a [T], random: &mut impl Rng) -> &'a T {
    &from[random.random_range(0..from.len())]
}

fn sign(random: &mut impl Rng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// Returns a random direction in space.
fn direction(random: &mut impl Rng) -> [f64; 3] {
    loop {
        let v: [f64; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&norm) {
            return v.map(|x| x / norm);
        }
    }
}

fn drawn(
    plan: &Plan,
    ranges: &Ranges<'_>,
    cases: &[String],
    cause: &'static str,
    random: &mut Pcg64,
) -> Plant {
    let model = ranges.model;
    // Three of four seeds use a law outside the hypotheses where the cause permits, which is more than half of all causes.
    let drawn = random.random_bool(0.5);
    let foreign = OTHERWISE.contains(&cause)
        && if plan.kind == Kind::Single {
            !(plan.seed + plan.seed / 16).is_multiple_of(4)
        } else {
            drawn
        };
    // Sizes range from below the detection limit to three times the noise.
    let wanted = random.random_range(0.2_f64.ln()..3.0_f64.ln()).exp();
    let bushings: Vec<usize> = (0..model.bushings.len()).collect();
    // Locations are drawn where the programme causes displacements.
    let component = |random: &mut Pcg64, axes: usize| loop {
        let bushing = *pick(&bushings, random);
        let axis = random.random_range(0..axes);
        let law = &model.bushings[bushing];
        let range = (ranges.of)((law.i, law.j), axis);
        let least = if axis < 3 { 0.02 } else { 2e-4 };
        if range.1 - range.0 > least {
            let k = if axis < 3 {
                law.k[axis]
            } else {
                law.kt[axis - 3]
            };
            let word = format!(
                "BUSHING/{}.{}.{}",
                law.header.id,
                ["K", "KT"][axis / 3],
                axis % 3 + 1
            );
            return (word, range, k);
        }
    };
    let slides: Vec<_> = model
        .joints
        .iter()
        .filter(|j| matches!(j.kind, JointKind::Cylindrical | JointKind::Translational))
        .collect();
    let loads = ["SFORCE/1", "SFORCE/2", "SFORCE/3"];
    let growing = if foreign { ",law=growing" } else { "" };
    let (address, pieces, most): (String, Vec<Piece>, f64) = match cause {
        "progressive-stiffness" => {
            let (address, (low, high), k) = component(random, 6);
            let far = high.abs().max(low.abs());
            let pieces = if foreign {
                vec![text("law=exponential,rate="), Piece::Grows(0.5 / far)]
            } else {
                vec![text("cubic="), Piece::Grows(0.3 * k / (far * far))]
            };
            (address, pieces, 6.0)
        }
        "dry-friction" => {
            let law = if foreign { ",law=dahl" } else { "" };
            let slip = random.random_range(0.01_f64.ln()..0.3_f64.ln()).exp();
            if !slides.is_empty() && random.random_bool(0.3) {
                let joint = pick(&slides, random);
                let (low, high) = (ranges.of)((joint.i, joint.j), 2);
                let force = 50.0;
                let stiffness = force / (slip * (high - low).max(0.1));
                let pieces = vec![
                    text("force="),
                    Piece::Grows(force),
                    text(",stiffness="),
                    Piece::Grows(stiffness),
                    text(law),
                ];
                (format!("JOINT/{}", joint.header.id), pieces, 20.0)
            } else {
                let (address, (low, high), k) = component(random, 6);
                let force = 0.1 * k * (high - low);
                let pieces = vec![
                    text("force="),
                    Piece::Grows(force),
                    text(",stiffness="),
                    Piece::Grows(force / (slip * (high - low))),
                    text(law),
                ];
                (address, pieces, 8.0)
            }
        }
        "link-compliance" => {
            let two: Vec<u32> = model
                .parts
                .iter()
                .enumerate()
                .filter(|(k, _)| {
                    let on = |m: MarkerIx| model.markers[m.0].part.0 == *k;
                    let joints = model.joints.iter().filter(|o| on(o.i) || on(o.j)).count();
                    let bushings = model.bushings.iter().filter(|o| on(o.i) || on(o.j)).count();
                    Some(*k) != model.ground().map(|g| g.0) && joints + bushings == 2
                })
                .map(|(_, part)| part.header.id)
                .collect();
            let ends = match (foreign, random.random_bool(0.5)) {
                (true, true) => ",ends=both",
                (true, false) => ",ends=both,rated=4000",
                _ => "",
            };
            let pieces = vec![text("stiffness="), Piece::Shrinks(2e4), text(ends)];
            (format!("PART/{}", pick(&two, random)), pieces, 40.0)
        }
        "body-compliance" => {
            let ground = model.ground().expect("a deck has ground");
            let on = |m: MarkerIx| model.markers[m.0].part == ground;
            let joints = model
                .joints
                .iter()
                .filter(|o| on(o.i) != on(o.j))
                .map(|o| format!("JOINT/{}", o.header.id));
            let springs = model
                .springdampers
                .iter()
                .filter(|o| on(o.i) != on(o.j))
                .map(|o| format!("SPRINGDAMPER/{}", o.header.id));
            let places: Vec<String> = joints.chain(springs).collect();
            let mut pieces = vec![text("stiffness="), Piece::Shrinks(2e4)];
            if foreign {
                // A bracket that is stiffer in one direction and stiffens slightly.
                let axis = pick(&["x", "y", "z"], random);
                let factor = random.random_range(0.4..2.5);
                pieces.push(text(format!(",{axis}={factor:.3},rated=8000")));
            }
            (pick(&places, random).clone(), pieces, 40.0)
        }
        "assembly-offset" => {
            let id = model.bushings[*pick(&bushings, random)].header.id;
            (format!("BUSHING/{id}"), shift(direction(random), 0.5), 6.0)
        }
        "hardpoint-error" => {
            let joints = model.joints.iter().flat_map(|o| [o.i, o.j]);
            let springs = model.springdampers.iter().flat_map(|o| [o.i, o.j]);
            let markers: Vec<MarkerIx> = joints.chain(springs).collect();
            let id = model.markers[pick(&markers, random).0].header.id;
            (format!("MARKER/{id}"), shift(direction(random), 1.0), 8.0)
        }
        "bushing-orientation" => {
            let id = model.bushings[*pick(&bushings, random)].header.id;
            let names = ["ax_deg=", "ay_deg=", "az_deg="];
            let axis = random.random_range(0..3);
            let angle = 5.0 * sign(random);
            let mut pieces = vec![text(names[axis]), Piece::Grows(angle)];
            if foreign {
                // The bushing is askew about a second axis as well.
                let other = (axis + random.random_range(1..3)) % 3;
                let share = random.random_range(-0.5..0.5);
                pieces.extend([
                    text(format!(",{}", names[other])),
                    Piece::Grows(share * angle),
                ]);
            }
            (format!("BUSHING/{id}"), pieces, 6.0)
        }
        "bushing-coupling" => {
            let law = &model.bushings[*pick(&bushings, random)];
            let (a, b) = *pick(&[(0, 1), (0, 2), (1, 2)], random);
            let name = ["x", "y", "z"][a].to_string() + ["x", "y", "z"][b];
            let k = (law.k[a] * law.k[b]).sqrt();
            let mut pieces = vec![text(name + "="), Piece::Grows(0.1 * k * sign(random))];
            if foreign {
                // Rubber whose thickness is 1.5 times its largest deflection, the same in all directions.
                let far = (0..3).map(|axis| (ranges.of)((law.i, law.j), axis));
                let far = far.map(|(low, high)| high.abs().max(low.abs()));
                let reach = 1.5 * far.fold(0.2, f64::max);
                pieces.push(text(format!(",reach={reach:.4}")));
            }
            (format!("BUSHING/{}", law.header.id), pieces, 6.0)
        }
        "element-parameter" => {
            let springs = model.springdampers.iter().flat_map(|o| {
                let preload = (o.preload != 0.0).then_some("FORCE");
                ["K"]
                    .into_iter()
                    .chain(preload)
                    .map(|word| format!("SPRINGDAMPER/{}.{word}", o.header.id))
            });
            let known = model
                .bushings
                .iter()
                .filter(|o| !ranges.identified.contains(&o.header.id))
                .flat_map(|o| {
                    let id = o.header.id;
                    ["K.1", "K.2", "K.3", "KT.1", "KT.2", "KT.3"]
                        .map(|word| format!("BUSHING/{id}.{word}"))
                });
            let places: Vec<String> = springs.chain(known).collect();
            let pieces = vec![text("factor="), Piece::Factor(0.05 * sign(random))];
            (pick(&places, random).clone(), pieces, 12.0)
        }
        "stop-contact" => {
            let law = if foreign { ",law=quadratic" } else { "" };
            let share = random.random_range(0.3..0.8);
            let far_side = random.random_bool(0.5);
            let springs: Vec<_> = model.springdampers.iter().collect();
            let joint = !slides.is_empty() && random.random_bool(0.5);
            // Range of displacement of the programme, from the design position.
            let (address, pair, (low, high), words) = if joint {
                let joint = pick(&slides, random);
                let pair = (joint.i, joint.j);
                let range = (ranges.of)(pair, 2);
                (
                    format!("JOINT/{}", joint.header.id),
                    pair,
                    range,
                    ["plus", "minus"],
                )
            } else {
                let spring = pick(&springs, random);
                let pair = (spring.i, spring.j);
                let range = (ranges.length)(pair);
                (
                    format!("SPRINGDAMPER/{}", spring.header.id),
                    pair,
                    range,
                    ["rebound", "bump"],
                )
            };
            let design = super::trial::at_design(model, pair, joint);
            let clearance = if far_side {
                low + share * (high - low) - design
            } else {
                design - (high - share * (high - low))
            };
            let word = words[usize::from(!far_side)];
            let base = if foreign { 2.0 } else { 20.0 };
            let pieces = vec![
                text(format!("clearance={clearance:.6},side={word},stiffness=")),
                Piece::Grows(base),
                text(law),
            ];
            (address, pieces, 50.0)
        }
        "load-gain" => {
            let gain = Piece::Factor(0.02 * sign(random));
            let pieces = vec![text("gain="), gain, text(growing)];
            ((*pick(&loads, random)).to_string(), pieces, 8.0)
        }
        "load-crosstalk" => {
            let to = random.random_range(0..3);
            let from = (to + random.random_range(1..3)) % 3;
            let fraction = Piece::Grows(0.01 * sign(random));
            let pieces = vec![text("fraction="), fraction, text(growing)];
            (format!("{}<-{}", loads[to], loads[from]), pieces, 8.0)
        }
        "load-point-error" => {
            let target = &model.sforces[0];
            let id = model.markers[target.i.0].header.id;
            let mut pieces = shift(direction(random), 3.0);
            pieces.push(text(growing));
            (format!("MARKER/{id}"), pieces, 8.0)
        }
        "frame-drift" => {
            let case = pick(cases, random);
            let mut pieces = shift(direction(random), 0.1);
            if foreign {
                pieces.push(text(",creep=1"));
            }
            (format!("case {case}"), pieces, 30.0)
        }
        "mark-outlier" => {
            let case = pick(cases, random);
            let (part, labels) = pick(&ranges.marks, random);
            let mark = pick(labels, random);
            let address = format!("case {case} {part} {mark}");
            (address, shift(direction(random), 0.5), 30.0)
        }
        "channel-fault" => {
            let name = pick(&["height", "travel"], random);
            let pieces = if foreign {
                // Both gain and zero are wrong.
                vec![
                    text("gain="),
                    Piece::Factor(0.002 * sign(random)),
                    text(",offset="),
                    Piece::Grows(0.1 * sign(random)),
                ]
            } else if random.random_bool(0.5) {
                vec![text("gain="), Piece::Factor(0.002 * sign(random))]
            } else {
                let case = pick(cases, random);
                vec![
                    text(format!("case={case},offset=")),
                    Piece::Grows(0.5 * sign(random)),
                ]
            };
            ((*name).to_string(), pieces, 100.0)
        }
        "creep" => {
            let (address, _, _) = component(random, 3);
            let pieces = vec![text("rate="), Piece::Grows(0.02)];
            (address, pieces, 15.0)
        }
        "free-play" => {
            let (address, (low, high), _) = component(random, 3);
            let pieces = vec![text("gap="), Piece::Grows(0.1 * (high - low))];
            (address, pieces, 10.0)
        }
        "part-flexibility" => {
            let carrier = plan.axle.carrier();
            let part = model.parts.iter().position(|p| p.header.id == carrier);
            let on = |m: &MarkerIx| Some(model.markers[m.0].part.0) == part;
            let joints = model.joints.iter().flat_map(|o| [o.i, o.j]);
            let held = model.bushings.iter().flat_map(|o| [o.i, o.j]);
            let ends: Vec<MarkerIx> = joints.chain(held).filter(on).collect();
            let id = model.markers[pick(&ends, random).0].header.id;
            let mode = pick(&["both", "bend", "twist"], random);
            let pieces = vec![
                text(format!("marker={id},mode={mode},stiffness=")),
                Piece::Shrinks(1e9),
            ];
            (format!("PART/{carrier}"), pieces, 100.0)
        }
        "asymmetric-friction" => {
            let (address, (low, high), k) = component(random, 3);
            let slip = random.random_range(0.01_f64.ln()..0.3_f64.ln()).exp();
            let force = 0.1 * k * (high - low);
            let pieces = vec![
                text("force="),
                Piece::Grows(force),
                text(",back="),
                Piece::Grows(0.1 * force),
                text(",stiffness="),
                Piece::Grows(force / (slip * (high - low))),
            ];
            (address, pieces, 8.0)
        }
        "thermal-drift" => {
            let pieces = vec![text("growth="), Piece::Grows(1e-4 * sign(random))];
            ("rig".to_string(), pieces, 50.0)
        }
        _ => {
            // An exchange of marks has a fixed size.
            let a = random.random_range(0..ranges.marks.len());
            let b = (a + random.random_range(1..ranges.marks.len())) % ranges.marks.len();
            let from = &cases[random.random_range(cases.len() / 3..cases.len() - 2)];
            let address = format!("{}<->{}", ranges.marks[a].0, ranges.marks[b].0);
            (address, vec![text(format!("from={from}"))], 1.0)
        }
    };
    Plant {
        cause,
        address,
        // The third-order terms of a coupling belong to its hypothesis, so this law is not foreign.
        foreign: foreign && cause != "bushing-coupling",
        // Smaller effects may be within a tolerance: 2 mm of a point, 2.5 percent of a load.
        form: Form {
            pieces,
            most,
            least: match cause {
                "hardpoint-error" => 2.0,
                "load-gain" => 1.25,
                _ => 0.0,
            },
        },
        wanted,
    }
}
