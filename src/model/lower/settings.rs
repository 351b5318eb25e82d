use super::reader::Reader;
use crate::diagnostic::{Code, Diagnostic};
use crate::mechanics::Vec3;
use crate::model::{
    EquilibriumSettings, IntegratorSettings, KinematicsSettings, Model, OutputSettings,
    ResultsSettings, StaticMethod,
};
use crate::units::{FORCE_UNITS, LENGTH_UNITS, MASS_UNITS, TIME_UNITS, Unit, Units};

/// Statements without an id: what they change of the model. False if the statement is none of them.
pub(super) fn settings(reader: &mut Reader, model: &mut Model) -> bool {
    match reader.def.name {
        "ACCGRAV" => model.gravity = gravity(reader, model.gravity),
        "UNITS" => model.units = units(reader),
        "EQUILIBRIUM" => model.equilibrium = equilibrium(reader, &model.equilibrium),
        "INTEGRATOR" => model.integrator = integrator(reader, &model.integrator),
        "KINEMATICS" => model.kinematics = kinematics(reader, &model.kinematics),
        "OUTPUT" => model.output = output(reader, &model.output),
        "RESULTS" => model.results = results(reader, &model.results),
        _ => return false,
    }
    true
}

fn gravity(reader: &Reader, old: Vec3) -> Vec3 {
    Vec3::new(
        reader.real("IGRAV", Some(old.x)),
        reader.real("JGRAV", Some(old.y)),
        reader.real("KGRAV", Some(old.z)),
    )
}

/// UNITS: four units, a system, or a consistency factor alone (guide/formats.md 2.15).
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
    } else if reader.any(&["FORCE", "MASS", "LENGTH", "TIME"]) {
        let diagnostic = Diagnostic::error(
            Code::MissingArgument,
            "UNITS needs FORCE, MASS, LENGTH and TIME together",
        );
        reader.complain(diagnostic, reader.statement.keyword);
    }
    if let Some(ucf) = reader.statement.first("UCF") {
        units.ucf = ucf;
    }
    units
}

fn equilibrium(reader: &Reader, old: &EquilibriumSettings) -> EquilibriumSettings {
    let default = EquilibriumSettings::default();
    let old = if reader.flag("DEFAULT", false) {
        &default
    } else {
        old
    };
    let method = reader.choice("STATIC_METHOD").or(reader.choice("METHOD"));
    EquilibriumSettings {
        alimit: reader.real("ALIMIT", Some(old.alimit)),
        tlimit: reader.real("TLIMIT", Some(old.tlimit)),
        error: reader.real("ERROR", Some(old.error)),
        imbalance: reader.real("IMBALANCE", Some(old.imbalance)),
        maxit: reader.real("MAXIT", Some(old.maxit as f64)) as usize,
        maxit_stated: old.maxit_stated || reader.given("MAXIT").is_some(),
        pattern: match reader.choices("PATTERN") {
            Some(words) if !words.is_empty() => words.iter().map(|word| *word == "TRUE").collect(),
            _ => old.pattern.clone(),
        },
        stability: reader.real("STABILITY", Some(old.stability)),
        method: match method {
            Some("ADVANCED") => StaticMethod::Advanced,
            Some("AGGRESSIVE") => StaticMethod::Aggressive,
            Some("ALL") => StaticMethod::All,
            Some(_) => StaticMethod::Original,
            None => old.method,
        },
    }
}

/// Arguments of INTEGRATOR that only ADAMS' own methods know.
const WITHOUT_EFFECT: [&str; 10] = [
    "KMAX", "PATTERN", "FIXIT", "HRATIO", "MAXERR", "SCALE", "CRATIO", "ALPHA", "BETA", "GAMMA",
];

