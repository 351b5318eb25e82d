use super::reader::Reader;
use crate::model::{
    ArrayData, ArrayKind, Diff, LinearStates, MarkerIx, PlantPort, Request, RequestKind, Sensor,
    SensorCompare, Spline, StringData, Variable,
};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::files::Files;
use admire_syntax::property::PropertyFile;
use admire_syntax::units::Units;

/// Lowers a VARIABLE.
pub(super) fn variable(reader: &mut Reader) -> Option<Variable> {
    Some(Variable {
        header: reader.header(),
        ic: reader.real("IC"),
        function: reader.function("FUNCTION")?,
    })
}

/// Lowers a DIFF.
pub(super) fn diff(reader: &mut Reader) -> Option<Diff> {
    Some(Diff {
        header: reader.header(),
        ic: reader.real("IC"),
        implicit: reader.has("IMPLICIT"),
        static_hold: reader.has("STATIC_HOLD"),
        dynamic_hold: reader.has("DYNAMIC_HOLD"),
        function: reader.function("FUNCTION")?,
    })
}

/// Lowers an LSE or TFSISO to linear state equations.
pub(super) fn linear_states(reader: &mut Reader) -> Option<LinearStates> {
    let (a, b, c, d) = if reader.def.name == "TFSISO" {
        let numerator = reader.reals("NUMERATOR")?;
        let denominator = reader.reals("DENOMINATOR")?;
        let Some(form) = controllable_form(&numerator, &denominator) else {
            let why = format!(
                "{} has no states: the order of DENOMINATOR must be at least 1, and at least that of NUMERATOR",
                reader.called()
            );
            let diagnostic = Diagnostic::error(Code::OutOfRange, why).help(
                "NUMERATOR and DENOMINATOR list coefficients, starting with the constant term; they are not ids of ARRAYs",
            );
            let (source, span) = reader.place("DENOMINATOR");
            reader.complain(diagnostic, source, span);
            return None;
        };
        form
    } else {
        let mut matrix = |name: &str| match reader.written_id(name) {
            Some(id) => reader.matrix(name, id),
            None => Some(Vec::new()),
        };
        let found = (matrix("A")?, matrix("B")?, matrix("C")?, matrix("D")?);
        Some(found).filter(fit)?
    };
    Some(LinearStates {
        header: reader.header(),
        kind: reader.def.name,
        x: reader.written_id("X")?,
        // An LSE may have no input; id 0 belongs to no array.
        u: reader.written_id("U").unwrap_or(0),
        y: reader.written_id("Y"),
        ic: reader.written_id("IC"),
        a,
        b,
        c,
        d,
        static_hold: reader.has("STATIC_HOLD"),
    })
}

type DenseRows = Vec<Vec<f64>>;

/// Returns whether the matrices A, B and C of an LSE agree in their number of states. If they disagree, `dimensions` reports it and the LSE
/// is dropped.
fn fit((a, b, c, _): &(DenseRows, DenseRows, DenseRows, DenseRows)) -> bool {
    let states = a.len();
    let wide = |matrix: &DenseRows| matrix.iter().all(|row| row.len() == states);
    wide(a) && wide(c) && (b.is_empty() || b.len() == states)
}

/// Returns the matrices of x' = A x + b u, y = c x + d u in controllable canonical form.
///
/// The transfer function is (n0 + n1 s + ...)/(d0 + d1 s + ...). Returns `None` if the numerator has the higher degree or there are no
/// states.
fn controllable_form(
    numerator: &[f64],
    denominator: &[f64],
) -> Option<(DenseRows, DenseRows, DenseRows, DenseRows)> {
    let order = denominator.iter().rposition(|value| *value != 0.0)?;
    let degree = numerator
        .iter()
        .rposition(|value| *value != 0.0)
        .unwrap_or(0);
    if degree > order || order == 0 {
        return None;
    }
    let lead = denominator[order];
    let den: Vec<f64> = denominator[..order].iter().map(|v| v / lead).collect();
    let num = |k: usize| numerator.get(k).map_or(0.0, |value| value / lead);
    let through = num(order);
    let mut a = vec![vec![0.0; order]; order];
    for k in 1..order {
        a[k - 1][k] = 1.0;
    }
    for k in 0..order {
        a[order - 1][k] = -den[k];
    }
    let mut b = vec![vec![0.0]; order];
    b[order - 1][0] = 1.0;
    let c = (0..order).map(|k| num(k) - through * den[k]).collect();
    Some((a, b, vec![c], vec![vec![through]]))
}

