use super::reader::Reader;
use crate::diagnostic::{Code, Diagnostic};
use crate::model::{
    ArrayData, ArrayKind, Diff, Function, LinearStates, MarkerIx, PlantPort, Request, RequestKind,
    Sensor, SensorCompare, Spline, StringData, Variable,
};
use crate::syntax::files::Files;
use crate::syntax::property::PropertyFile;
use crate::units::Units;

/// VARIABLE.
pub(super) fn variable(reader: &mut Reader, old: Option<&Variable>) -> Option<Variable> {
    Some(Variable {
        header: reader.header(old.map(|old| &old.header)),
        ic: reader.real("IC", old.map(|old| old.ic)),
        function: reader.function("FUNCTION", old.map(|old| &old.function))?,
    })
}

/// DIFF.
pub(super) fn diff(reader: &mut Reader, old: Option<&Diff>) -> Option<Diff> {
    Some(Diff {
        header: reader.header(old.map(|old| &old.header)),
        ic: reader.real("IC", old.map(|old| old.ic)),
        implicit: reader.flag("IMPLICIT", old.is_some_and(|old| old.implicit)),
        static_hold: reader.flag("STATIC_HOLD", old.is_some_and(|old| old.static_hold)),
        function: reader.function("FUNCTION", old.map(|old| &old.function))?,
    })
}

/// LSE and TFSISO as linear state equations.
pub(super) fn linear_states(
    reader: &mut Reader,
    old: Option<&LinearStates>,
) -> Option<LinearStates> {
    let (a, b, c, d) = if reader.def.name == "TFSISO" {
        let numerator = reader.reals("NUMERATOR")?;
        let denominator = reader.reals("DENOMINATOR")?;
        let Some(form) = controllable_form(&numerator, &denominator) else {
            return reader.missing("a denominator of higher order than its numerator, not zero");
        };
        form
    } else {
        let mut matrix = |name: &str| match reader.written_id(name, None) {
            Some(id) => reader.matrix(name, id),
            None => Some(Vec::new()),
        };
        (matrix("A")?, matrix("B")?, matrix("C")?, matrix("D")?)
    };
    Some(LinearStates {
        header: reader.header(old.map(|old| &old.header)),
        kind: reader.def.name,
        x: reader.written_id("X", old.map(|old| old.x))?,
        // LSE may have no input; no array has the id zero.
        u: reader.written_id("U", old.map(|old| old.u)).unwrap_or(0),
        y: reader.written_id("Y", old.and_then(|old| old.y)),
        ic: reader.written_id("IC", old.and_then(|old| old.ic)),
        a,
        b,
        c,
        d,
        static_hold: reader.flag("STATIC_HOLD", old.is_some_and(|old| old.static_hold)),
    })
}

type Matrix = Vec<Vec<f64>>;

