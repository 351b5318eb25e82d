//! Plants an effect on the reference deck of a shipped study and writes the readings that a rig would have taken.

use std::fmt::Write as _;
use std::path::Path;

use admire_identify::LoadedStudy;
use admire_session::backend::{Backend, LoadProgramme, NativeBackend, SweepRequest};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_syntax::Dataset;
use admire_syntax::text::Source;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};

/// A planted effect.
pub struct Plant {
    /// True cause and address.
    pub truth: (&'static str, &'static str),
    /// Replacements in the text of the reference deck.
    pub edits: Vec<(&'static str, String)>,
    /// Statements to be added before END.
    pub added: String,
    /// Change of the loads of a case.
    pub loads: fn(&mut [f64]),
    /// Change of a reading, given case, part, mark and position.
    pub reading: fn(usize, usize, usize, &mut [f64; 3]),
    /// A friction contact with memory.
    pub friction: Option<Friction>,
    /// Markers to be rotated: id, own axis, angle in degrees.
    pub turned: Vec<(u32, usize, f64)>,
    /// A string potentiometer between two markers: name, I, J, and the reading as a function of the true distance.
    pub channel: Option<(&'static str, u32, u32, fn(f64) -> f64)>,
}

/// Law of the friction force against displacement.
#[derive(Clone, Copy, PartialEq)]
pub enum FrictionLaw {
    /// A spring in series with a slider.
    ElastoSlip,
    /// Law of Dahl (1968) with exponent one: `dF/du = k (1 - F sign(du) / F_slip)`.
    Dahl,
}

/// Friction along an axis of J.
#[derive(Clone, Copy)]
pub struct Friction {
    pub law: FrictionLaw,
    pub force: f64,
    pub stiffness: f64,
    pub i: u32,
    pub j: u32,
    pub part_of_j: u32,
    pub axis: usize,
}

impl Plant {
    pub fn nothing() -> Self {
        Self {
            truth: ("", ""),
            edits: Vec::new(),
            added: String::new(),
            loads: |_| {},
            reading: |_, _, _, _| {},
            friction: None,
            turned: Vec::new(),
            channel: None,
        }
    }
}

/// Returns a GFORCE along one axis of J, with its floating marker.
pub fn gforce(part_of_j: u32, (i, j): (u32, u32), axis: usize, law: &str) -> String {
    let mut text = format!(
        "MARKER/990, PART = {part_of_j}, FLOATING\nGFORCE/990\n, I = {i}\n, JFLOAT = 990\n, RM = {j}\n"
    );
    for (k, word) in ["FX", "FY", "FZ", "TX", "TY", "TZ"].into_iter().enumerate() {
        let law = if k == axis { law } else { "0.0" };
        let end = if k < 5 { "\\" } else { "" };
        text += &format!(", {word} = {law}{end}\n");
    }
    text
}

/// Writes a study folder that does not reveal the planted effect.
pub fn study(
    name: &str,
    plant: &Plant,
    sigma: f64,
    seed: u64,
    loads: Option<&str>,
) -> tempfile::TempDir {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap() != "reference.adm" {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let path = |file: &str| folder.path().join(file);
    let toml = std::fs::read_to_string(path("study.toml")).unwrap();
    let toml = toml.replace("[reference]\ndeck = \"reference.adm\"\n", "");
    std::fs::write(
        path("study.toml"),
        toml.replace("sigma = 0.05", &format!("sigma = {sigma}")),
    )
    .unwrap();
    if let Some(loads) = loads {
        std::fs::write(path("load_cases.csv"), loads).unwrap();
    }
    let mut text = std::fs::read_to_string(shipped.join("reference.adm")).unwrap();
    for (from, to) in &plant.edits {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let end = text.rfind("END").unwrap();
    text.insert_str(end, &plant.added);
    for (marker, axis, degrees) in &plant.turned {
        text = turned(&text, *marker, *axis, *degrees);
    }
    // The case labels must exist in the readings before these are simulated.
    let cases = std::fs::read_to_string(path("load_cases.csv")).unwrap();
    let mut marks = String::from("case,part,mark,x,y,z\n");
    let first = std::fs::read_to_string(path("marks_on_parts.csv")).unwrap();
    for case in cases.lines().skip(1) {
        let label = case.split(',').next().unwrap();
        for mark in first.lines().skip(1) {
            let mut words = mark.split(',');
            let (part, mark) = (words.next().unwrap(), words.next().unwrap());
            writeln!(marks, "{label},{part},{mark},0,0,0").unwrap();
        }
    }
    std::fs::write(path("marks_measured.csv"), marks).unwrap();
    if let Some((name, i, j, _)) = plant.channel {
        let toml = std::fs::read_to_string(path("study.toml")).unwrap();
        let channel = format!(
            "[readings]\nfile = \"readings.csv\"\n[readings.channels]\n{name} = {{ function = \"DM({i},{j})\", sigma = {sigma} }}\n"
        );
        std::fs::write(path("study.toml"), toml + &channel).unwrap();
        let mut readings = format!("case,{name}\n");
        for case in cases.lines().skip(1) {
            writeln!(readings, "{},0", case.split(',').next().unwrap()).unwrap();
        }
        std::fs::write(path("readings.csv"), readings).unwrap();
    }
    let loaded = LoadedStudy::read(folder.path()).value.unwrap();
    let mut programme = loaded.programme.clone();
    for case in &mut programme.cases {
        (plant.loads)(&mut case.values);
    }
    let poses = match &plant.friction {
        None => sweep(&text, &programme),
        Some(friction) => slipping(&text, &programme, friction),
    };
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let noise = Normal::new(0.0, sigma).unwrap();
    let mut marks = String::from("case,part,mark,x,y,z\n");
    for (case, poses) in poses.iter().enumerate() {
        for (p, part) in loaded.measurement.parts.iter().enumerate() {
            for (m, mark) in part.marks.iter().enumerate() {
                let x = poses[part.part.0].point(&mark.p);
                let mut x: [f64; 3] = x.into();
                for x in &mut x {
                    *x += noise.sample(&mut random);
                }
                (plant.reading)(case, p, m, &mut x);
                let label = &loaded.measurement.cases[case].label;
                writeln!(
                    marks,
                    "{label},{},{},{:.9},{:.9},{:.9}",
                    part.name, mark.label, x[0], x[1], x[2]
                )
                .unwrap();
            }
        }
    }
    std::fs::write(path("marks_measured.csv"), marks).unwrap();
    if let Some((name, i, j, read)) = plant.channel {
        let (_, model) = deck(&text);
        let mut readings = format!("case,{name}\n");
        for (case, poses) in poses.iter().enumerate() {
            let distance = (place(&model, poses, i).p - place(&model, poses, j).p).norm();
            let value = read(distance) + noise.sample(&mut random);
            let label = &loaded.measurement.cases[case].label;
            writeln!(readings, "{label},{value:.9}").unwrap();
        }
        std::fs::write(path("readings.csv"), readings).unwrap();
    }
    folder
}

/// Returns the global pose of a marker.
fn place(model: &Model, poses: &[Pose], id: u32) -> Pose {
    let marker = &model.markers[model.marker(id).unwrap().0];
    poses[marker.part.0].compose(&Pose {
        p: marker.qp,
        R: marker.R,
    })
}

/// Returns the deck with a marker rotated on its part.
fn turned(text: &str, id: u32, axis: usize, degrees: f64) -> String {
    let (dataset, model) = deck(text);
    let marker = &model.markers[model.marker(id).unwrap().0];
    let rotation = marker.R * admire_solver::mechanics::exp(&Vec3::ith(axis, degrees.to_radians()));
    let angles = admire_solver::mechanics::psi_theta_phi(&rotation);
    let mut dataset = dataset;
    for (k, angle) in angles.into_iter().enumerate() {
        let address = format!("MARKER/{id}.REULER.{}", k + 1);
        let address = admire_syntax::Address::parse(&address, &dataset).unwrap();
        let edits = dataset.set(&address, angle).unwrap();
        dataset = dataset.edited(&edits).unwrap().value;
    }
    String::from_utf8(dataset.bytes().to_vec()).unwrap()
}

fn deck(text: &str) -> (Dataset, Model) {
    let dataset = Dataset::parse(Source::new(
        "planted.adm".to_string(),
        text.as_bytes().to_vec(),
    ))
    .value;
    let lowered = admire_solver::model::lower(&dataset);
    assert!(!lowered.has_errors(), "{:?}", lowered.diagnostics);
    (dataset, lowered.value)
}

fn sweep(text: &str, programme: &LoadProgramme) -> Vec<Vec<Pose>> {
    let (dataset, model) = deck(text);
    let request = SweepRequest {
        dataset: &dataset,
        model: &model,
        theta: &[],
        programme,
    };
    let swept = NativeBackend::new().sweep(&request).unwrap();
    (0..programme.cases.len())
        .map(|case| swept.equilibrium(case).unwrap().poses.clone())
        .collect()
}

/// Simulates friction case by case; each case passes its anchor or its force on to the next.
fn slipping(text: &str, programme: &LoadProgramme, friction: &Friction) -> Vec<Vec<Pose>> {
    let Friction {
        law,
        force,
        stiffness,
        i,
        j,
        part_of_j,
        axis,
    } = friction;
    // The memory of elasto-slip is the anchor of its unstretched spring; the memory of Dahl's law is the last position and force.
    let (mut anchor, mut held, mut out) = (0.0, 0.0, Vec::new());
    let end = text.rfind("END").unwrap();
    let measure = ["DX", "DY", "DZ"][*axis];
    let u = format!("({measure}({i},{j},{j})-({anchor:.1}))");
    for case in &programme.cases {
        let u = u.replace("(0.0)", &format!("({anchor:.12})"));
        let text_of_law = match law {
            FrictionLaw::ElastoSlip => {
                format!("-MAX(-{force:.6},MIN({force:.6},{stiffness:.6}*{u}))")
            }
            FrictionLaw::Dahl => {
                let (up, down) = (held - force, held + force);
                format!(
                    "-IF({u}:({down:.12})*EXP({stiffness:.6}*{u}/{force:.6})-{force:.6},{held:.12},{force:.6}+({up:.12})*EXP(-{stiffness:.6}*{u}/{force:.6}))"
                )
            }
        };
        let mut components = ["0.0"; 6].map(str::to_string);
        components[*axis] = text_of_law;
        let names = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
        let listed: Vec<String> = names
            .iter()
            .zip(&components)
            .map(|(n, c)| format!(", {n} = {c}"))
            .collect();
        let added = format!(
            "MARKER/990, PART = {part_of_j}, FLOATING\nGFORCE/990\n, I = {i}\n, JFLOAT = 990\n, RM = {j}\n{}\n",
            listed.join("\\\n")
        );
        let mut deck_text = text.to_string();
        deck_text.insert_str(end, &added);
        let one = LoadProgramme {
            cases: vec![case.clone()],
            loads: programme.loads.clone(),
        };
        let poses = sweep(&deck_text, &one).remove(0);
        let (_, model) = deck(&deck_text);
        let (a, b) = (place(&model, &poses, *i), place(&model, &poses, *j));
        let u = (b.R.transpose() * (a.p - b.p))[*axis];
        match law {
            FrictionLaw::ElastoSlip => {
                let slip = force / stiffness;
                anchor = u - (u - anchor).clamp(-slip, slip);
            }
            FrictionLaw::Dahl => {
                let (du, rate) = (u - anchor, stiffness / force);
                let sign = du.signum();
                held = force * sign - (force * sign - held) * (-rate * du.abs()).exp();
                anchor = u;
            }
        }
        out.push(poses);
    }
    out
}
