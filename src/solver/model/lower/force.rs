use super::reader::Reader;
use crate::model::{
    Bushing, Nforce, PairForce, Sforce, SforceKind, SpringDamper, SpringKind, VectorForce,
    VectorForceKind, law_arguments,
};
use admire_syntax::grammar;
use admire_syntax::grammar::LawDef;

/// Lowers a BUSHING.
pub(super) fn bushing(reader: &mut Reader) -> Option<Bushing> {
    Some(Bushing {
        header: reader.header(),
        i: reader.marker("I")?,
        j: reader.marker("J")?,
        k: reader.array("K"),
        kt: reader.array("KT"),
        c: reader.array("C"),
        ct: reader.array("CT"),
        force: reader.array("FORCE"),
        torque: reader.array("TORQUE"),
    })
}

/// Returns whether the grammar defines the law of a force statement and the model has no separate type for this statement, as for FIELD and BEAM.
pub(super) fn is_pair_force(kind: &str) -> bool {
    !matches!(kind, "BUSHING" | "SPRINGDAMPER")
        && grammar::statement(kind).is_some_and(|def| !def.laws.is_empty())
}

/// Lowers a force whose law and arguments are defined by the grammar.
pub(super) fn pair_force(reader: &mut Reader) -> Option<PairForce> {
    let def = reader.def;
    let chosen = |law: &&LawDef| law.flag.is_none_or(|flag| reader.has(flag));
    let law = def.laws.iter().find(chosen)?;
    let car = reader.car_field().and_then(Result::ok);
    let mut values = Vec::new();
    for argument in law_arguments(def, law).filter(|_| car.is_none()) {
        let count = argument.count.max.unwrap_or(1);
        values.extend((0..count).map(reader.row(argument.name)));
    }
    Some(PairForce {
        header: reader.header(),
        def,
        law,
        i: reader.marker("I")?,
        j: reader.marker("J")?,
        values,
        damping: reader.reals("CMATRIX").unwrap_or_default(),
        damping_ratio: reader.real("CRATIO"),
        car,
    })
}

/// Lowers a SPRINGDAMPER.
pub(super) fn springdamper(reader: &mut Reader) -> Option<SpringDamper> {
    let kind = reader.first_flag(&[
        ("TRANSLATIONAL", SpringKind::Translational),
        ("ROTATIONAL", SpringKind::Rotational),
    ])?;
    let [stiffness, reference, preload, damping] = match kind {
        SpringKind::Translational => ["K", "LENGTH", "FORCE", "C"],
        SpringKind::Rotational => ["KT", "ANGLE", "TORQUE", "CT"],
    };
    Some(SpringDamper {
        header: reader.header(),
        i: reader.marker("I")?,
        j: reader.marker("J")?,
        kind,
        stiffness: reader.real(stiffness),
        reference: reader.real(reference),
        preload: reader.real(preload),
        damping: reader.real(damping),
    })
}

/// Lowers an SFORCE.
pub(super) fn sforce(reader: &mut Reader) -> Option<Sforce> {
    let kind = reader.first_flag(&[
        ("TRANSLATIONAL", SforceKind::Translational),
        ("ROTATIONAL", SforceKind::Rotational),
    ])?;
    Some(Sforce {
        header: reader.header(),
        i: reader.marker("I")?,
        j: reader.marker("J")?,
        kind,
        action_only: reader.has("ACTIONONLY"),
        function: reader.function("FUNCTION")?,
    })
}

/// Lowers a GFORCE, VFORCE or VTORQUE with component functions. The caller treats forces with USER subroutines or vector expressions as
/// unsolved.
pub(super) fn vector_force(reader: &mut Reader) -> Option<VectorForce> {
    const NAMES: [&str; 6] = admire_syntax::FORCE_COMPONENTS;
    let components = std::array::from_fn(|k| reader.function(NAMES[k]));
    Some(VectorForce {
        header: reader.header(),
        kind: match reader.def.name {
            "VFORCE" => VectorForceKind::Vforce,
            "VTORQUE" => VectorForceKind::Vtorque,
            _ => VectorForceKind::Gforce,
        },
        i: reader.marker("I")?,
        jfloat: reader.marker("JFLOAT")?,
        rm: reader.marker("RM"),
        components,
    })
}

/// Lowers an NFORCE. Its matrices and vectors are read from the MATRIX statements that it names.
pub(super) fn nforce(reader: &mut Reader) -> Option<Nforce> {
    let i = reader.markers("IMARKERS")?;
    let n = 6 * i.len();
    let matrix = match reader.written_id("KMATRIX") {
        Some(id) => reader.matrix("KMATRIX", id)?,
        None => vec![vec![0.0; n]; n],
    };
    if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
        return reader.missing(&format!("a KMATRIX of {n} by {n} values"));
    }
    // The model stores a matrix column by column, as for FIELD.
    let by_columns =
        |matrix: &[Vec<f64>]| -> Vec<f64> { (0..n * n).map(|at| matrix[at % n][at / n]).collect() };
    let k = by_columns(&matrix);
    let ratio = reader.real("CRATIO");
    let damping = match reader.written_id("CMATRIX") {
        Some(id) => {
            let matrix = reader.matrix("CMATRIX", id)?;
            if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
                return reader.missing(&format!("a CMATRIX of {n} by {n} values"));
            }
            by_columns(&matrix)
        }
        None if ratio > 0.0 => k.iter().map(|k| ratio * k).collect(),
        None => Vec::new(),
    };
    let mut column = |name: &str| match reader.written_id(name) {
        Some(id) => {
            let values: Vec<f64> = reader.matrix(name, id)?.into_iter().flatten().collect();
            if values.len() == n {
                Some(values)
            } else {
                reader.missing(&format!("{n} values in {name}"))
            }
        }
        None => Some(vec![0.0; n]),
    };
    let (length, force) = (column("LENGTH")?, column("FORCE")?);
    Some(Nforce {
        header: reader.header(),
        i,
        j: reader.marker("J")?,
        k,
        length,
        force,
        damping,
    })
}