/// Lowers an ARRAY.
#[allow(clippy::unnecessary_wraps)] // All lowering functions share one signature.
pub(super) fn array(reader: &mut Reader) -> Option<ArrayData> {
    let size = reader.real("SIZE") as usize;
    let kind = if reader.has("U") {
        ArrayKind::Variables(reader.written_ids("VARIABLES").unwrap_or_default())
    } else if reader.has("X") {
        ArrayKind::States(size)
    } else if reader.has("Y") {
        ArrayKind::Outputs(size)
    } else {
        match (reader.reals("NUMBERS"), reader.written_ids("VARIABLES")) {
            (Some(numbers), _) => ArrayKind::Numbers(numbers),
            (None, Some(ids)) => ArrayKind::Variables(ids),
            (None, None) => ArrayKind::Numbers(vec![0.0; size.min(MOST_IMPLIED)]),
        }
    };
    Some(ArrayData {
        header: reader.header(),
        kind,
    })
}

/// Maximum number of zeros created for an ARRAY that gives only its SIZE.
const MOST_IMPLIED: usize = 1_000_000;

/// Lowers a SPLINE given by points.
pub(super) fn spline(reader: &mut Reader) -> Option<Spline> {
    let x = reader.reals("X").unwrap_or_default();
    let rows: Vec<Vec<f64>> = reader
        .all("Y")
        .map(|row| row.numbers().iter().map(|number| number.value).collect())
        .collect();
    let surface = rows.len() > 1 || rows.first().is_some_and(|row| row.len() == x.len() + 1);
    let (z, y) = if surface {
        // Each row of a surface starts with its z (guide/formats.md 2.14).
        rows.into_iter()
            .map(|row| {
                (
                    row.first().copied().unwrap_or(0.0),
                    row[row.len().min(1)..].to_vec(),
                )
            })
            .unzip()
    } else {
        (vec![0.0], rows)
    };
    if y.is_empty() || y.iter().any(|row| row.len() != x.len()) {
        return reader.missing("as many values in Y as in X");
    }
    Some(Spline {
        header: reader.header(),
        x,
        z,
        y,
        linear_extrapolate: reader.has("LINEAR_EXTRAPOLATE"),
        is_of_file: false,
    })
}

/// Lowers a SPLINE given by a property file, in the units of the model. BLOCK selects the curve; without BLOCK, the first curve is used.
pub(super) fn spline_of_file(reader: &mut Reader, files: &Files, units: &Units) -> Option<Spline> {
    let name = reader.text("FILE")?;
    let source = files.get(&name)?;
    if !PropertyFile::is_one(source.bytes()) {
        let why = format!(
            "{} is not solved: `{name}` is not a property file in the TeimOrbit form; DAC and RPC files are not read",
            reader.called()
        );
        let (source, span) = reader.place("FILE");
        reader.complain(
            Diagnostic::error(Code::NotSolvedNatively, why),
            source,
            span,
        );
        return None;
    }
    let read = PropertyFile::parse(source.clone());
    reader.diagnostics.extend(read.diagnostics);
    let file = read.value;
    let curve = match reader.text("BLOCK") {
        Some(block) => file.curve(&block),
        None => file.curves().into_iter().next(),
    };
    let Some(curve) = curve else {
        let blocks: Vec<String> = file.curves().into_iter().map(|c| c.block).collect();
        let message = match reader.text("BLOCK") {
            Some(block) => format!("`{name}` has no curve `{block}`"),
            None => format!("`{name}` has no curve"),
        };
        let mut diagnostic = Diagnostic::error(Code::UndefinedId, message);
        if !blocks.is_empty() {
            diagnostic = diagnostic.help(format!("BLOCK may be one of {}", blocks.join(", ")));
        }
        let (source, span) = reader.place("BLOCK");
        reader.complain(diagnostic, source, span);
        return None;
    };
    let (x, y) = curve.in_units(file.units.as_ref(), units);
    Some(Spline {
        header: reader.header(),
        x,
        z: vec![0.0],
        y: vec![y],
        linear_extrapolate: reader.has("LINEAR_EXTRAPOLATE"),
        is_of_file: true,
    })
}

/// Lowers a STRING.
pub(super) fn string(reader: &mut Reader) -> Option<StringData> {
    Some(StringData {
        header: reader.header(),
        text: reader.text("STRING")?,
    })
}

