use super::reader::Reader;
use crate::mechanics::Vec3;
use crate::model::{
    EquilibriumSettings, IntegratorSettings, KinematicsSettings, Model, OutputSettings,
    ResultsSettings, StaticMethod,
};
use admire_syntax::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units};

/// Applies the current form of a statement without an id to the model.
pub(super) fn settings(reader: &mut Reader, model: &mut Model) {
    match reader.def.name {
        "ACCGRAV" => model.gravity = gravity(reader),
        "UNITS" => model.units = units(reader),
        "EQUILIBRIUM" => model.equilibrium = equilibrium(reader),
        "INTEGRATOR" => model.integrator = integrator(reader),
        "KINEMATICS" => model.kinematics = kinematics(reader),
        "IC" => model.initial_conditions = given_but(reader, &[]),
        "OUTPUT" => model.output = output(reader),
        "RESULTS" => model.results = results(reader),
        _ => {}
    }
}

fn gravity(reader: &Reader) -> Vec3 {
    Vec3::new(
        reader.real("IGRAV"),
        reader.real("JGRAV"),
        reader.real("KGRAV"),
    )
}

/// Lowers UNITS: four units, a unit system, or only a units consistency factor (guide/formats.md 2.15). A consistency factor can also be
/// combined with the other forms.
fn units(reader: &mut Reader) -> Units {
    let named = |table: &[Unit], word: &str| {
        table
            .iter()
            .find(|unit| {
                unit.keyword == word || word.strip_suffix('S').is_some_and(|w| unit.keyword == w)
            })
            .copied()
    };
    let system: Option<[&str; 4]> = match reader.choice("SYSTEM") {
        Some("CGS") => Some(["DYNE", "GRAM", "CENTIMETER", "SECOND"]),
        Some("FPS") => Some(["POUND_FORCE", "SLUG", "FOOT", "SECOND"]),
        Some("IPS") => Some(["POUND_FORCE", "SLINCH", "INCH", "SECOND"]),
        Some("MKS") => Some(["NEWTON", "KILOGRAM", "METER", "SECOND"]),
        _ => None,
    };
    let words = ["FORCE", "MASS", "LENGTH", "TIME"].map(|name| reader.choice(name));
    let words = match (system, words) {
        (Some(system), _) => Some(system),
        (None, [Some(force), Some(mass), Some(length), Some(time)]) => {
            Some([force, mass, length, time])
        }
        _ => None,
    };
    let mut units = Units::default();
    if let Some([force, mass, length, time]) = words {
        let tables = (
            named(FORCE_UNITS, force),
            named(MASS_UNITS, mass),
            named(LENGTH_UNITS, length),
            named(TIME_UNITS, time),
        );
        if let (Some(force), Some(mass), Some(length), Some(time)) = tables {
            units = Units::new(force, mass, length, time);
        }
    }
    if let Some(ucf) = reader.first("UCF") {
        units.ucf = ucf;
    }
    units
}

fn equilibrium(reader: &Reader) -> EquilibriumSettings {
    let default = EquilibriumSettings::default();
    let method = reader.choice("STATIC_METHOD").or(reader.choice("METHOD"));
    EquilibriumSettings {
        alimit: reader.real("ALIMIT"),
        tlimit: reader.real("TLIMIT"),
        error: reader.real("ERROR"),
        imbalance: reader.real("IMBALANCE"),
        maxit: reader.real("MAXIT") as usize,
        maxit_stated: reader.has("MAXIT"),
        pattern: match reader.choices("PATTERN") {
            Some(words) if !words.is_empty() => words.iter().map(|word| *word == "TRUE").collect(),
            _ => default.pattern,
        },
        stability: reader.real("STABILITY"),
        method: match method {
            Some("ADVANCED") => StaticMethod::Advanced,
            Some("AGGRESSIVE") => StaticMethod::Aggressive,
            Some("ALL") => StaticMethod::All,
            _ => StaticMethod::Original,
        },
    }
}

