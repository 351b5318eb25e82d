//! Decks on the rig.

use std::path::Path;

use admire_kc::{Bench, Compliance, Config, Wheel};
use admire_solver::mechanics::Vec3;
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::files::Files;
use admire_syntax::text::Source;

pub struct Axle {
    pub dataset: Dataset,
    pub model: Model,
    pub config: Config,
    files: Files,
}

impl Axle {
    #[track_caller]
    pub fn new(deck: &str, toml: &str) -> Self {
        let dataset = Dataset::parse(Source::new("deck.adm", deck.as_bytes())).value;
        let model = Model::lower(&dataset).value;
        let source = Source::new("kc.toml", toml.as_bytes());
        let si = (model.units.length.si, model.units.force.si);
        let config = Config::read(&source, 1e-3 / si.0, 1.0 / si.1);
        assert!(config.diagnostics.is_empty(), "{:?}", config.diagnostics);
        Self {
            dataset,
            model,
            config: config.value.unwrap(),
            files: Files::default(),
        }
    }

    #[track_caller]
    pub fn bench(&self) -> Bench<'_> {
        Bench::new(&self.config, &self.dataset, &self.files, &self.model)
            .unwrap_or_else(|why| panic!("{why:?}"))
    }
}

/// Returns the largest translation per force, rotation per force and rotation per torque of a compliance matrix.
pub fn largest(c: &Compliance) -> [f64; 3] {
    [(0, 0), (1, 0), (1, 1)].map(|(row, column)| {
        let all = (0..12).flat_map(|i| (0..12).map(move |j| (i, j)));
        let block = all.filter(|(i, j)| i % 6 / 3 == row && j % 6 / 3 == column);
        block.map(|at| c.matrix[at].abs()).fold(0.0, f64::max)
    })
}

/// Returns the directions of the loads in a level road: rearward and to the right, relative to the heading of the wheel.
pub fn heading(wheel: &Wheel) -> [Vec3; 2] {
    let across = Vec3::new(wheel.spin.x, wheel.spin.y, 0.0).normalize();
    let right = across * wheel.side.outboard_sign();
    [right.cross(&Vec3::z()), right]
}

pub fn corpus(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    std::fs::read_to_string(path).unwrap()
}

pub const MCPHERSON: &str = "
[deck]
without = ['SFORCE/1', 'SFORCE/2', 'SFORCE/3']
[wheels]
mirror = true
left = { centre = 'WC', spin = 'y' }
[tyre]
radius = 300.0
stiffness = 220.0
[vehicle]
wheelbase = 2700.0
cg_height = 540.0
sprung_mass = 1500.0
front_brake = 0.6
front_drive = 1.0
[ride]
load = 4500.0
[choices]
steer_axis = 'instant-moment'
";

pub const MULTILINK: &str = MCPHERSON;

pub const DOUBLE_WISHBONE: &str = "
[deck]
without = ['MOTION/2', 'MOTION/3']
[wheels.left]
centre = 'MARKER/130'
spin = 'MARKER/134'
steer_axis = ['MARKER/131', 'MARKER/132']
[wheels.right]
centre = 'MARKER/230'
spin = 'MARKER/234'
steer_axis = ['MARKER/231', 'MARKER/232']
[steering]
lock = 'MOTION/1'
drive = 'MOTION/1'
[tyre]
radius = 300.0
stiffness = 200.0
[vehicle]
wheelbase = 2600.0
cg_height = 550.0
sprung_mass = 1400.0
front_brake = 0.7
front_drive = 0.0
[tests.lateral]
range = [-2000, 2000]
[tests.steering]
range = [-15, 15]
";

/// Returns the double wishbone of the corpus on rubber: bushings replace the revolute joints, and coil springs and an anti-roll bar are added.
pub fn double_wishbone() -> String {
    let mut deck = corpus("double-wishbone/model.adm");
    for joint in [11, 12, 21, 22] {
        let (from, rest) = deck
            .split_once(&format!("JOINT/{joint}\n, REVOLUTE\n"))
            .unwrap();
        deck = format!(
            "{from}BUSHING/{joint}\n, K = 8000, 8000, 5000, KT = 6.0E+08, 6.0E+08, 2.0E+04\n{rest}"
        );
    }
    let springs = "MARKER/150, PART = 11, QP = -267, -600, 150
MARKER/151, PART = 1, QP = -280, -560, 620
MARKER/250, PART = 21, QP = -267, 600, 150
MARKER/251, PART = 1, QP = -280, 560, 620
SPRINGDAMPER/1, I = 150, J = 151, TRANSLATION, K = 250, FORCE = 9000, LENGTH = 471.805
SPRINGDAMPER/2, I = 250, J = 251, TRANSLATION, K = 250, FORCE = 9000, LENGTH = 471.805
SFORCE/1, I = 150, J = 250, ACTIONONLY, TRANSLATION, FUNCTION = 0
END";
    // The anti-roll bar is a vertical force on each arm, proportional to the difference of the arms' heights.
    let bar = "GFORCE/1, I = 150, JFLOAT = 152, RM = 1\n, FX = 0\\\n, FY = 0\\\n, FZ = -15*(DZ(150,250,1))\\\n, TX = 0\\\n, TY = 0\\\n, TZ = 0
GFORCE/2, I = 250, JFLOAT = 252, RM = 1\n, FX = 0\\\n, FY = 0\\\n, FZ = 15*(DZ(150,250,1))\\\n, TX = 0\\\n, TY = 0\\\n, TZ = 0
MARKER/152, PART = 1, FLOATING
MARKER/252, PART = 1, FLOATING
END";
    let springs = springs.replace(
        "SFORCE/1, I = 150, J = 250, ACTIONONLY, TRANSLATION, FUNCTION = 0\nEND",
        bar,
    );
    deck.trim_end().strip_suffix("END").unwrap().to_string() + &springs + "\n"
}

/// Returns the double wishbone of the corpus with its rigid joints, on springs.
pub fn sprung_wishbone() -> String {
    let deck = corpus("double-wishbone/model.adm");
    deck.trim_end().strip_suffix("END").unwrap().to_string()
        + "MARKER/150, PART = 11, QP = -267, -600, 150
MARKER/151, PART = 1, QP = -280, -560, 620
MARKER/250, PART = 21, QP = -267, 600, 150
MARKER/251, PART = 1, QP = -280, 560, 620
SPRINGDAMPER/1, I = 150, J = 151, TRANSLATION, K = 250, FORCE = 9000, LENGTH = 471.805
SPRINGDAMPER/2, I = 250, J = 251, TRANSLATION, K = 250, FORCE = 9000, LENGTH = 471.805
END
"
}
