//! Unknowns of an identification that tables `[[identify.unknown]]` name.

use crate::{Assignment, DeckUnknown, Mirror, Place, Unknown, resolved};
use admire_solver::model::Model;
use admire_study::settings::Method;
use admire_study::{Study, UnknownForm};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Address, Dataset};

/// Adds the unknowns of the tables `[[identify.unknown]]` to those of `identify.bushings` and `identify.stiffnesses`. If a number is named
/// in both, the start, the prior and the bounds of the table apply.
///
/// A table that the fit cannot identify is reported in `out`, with its position in `study.toml`. `is_known` returns true for the address of
/// a number that the solver can change.
pub(crate) fn add_stated(
    study: &Study,
    (dataset, model): (&Dataset, &Model),
    is_known: &dyn Fn(&Address) -> bool,
    unknowns: &mut Vec<Unknown>,
    out: &mut Vec<Diagnostic>,
) {
    let settings = &study.identify;
    let found = resolved(
        &settings.unknowns,
        (dataset, model),
        &study.source,
        (Mirror::default(), &[]),
        out,
    );
    for own in &found {
        match of_table(study, (own, model), is_known) {
            Ok(unknown) => {
                // Changes of one number add up, as those of a hardpoint along several axes.
                let adds = |other: &Unknown| !(other.is_logarithm() || unknown.is_logarithm());
                let is_named =
                    |other: &Unknown| own.numbers.iter().any(|one| other.sets(&one.address));
                unknowns.retain(|other| adds(other) || !is_named(other));
                unknowns.push(unknown);
            }
            Err((message, help)) => out.push(
                Diagnostic::error(Code::BadSetting, message)
                    .label(study.source.name(), own.span, "")
                    .help(help),
            ),
        }
    }
}

/// Creates an unknown of the fit from a table.
///
/// # Errors
/// Returns message and help if the fit cannot identify the numbers.
fn of_table(
    study: &Study,
    (own, model): (&DeckUnknown, &Model),
    is_known: &dyn Fn(&Address) -> bool,
) -> Result<Unknown, (String, &'static str)> {
    if let Some(number) = own.numbers.iter().find(|number| !is_known(&number.address)) {
        return Err((
            format!("the solver keeps {} constant", number.address),
            "`admire sensitivity` lists the numbers that can be identified",
        ));
    }
    let unknown = match own.form {
        UnknownForm::Change => change(own, model),
        UnknownForm::Factor | UnknownForm::Value => logarithm(own, model),
    }?;
    let what = match &unknown.assignment {
        _ if unknown.bounds.is_some() => "has bounds",
        Assignment::Change { .. } => "is identified as a change",
        Assignment::Factor(_) => "is a factor of several numbers",
        Assignment::Equal(_) => return Ok(unknown),
    };
    if study.identify.method != Method::GaussNewton {
        let method = study.identify.method.as_str();
        return Err((
            format!(
                "{} {what}, which method = \"{method}\" does not support",
                own.name
            ),
            "use method = \"gauss-newton\"",
        ));
    }
    Ok(unknown)
}

/// Creates an unknown whose coordinate is a change, in units of the prior standard deviation.
fn change(own: &DeckUnknown, model: &Model) -> Result<Unknown, (String, &'static str)> {
    let [least, most] = own.bounds;
    // Between two bounds alone, all values are equally probable.
    let uniform = (most - least) / libm::sqrt(12.0);
    let sd = own.sd.min(uniform);
    if !sd.is_finite() {
        return Err((
            format!("{} has neither `sd` nor `bounds`", own.name),
            "sd = \"3 mm\" says by how much the number may differ from the deck; form = \"factor\" needs none",
        ));
    }
    if sd <= 0.0 {
        return Err((
            format!("{} cannot change, because its `sd` is 0", own.name),
            "sd = \"3 mm\" says by how much the number may differ from the deck",
        ));
    }
    let mean = if own.sd.is_finite() {
        own.mean
    } else {
        f64::midpoint(least, most)
    };
    let unit = own.unit_sd.min(uniform);
    Ok(Unknown {
        address: own.address.clone(),
        assignment: Assignment::Change {
            numbers: own.numbers.clone(),
            sd: unit,
        },
        place: Place::Number,
        unit: model.units.name(own.dimension),
        initial: own.start,
        deck: 0.0,
        mean: Some(mean / unit),
        sd: Some(sd / unit),
        bounds: uniform
            .is_finite()
            .then(|| own.bounds.map(|bound| bound / unit)),
    })
}

/// Creates an unknown whose coordinate is the logarithm of a value, or of a common factor of several values.
fn logarithm(own: &DeckUnknown, model: &Model) -> Result<Unknown, (String, &'static str)> {
    let first = &own.numbers[0];
    let is_value = own.form == UnknownForm::Value;
    if is_value && own.numbers.iter().any(|number| number.factor != 1.0) {
        return Err((
            format!(
                "{} has factors, which form = \"value\" does not allow",
                own.name
            ),
            "form = \"value\" gives all numbers one value; form = \"factor\" keeps the ratios of the deck",
        ));
    }
    let is_equal = own
        .numbers
        .iter()
        .all(|number| number.factor == 1.0 && number.deck == first.deck);
    // Equal numbers are known by their value, others by their factor.
    let is_number = is_equal && first.deck > 0.0;
    let is_factor = !(is_value || is_number);
    let deck = if is_factor { 1.0 } else { first.deck };
    let ln = |x: f64| match own.form {
        UnknownForm::Factor => x + libm::log(deck),
        UnknownForm::Change | UnknownForm::Value if x > 0.0 => libm::log(x),
        UnknownForm::Change | UnknownForm::Value => f64::NEG_INFINITY,
    };
    let (initial, mean) = (ln(own.start), ln(own.mean));
    if !(initial.is_finite() && mean.is_finite()) {
        return Err((
            format!("{} starts at 0 or below", own.name),
            "the value must be above 0: give `start` and `mean`, or use form = \"change\" with an `sd`",
        ));
    }
    // The standard deviation of a value counts relative to its mean.
    let sd = match own.form {
        UnknownForm::Factor => own.sd,
        UnknownForm::Change | UnknownForm::Value => own.sd / own.mean,
    };
    let bounds = own.bounds.map(ln);
    Ok(Unknown {
        address: first.address.clone(),
        assignment: if is_factor {
            Assignment::Factor(own.numbers.clone())
        } else {
            let tied = own.numbers[1..].iter();
            Assignment::Equal(tied.map(|number| number.address.clone()).collect())
        },
        place: Place::Number,
        unit: if is_factor {
            String::new()
        } else {
            model.units.name(own.dimension)
        },
        initial: libm::exp(initial),
        deck,
        mean: Some(mean),
        sd: sd.is_finite().then_some(sd),
        bounds: own
            .bounds
            .iter()
            .any(|bound| bound.is_finite())
            .then_some(bounds),
    })
}