fn integrator(reader: &Reader, old: &IntegratorSettings) -> IntegratorSettings {
    let default = IntegratorSettings::default();
    let old = if reader.flag("DEFAULT", false) {
        &default
    } else {
        old
    };
    let named = |words: &[&'static str], old: &'static str| {
        let found = words
            .iter()
            .copied()
            .find(|word| reader.statement.has(word));
        found.unwrap_or(old)
    };
    let number = |name: &str, old: Option<f64>| reader.statement.first(name).or(old);
    let mut without_effect = old.without_effect.clone();
    for word in WITHOUT_EFFECT {
        if reader.statement.has(word) && !without_effect.contains(&word) {
            without_effect.push(word);
        }
    }
    IntegratorSettings {
        method: named(
            &[
                "GSTIFF",
                "WSTIFF",
                "HASTIFF",
                "HHT",
                "NEWMARK",
                "ABAM",
                "CONSTANT_BDF",
                "DSTIFF",
                "RKF45",
            ],
            old.method,
        ),
        formulation: named(&["I3", "SI2", "SI1"], old.formulation),
        corrector: match reader.choice("CORRECTOR") {
            Some("MODIFIED") => "MODIFIED",
            Some("ORIGINAL") => "ORIGINAL",
            Some(_) => "ORIG_CONSTANT",
            None => old.corrector,
        },
        error: number("ERROR", old.error),
        hinit: number("HINIT", old.hinit),
        hmax: number("HMAX", old.hmax),
        hmin: number("HMIN", old.hmin),
        maxit: number("MAXIT", old.maxit.map(|n| n as f64)).map(|n| n as usize),
        adaptivity: reader.real("ADAPTIVITY", Some(old.adaptivity)),
        interpolate: reader
            .choice("INTERPOLATE")
            .map_or(old.interpolate, |word| word == "ON"),
        without_effect,
    }
}

fn kinematics(reader: &Reader, old: &KinematicsSettings) -> KinematicsSettings {
    let default = KinematicsSettings::default();
    let old = if reader.flag("DEFAULT", false) {
        &default
    } else {
        old
    };
    let maxit = reader.statement.first("MAXIT").map(|n| n as usize);
    KinematicsSettings {
        hmax: reader.statement.first("HMAX").or(old.hmax),
        maxit: maxit.or(old.maxit),
    }
}

fn output(reader: &Reader, old: &OutputSettings) -> OutputSettings {
    OutputSettings {
        reqsave: reader.flag("REQSAVE", old.reqsave) && !reader.flag("NOREQSAVE", false),
        grsave: reader.flag("GRSAVE", old.grsave) && !reader.flag("NOGRSAVE", false),
        noprint: reader.flag("NOPRINT", old.noprint),
        noseparator: reader.flag("NOSEPARATOR", old.noseparator)
            && !reader.flag("SEPARATOR", false),
        ypr: reader.flag("YPR", old.ypr),
        fixed: reader.flag("FIXED", old.fixed),
        teletype: reader.flag("TELETYPE", old.teletype),
        zero: std::array::from_fn(|k| {
            reader.real(["DZERO", "VZERO", "AZERO", "FZERO"][k], Some(old.zero[k]))
        }),
    }
}

fn results(reader: &Reader, old: &ResultsSettings) -> ResultsSettings {
    ResultsSettings {
        present: true,
        xrf: reader.flag("XRF", old.xrf),
        formatted: reader.flag("FORMATTED", old.formatted),
        comment: reader
            .text("COMMENT", Some(old.comment.clone()))
            .unwrap_or_default(),
        decimal_places: reader.real("DECIMALPLACES", Some(old.decimal_places as f64)) as usize,
        no_displacements: reader.flag("NODISPLACEMENTS", old.no_displacements),
        no_velocities: reader.flag("NOVELOCITIES", old.no_velocities),
        no_accelerations: reader.flag("NOACCELERATIONS", old.no_accelerations),
        no_reaction_forces: reader.flag("NOREACTIONFORCES", old.no_reaction_forces),
        no_applied_forces: reader.flag("NOAPPLIEDFORCES", old.no_applied_forces),
        no_system_elements: reader.flag("NOSYSTEMELEMENTS", old.no_system_elements),
        no_requests: reader.flag("NOREQUESTS", old.no_requests),
        no_floating_markers: reader.flag("NOFLOATINGMARKERS", old.no_floating_markers),
    }
}
