//! Random trees and loops of joints, their motion, and their conserved quantities.

use std::fmt::Write as _;

use admire_solver::mechanics::{Vec3, Vec6};
use admire_solver::model::{Model, PartIx};
use admire_solver::motion::{Consistent, Integrator, Kept, MotionSettings, assemble};
use admire_solver::system::{Parameters, State, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;

/// Random numbers of one seed, uniform in -1 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        // SplitMix64 of Steele, Lea and Flood.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, n: usize) -> usize {
        ((0.5 * self.next() + 0.5) * n as f64) as usize % n
    }

    fn three(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| size * self.next())
    }
}

const JOINTS: [&str; 6] = [
    "SPHERICAL",
    "REVOLUTE",
    "TRANSLATIONAL",
    "CYLINDRICAL",
    "HOOKE",
    "PLANAR",
];

/// Returns a deck of parts in a tree of joints, sometimes closed to a loop. If `grounded`, the first part hangs on ground, under gravity.
pub fn mechanism(seed: u64, grounded: bool) -> String {
    let mut draw = Draw(seed);
    let parts = 2 + draw.below(5);
    let mut text = String::from(
        "conserved\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n",
    );
    let mut origins = vec![[0.0; 3]];
    for k in 1..=parts {
        let origin = draw.three(1.0);
        let (a, b, c) = (
            0.2 + draw.next().abs(),
            0.2 + draw.next().abs(),
            0.2 + draw.next().abs(),
        );
        let [x, y, z] = origin;
        let v = draw.three(1.0);
        let w = draw.three(1.5);
        _ = writeln!(
            text,
            "PART/{id}, MASS={}, CM={cm}, IP={},{},{}, QG={x},{y},{z}, VX={}, VY={}, VZ={}, WX={}, WY={}, WZ={}",
            1.0 + 0.8 * draw.next(),
            b + c,
            a + c,
            a + b,
            v[0],
            v[1],
            v[2],
            w[0],
            w[1],
            w[2],
            id = 100 * k,
            cm = 100 * k + 1,
        );
        let [x, y, z] = draw.three(0.3);
        _ = writeln!(
            text,
            "MARKER/{}, PART={}, QP={x},{y},{z}",
            100 * k + 1,
            100 * k
        );
        origins.push(origin);
    }
    let mut marker = 1000;
    let mut joint = 0;
    let mut join = |text: &mut String, draw: &mut Draw, a: usize, b: usize| {
        let at = draw.three(1.0);
        let angles = draw.three(3.0);
        for part in [a, b] {
            marker += 1;
            let o = origins[part];
            _ = writeln!(
                text,
                "MARKER/{marker}, PART={}, QP={:.17},{:.17},{:.17}, REULER={},{},{}",
                if part == 0 { 1 } else { 100 * part },
                at[0] - o[0],
                at[1] - o[1],
                at[2] - o[2],
                angles[0],
                angles[1],
                angles[2]
            );
        }
        joint += 1;
        let kind = JOINTS[draw.below(JOINTS.len())];
        _ = writeln!(
            text,
            "JOINT/{joint}, {kind}, I={}, J={}",
            marker - 1,
            marker
        );
    };
    for k in 1..=parts {
        if k > 1 || grounded {
            let before = if k == 1 { 0 } else { 1 + draw.below(k - 1) };
            join(&mut text, &mut draw, k, before);
        }
    }
    // About half of the larger trees get a loop, through ground if the tree is grounded.
    if parts > 3 && draw.below(2) == 0 {
        join(&mut text, &mut draw, parts, usize::from(!grounded));
    }
    if grounded {
        text += "ACCGRAV/KGRAV=-9.81\n";
    }
    text + "END\n"
}

pub struct Case {
    pub system: System,
    parameters: Parameters,
    model: Model,
}

impl Case {
    pub fn of(text: &str) -> Self {
        let dataset = Dataset::parse(Source::new("conserved.adm", text.as_bytes().to_vec()));
        assert!(!dataset.has_errors(), "{:#?}", dataset.diagnostics);
        let model = Model::lower(&dataset.value).value;
        let compiled = System::compile(&model);
        assert!(!compiled.has_errors(), "{:#?}", compiled.diagnostics);
        Self {
            parameters: compiled.value.parameters(),
            system: compiled.value,
            model,
        }
    }

    pub fn begun(&self, mut state: State, kept: Kept) -> State {
        let mut memory = Consistent::new(&self.system);
        assemble(
            &self.system,
            &self.parameters,
            &mut state,
            &mut memory,
            kept,
            1e-4,
        )
        .unwrap();
        state
    }

    pub fn integrated(&self, state: State, error: f64, end: f64) -> State {
        let settings = MotionSettings {
            error,
            hinit: 1e-3,
            hmax: 0.1,
            hmin: 1e-10,
            output: 0.1,
            maxit: 10,
            corrector: 1.0,
            adaptivity: 0.0,
        };
        let mut integrator = Integrator::new(&self.system, &self.parameters, state, settings);
        integrator.advance_to(end).unwrap();
        integrator.output().unwrap()
    }

    /// Returns the energy, the kinetic energy, the momentum, and the moment of momentum about the ground origin.
    pub fn balance(&self, state: &State) -> (f64, f64, Vec3, Vec3) {
        let (mut energy, mut kinetic) = (0.0, 0.0);
        let (mut linear, mut about) = (Vec3::zeros(), Vec3::zeros());
        for (k, part) in self.model.parts.iter().enumerate().skip(1) {
            let M = self.system.mass_matrix(&self.parameters, state, PartIx(k));
            let (v, w) = (state.velocities[k].linear, state.velocities[k].angular);
            let V = Vec6::new(v.x, v.y, v.z, w.x, w.y, w.z);
            let p = M * V;
            let P = Vec3::new(p[0], p[1], p[2]);
            kinetic += 0.5 * V.dot(&p);
            linear += P;
            about += Vec3::new(p[3], p[4], p[5]) + state.poses[k].p.cross(&P);
            let cm = &self.model.markers[part.cm.unwrap().0];
            let at = state.poses[k].point(&cm.qp);
            energy -= part.mass * self.model.gravity.dot(&at);
        }
        (energy + kinetic, kinetic, linear, about)
    }
}

/// Returns the relative change of energy over a motion, with 1 plus the larger kinetic energy of start and end as the scale.
pub fn energy_off(seed: u64, error: f64, end: f64) -> f64 {
    let case = Case::of(&mechanism(seed, true));
    let start = case.begun(case.system.state(), Kept::Data);
    let before = case.balance(&start);
    let after = case.balance(&case.integrated(start, error, end));
    (after.0 - before.0).abs() / (1.0 + before.1.max(after.1))
}