/// Arguments of INTEGRATOR that apply only to the methods of ADAMS itself.
const WITHOUT_EFFECT: [&str; 10] = [
    "KMAX", "PATTERN", "FIXIT", "HRATIO", "MAXERR", "SCALE", "CRATIO", "ALPHA", "BETA", "GAMMA",
];

fn integrator(reader: &Reader) -> IntegratorSettings {
    const METHODS: [&str; 9] = [
        "GSTIFF",
        "WSTIFF",
        "HASTIFF",
        "HHT",
        "NEWMARK",
        "ABAM",
        "CONSTANT_BDF",
        "DSTIFF",
        "RKF45",
    ];
    let default = IntegratorSettings::default();
    let named = |words: &[&'static str]| reader.latest(words).next();
    let stated = |word: &&str| reader.has(word);
    IntegratorSettings {
        method: named(&METHODS).unwrap_or(default.method),
        formulation: named(&["I3", "SI2", "SI1"]).unwrap_or(default.formulation),
        corrector: match reader.choice("CORRECTOR") {
            Some("MODIFIED") => "MODIFIED",
            Some("ORIGINAL") => "ORIGINAL",
            Some(_) => "ORIG_CONSTANT",
            None => default.corrector,
        },
        error: reader.first("ERROR"),
        hinit: reader.first("HINIT"),
        hmax: reader.first("HMAX"),
        hmin: reader.first("HMIN"),
        maxit: reader.first("MAXIT").map(|n| n as usize),
        adaptivity: reader.real("ADAPTIVITY"),
        interpolate: reader.choice("INTERPOLATE") == Some("ON"),
        without_effect: WITHOUT_EFFECT.into_iter().filter(stated).collect(),
    }
}

fn kinematics(reader: &Reader) -> KinematicsSettings {
    KinematicsSettings {
        hmax: reader.first("HMAX"),
        without_effect: given_but(reader, &["HMAX"]),
    }
}

/// Returns the arguments that are given, except those in `used` and the arguments DEFAULT and LIST.
fn given_but(reader: &Reader, used: &[&str]) -> Vec<&'static str> {
    let names = reader.def.arguments.iter().map(|argument| argument.name);
    let other = |name: &&str| !used.contains(name) && !["DEFAULT", "LIST"].contains(name);
    names
        .filter(other)
        .filter(|name| reader.has(name))
        .collect()
}

fn output(reader: &Reader) -> OutputSettings {
    OutputSettings {
        reqsave: reader.has("REQSAVE") && !reader.has("NOREQSAVE"),
        grsave: reader.has("GRSAVE") && !reader.has("NOGRSAVE"),
        noprint: reader.has("NOPRINT"),
        noseparator: reader.has("NOSEPARATOR") && !reader.has("SEPARATOR"),
        ypr: reader.has("YPR"),
        fixed: reader.has("FIXED"),
        teletype: reader.has("TELETYPE"),
        zero: ["DZERO", "VZERO", "AZERO", "FZERO"].map(|name| reader.first(name).unwrap_or(0.0)),
    }
}

fn results(reader: &Reader) -> ResultsSettings {
    let default = ResultsSettings::default();
    let places = reader.first("DECIMALPLACES").map(|n| n as usize);
    ResultsSettings {
        present: true,
        xrf: reader.has("XRF"),
        formatted: reader.has("FORMATTED"),
        comment: reader.text("COMMENT").unwrap_or_default(),
        decimal_places: places.unwrap_or(default.decimal_places),
        no_displacements: reader.has("NODISPLACEMENTS"),
        no_velocities: reader.has("NOVELOCITIES"),
        no_accelerations: reader.has("NOACCELERATIONS"),
        no_reaction_forces: reader.has("NOREACTIONFORCES"),
        no_applied_forces: reader.has("NOAPPLIEDFORCES"),
        no_system_elements: reader.has("NOSYSTEMELEMENTS"),
        no_requests: reader.has("NOREQUESTS"),
        no_floating_markers: reader.has("NOFLOATINGMARKERS"),
    }
}