/// Lowers a SENSOR.
pub(super) fn sensor(reader: &mut Reader) -> Option<Sensor> {
    let halts = reader.has("HALT");
    Some(Sensor {
        header: reader.header(),
        compare: reader
            .first_flag(&[
                ("EQ", SensorCompare::Eq),
                ("GE", SensorCompare::Ge),
                ("LE", SensorCompare::Le),
            ])
            .unwrap_or(SensorCompare::Eq),
        value: reader.real("VALUE"),
        error: reader.real("ERROR"),
        function: reader.function("FUNCTION")?,
        evaluate: reader.function("EVALUATE"),
        stops: halts || reader.has("RETURN"),
        halts,
        dt: reader.first("DT"),
        stepsize: reader.first("STEPSIZE"),
        prints: reader.has("PRINT"),
        without_effect: ["CODGEN", "YYDUMP"]
            .into_iter()
            .filter(|word| reader.has(word))
            .collect(),
    })
}

/// Lowers a PINPUT, POUTPUT or PSTATE.
#[allow(clippy::unnecessary_wraps)] // All lowering functions share one signature.
pub(super) fn plant_port(reader: &mut Reader) -> Option<PlantPort> {
    Some(PlantPort {
        header: reader.header(),
        kind: reader.def.name,
        variables: reader.written_ids("VARIABLES").unwrap_or_default(),
    })
}

/// Lowers a REQUEST.
pub(super) fn request(reader: &mut Reader) -> Option<Request> {
    Some(Request {
        header: reader.header(),
        kind: request_kind(reader)?,
        comment: reader.text("COMMENT").unwrap_or_default(),
        component_names: reader
            .latest(&["CNAMES", "TITLE"])
            .next()
            .and_then(|names| reader.texts(names)),
        component_units: reader.texts("CUNITS").unwrap_or_default(),
        results_name: reader.text("RESULTS_NAME"),
    })
}

fn request_kind(reader: &mut Reader) -> Option<RequestKind> {
    const WORDS: [&str; 13] = [
        "FUNCTION",
        "F1",
        "F2",
        "F3",
        "F4",
        "F5",
        "F6",
        "F7",
        "F8",
        "DISPLACEMENT",
        "VELOCITY",
        "ACCELERATION",
        "FORCE",
    ];
    let word = reader
        .latest(&WORDS)
        .find(|word| *word != "FUNCTION" || reader.is_user(word));
    let kind: fn(MarkerIx, Option<MarkerIx>, Option<MarkerIx>) -> RequestKind = match word {
        Some("FUNCTION") => {
            let text = reader.text("FUNCTION").unwrap_or_default();
            return Some(RequestKind::User(text));
        }
        Some("DISPLACEMENT") => |i, j, rm| RequestKind::Displacement { i, j, rm },
        Some("VELOCITY") => |i, j, rm| RequestKind::Velocity { i, j, rm },
        Some("ACCELERATION") => |i, j, rm| RequestKind::Acceleration { i, j, rm },
        Some("FORCE") => |i, j, rm| RequestKind::Force { i, j, rm },
        Some(_) => {
            let functions = std::array::from_fn(|k| reader.function(WORDS[k + 1]));
            return Some(RequestKind::Functions(Box::new(functions)));
        }
        None => {
            return reader
                .missing("a quantity: DISPLACEMENT, VELOCITY, ACCELERATION, FORCE or F2=...");
        }
    };
    match reader.marker("I") {
        Some(i) => Some(kind(i, reader.marker("J"), reader.marker("RM"))),
        None if reader.has("I") => None,
        None => reader.missing("I, the marker whose motion or force it measures"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_functions_become_state_equations_of_the_same_gain() {
        // (3 + 2 s)/(5 + 4 s + s^2): at rest x = -A^-1 b u, so y/u = 3/5.
        let (a, b, c, d) = controllable_form(&[3.0, 2.0], &[5.0, 4.0, 1.0]).unwrap();
        assert_eq!(a, [[0.0, 1.0], [-5.0, -4.0]]);
        assert_eq!(
            (b, c, d),
            (
                vec![vec![0.0], vec![1.0]],
                vec![vec![3.0, 2.0]],
                vec![vec![0.0]]
            )
        );
        // Equal degrees give a direct feedthrough: (1 + 2 s)/(1 + s) = 2 - 1/(1 + s).
        let (_, _, c, d) = controllable_form(&[1.0, 2.0], &[1.0, 1.0]).unwrap();
        assert_eq!((c, d), (vec![vec![-1.0]], vec![vec![2.0]]));
        assert!(controllable_form(&[1.0, 2.0], &[1.0]).is_none());
    }
}