/// x' = A x + b u, y = c x + d u of (n0 + n1 s + ...)/(d0 + d1 s + ...), in the controllable canonical form.
fn controllable_form(
    numerator: &[f64],
    denominator: &[f64],
) -> Option<(Matrix, Matrix, Matrix, Matrix)> {
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

/// ARRAY.
#[allow(clippy::unnecessary_wraps)] // All readers have one signature.
pub(super) fn array(reader: &mut Reader, old: Option<&ArrayData>) -> Option<ArrayData> {
    let size = reader.real("SIZE", None) as usize;
    let kind = if reader.flag("U", false) {
        ArrayKind::Variables(reader.written_ids("VARIABLES").unwrap_or_default())
    } else if reader.flag("X", false) {
        ArrayKind::States(size)
    } else if reader.flag("Y", false) {
        ArrayKind::Outputs(size)
    } else {
        match (
            reader.reals("NUMBERS"),
            reader.written_ids("VARIABLES"),
            old,
        ) {
            (Some(numbers), ..) => ArrayKind::Numbers(numbers),
            (None, Some(ids), _) => ArrayKind::Variables(ids),
            (None, None, Some(old)) => old.kind.clone(),
            (None, None, None) => ArrayKind::Numbers(vec![0.0; size.min(MOST_IMPLIED)]),
        }
    };
    Some(ArrayData {
        header: reader.header(old.map(|old| &old.header)),
        kind,
    })
}

/// A size without numbers makes so many zeros at most.
const MOST_IMPLIED: usize = 1_000_000;

/// SPLINE from points.
pub(super) fn spline(reader: &mut Reader, old: Option<&Spline>) -> Option<Spline> {
    let x = reader
        .reals("X")
        .or_else(|| old.map(|old| old.x.clone()))
        .unwrap_or_default();
    let rows: Vec<Vec<f64>> = reader
        .statement
        .all("Y")
        .map(|row| row.numbers().iter().map(|number| number.value).collect())
        .collect();
    let surface = rows.len() > 1 || rows.first().is_some_and(|row| row.len() == x.len() + 1);
    let (z, y) = match (rows.is_empty(), old) {
        (true, Some(old)) => (old.z.clone(), old.y.clone()),
        // Each row of a surface starts with its z (guide/formats.md 2.14).
        (false, _) if surface => rows
            .into_iter()
            .map(|row| {
                (
                    row.first().copied().unwrap_or(0.0),
                    row[row.len().min(1)..].to_vec(),
                )
            })
            .unzip(),
        _ => (vec![0.0], rows),
    };
    if y.is_empty() || y.iter().any(|row| row.len() != x.len()) {
        return reader.missing("as many values in Y as in X");
    }
    Some(Spline {
        header: reader.header(old.map(|old| &old.header)),
        x,
        z,
        y,
        linear_extrapolate: reader.flag(
            "LINEAR_EXTRAPOLATE",
            old.is_some_and(|old| old.linear_extrapolate),
        ),
    })
}

/// SPLINE from a property file: the curve of its BLOCK (of the first curve if none is named) in the units of the model.
pub(super) fn spline_of_file(reader: &mut Reader, files: &Files, units: &Units) -> Option<Spline> {
    let name = reader.text("FILE", None)?;
    let source = files.get(&name)?;
    if !PropertyFile::is_one(source.bytes()) {
        let why = format!(
            "{} is not solved: `{name}` is no property file in the TeimOrbit form; DAC and RPC files are not read",
            reader.called()
        );
        let place = reader.place("FILE");
        reader.complain(Diagnostic::error(Code::NotSolvedNatively, why), place);
        return None;
    }
    let read = PropertyFile::parse(source.clone());
    reader.diagnostics.extend(read.diagnostics);
    let file = read.value;
    let curve = match reader.text("BLOCK", None) {
        Some(block) => file.curve(&block),
        None => file.curves().into_iter().next(),
    };
    let Some(curve) = curve else {
        let blocks: Vec<String> = file.curves().into_iter().map(|c| c.block).collect();
        let diagnostic = Diagnostic::error(
            Code::UndefinedId,
            format!("`{name}` has no curve of that name"),
        )
        .help(format!("BLOCK may be one of {}", blocks.join(", ")));
        let place = reader.place("BLOCK");
        reader.complain(diagnostic, place);
        return None;
    };
    let (x, y) = curve.in_units(file.units.as_ref(), units);
    Some(Spline {
        header: reader.header(None),
        x,
        z: vec![0.0],
        y: vec![y],
        linear_extrapolate: reader.flag("LINEAR_EXTRAPOLATE", false),
    })
}

/// STRING.
pub(super) fn string(reader: &mut Reader, old: Option<&StringData>) -> Option<StringData> {
    Some(StringData {
        header: reader.header(old.map(|old| &old.header)),
        text: reader.text("STRING", old.map(|old| old.text.clone()))?,
    })
}

/// SENSOR.
pub(super) fn sensor(reader: &mut Reader, old: Option<&Sensor>) -> Option<Sensor> {
    let halts = reader.flag("HALT", old.is_some_and(|old| old.halts));
    Some(Sensor {
        header: reader.header(old.map(|old| &old.header)),
        compare: reader
            .first_flag(&[
                ("EQ", SensorCompare::Eq),
                ("GE", SensorCompare::Ge),
                ("LE", SensorCompare::Le),
            ])
            .or(old.map(|old| old.compare))
            .unwrap_or(SensorCompare::Eq),
        value: reader.real("VALUE", old.map(|old| old.value)),
        error: reader.real("ERROR", old.map(|old| old.error)),
        function: reader.function("FUNCTION", old.map(|old| &old.function))?,
        evaluate: reader.function("EVALUATE", old.and_then(|old| old.evaluate.as_ref())),
        stops: halts || reader.flag("RETURN", old.is_some_and(|old| old.stops)),
        halts,
        dt: reader
            .given("DT")
            .and_then(|argument| Some(argument.numbers().first()?.value))
            .or_else(|| old.and_then(|old| old.dt)),
        stepsize: reader
            .statement
            .first("STEPSIZE")
            .or_else(|| old.and_then(|old| old.stepsize)),
    })
}

/// PINPUT and POUTPUT.
#[allow(clippy::unnecessary_wraps)] // All readers have one signature.
pub(super) fn plant_port(reader: &mut Reader, old: Option<&PlantPort>) -> Option<PlantPort> {
    Some(PlantPort {
        header: reader.header(old.map(|old| &old.header)),
        kind: reader.def.name,
        variables: reader
            .written_ids("VARIABLES")
            .or_else(|| old.map(|old| old.variables.clone()))
            .unwrap_or_default(),
    })
}

/// REQUEST.
pub(super) fn request(reader: &mut Reader, old: Option<&Request>) -> Option<Request> {
    Some(Request {
        header: reader.header(old.map(|old| &old.header)),
        kind: request_kind(reader, old.map(|old| &old.kind))?,
        comment: reader
            .text("COMMENT", old.map(|old| old.comment.clone()))
            .unwrap_or_default(),
        component_names: reader
            .texts("CNAMES")
            .or_else(|| reader.texts("TITLE"))
            .or_else(|| old.and_then(|old| old.component_names.clone())),
        component_units: reader
            .texts("CUNITS")
            .or_else(|| old.map(|old| old.component_units.clone()))
            .unwrap_or_default(),
        results_name: reader.text("RESULTS_NAME", old.and_then(|old| old.results_name.clone())),
    })
}

fn request_kind(reader: &mut Reader, old: Option<&RequestKind>) -> Option<RequestKind> {
    const NAMES: [&str; 8] = ["F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8"];
    if let Some(Function::User(text)) = reader.function("FUNCTION", None) {
        return Some(RequestKind::User(text));
    }
    if reader.any(&NAMES) {
        let before = match old {
            Some(RequestKind::Functions(functions)) => (**functions).clone(),
            _ => std::array::from_fn(|_| None),
        };
        let functions = std::array::from_fn(|k| reader.function(NAMES[k], before[k].as_ref()));
        return Some(RequestKind::Functions(Box::new(functions)));
    }
    let before: (Option<MarkerIx>, Option<MarkerIx>, Option<MarkerIx>) = match old {
        Some(
            RequestKind::Displacement { i, j, rm }
            | RequestKind::Velocity { i, j, rm }
            | RequestKind::Acceleration { i, j, rm }
            | RequestKind::Force { i, j, rm },
        ) => (Some(*i), *j, *rm),
        _ => (None, None, None),
    };
    let i = reader.marker("I", before.0);
    let j = reader.marker("J", before.1);
    let rm = reader.marker("RM", before.2);
    let word = ["DISPLACEMENT", "VELOCITY", "ACCELERATION", "FORCE"]
        .into_iter()
        .find(|word| reader.flag(word, false));
    match (word, old, i) {
        (Some("DISPLACEMENT"), _, Some(i))
        | (None, Some(RequestKind::Displacement { .. }), Some(i)) => {
            Some(RequestKind::Displacement { i, j, rm })
        }
        (Some("VELOCITY"), _, Some(i)) | (None, Some(RequestKind::Velocity { .. }), Some(i)) => {
            Some(RequestKind::Velocity { i, j, rm })
        }
        (Some("ACCELERATION"), _, Some(i))
        | (None, Some(RequestKind::Acceleration { .. }), Some(i)) => {
            Some(RequestKind::Acceleration { i, j, rm })
        }
        (Some("FORCE"), _, Some(i)) | (None, Some(RequestKind::Force { .. }), Some(i)) => {
            Some(RequestKind::Force { i, j, rm })
        }
        (None, Some(kind), _) => Some(kind.clone()),
        (Some(_), _, None) if reader.given("I").is_some() => None,
        (Some(_), _, _) => reader.missing("I, the marker it is about"),
        (None, None, _) => reader
            .missing("what it asks for: DISPLACEMENT, VELOCITY, ACCELERATION, FORCE or F2=..."),
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
        // Equal degrees feed through: (1 + 2 s)/(1 + s) = 2 - 1/(1 + s).
        let (_, _, c, d) = controllable_form(&[1.0, 2.0], &[1.0, 1.0]).unwrap();
        assert_eq!((c, d), (vec![vec![-1.0]], vec![vec![2.0]]));
        assert!(controllable_form(&[1.0, 2.0], &[1.0]).is_none());
    }
}
