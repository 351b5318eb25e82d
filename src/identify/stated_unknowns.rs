//! Unknowns of an identification that tables `[[identify.unknown]]` name.

use crate::{DeckUnknown, Mirror, Place, Unknown, resolved};
use admire_solver::model::Model;
use admire_study::settings::Method;
use admire_study::{Study, UnknownForm};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::{Address, Dataset};

/// Adds the unknowns of the tables `[[identify.unknown]]` to those of `identify.bushings` and `identify.stiffnesses`. If both name a number, the
/// start, the prior and the bounds of the table apply.
///
/// The unknown of the fit is the logarithm of a number. A table is reported in `out`, with its position, if its numbers have no logarithm or
/// cannot be one unknown. `is_known` returns true for the address of a number that the solver can change.
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
                let addresses = |unknown: &Unknown| -> Vec<Address> {
                    unknown.assign(0.0).map(|(address, _)| address).collect()
                };
                let named = addresses(&unknown);
                unknowns.retain(|other| !addresses(other).iter().any(|one| named.contains(one)));
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
) -> Result<Unknown, (String, String)> {
    let refuse = |message: String, help: &str| Err((message, help.to_string()));
    if own.form == UnknownForm::Change {
        return refuse(
            format!("{} is sought as a change", own.name),
            "a fit seeks the logarithm of a number: form = \"factor\" or \"value\"; hardpoints are among the [tolerances]",
        );
    }
    let first = &own.numbers[0];
    let deck = first.deck;
    if own
        .numbers
        .iter()
        .any(|number| number.factor != 1.0 || number.deck != deck)
    {
        return refuse(
            format!("the numbers of {} are not equal", own.name),
            "numbers that are identified together have one value in the deck, and no factors",
        );
    }
    if own.form == UnknownForm::Factor && deck <= 0.0 {
        return refuse(
            format!("{} has no logarithm: it is {deck}", own.name),
            "only numbers above 0 can be identified",
        );
    }
    if let Some(number) = own.numbers.iter().find(|number| !is_known(&number.address)) {
        return refuse(
            format!("the solver keeps {} constant", number.address),
            "`admire sensitivity` lists the numbers that can be identified",
        );
    }
    // Logarithm of the number for a coordinate of the unknown.
    let ln = |x: f64| match own.form {
        UnknownForm::Factor => x + libm::log(deck),
        UnknownForm::Change | UnknownForm::Value => {
            if x > 0.0 {
                libm::log(x)
            } else {
                f64::NEG_INFINITY
            }
        }
    };
    let bounds = own.bounds.map(ln);
    let is_bounded = own.bounds.iter().any(|bound| bound.is_finite());
    if is_bounded && study.identify.method != Method::GaussNewton {
        return refuse(
            format!("{} has bounds", own.name),
            "method = \"gauss-newton\" keeps them",
        );
    }
    let (initial, mean) = (ln(own.start), ln(own.mean));
    if !(initial.is_finite() && mean.is_finite()) {
        return refuse(
            format!("{} begins at 0 or below", own.name),
            "only numbers above 0 can be identified: give `start` and `mean`",
        );
    }
    // The standard deviation of a value counts relative to its mean.
    let sd = match own.form {
        UnknownForm::Factor => own.sd,
        UnknownForm::Change | UnknownForm::Value => own.sd / own.mean,
    };
    Ok(Unknown {
        address: first.address.clone(),
        tied: own.numbers[1..]
            .iter()
            .map(|number| number.address.clone())
            .collect(),
        place: Place::Number,
        unit: model.units.name(own.dimension),
        initial: libm::exp(initial),
        deck,
        mean: Some(mean),
        sd: sd.is_finite().then_some(sd),
        bounds: is_bounded.then_some(bounds),
    })
}
