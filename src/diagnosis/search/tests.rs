use super::super::fit::fit;
use super::*;
use crate::sought::tests::{of_the_axle, shipped_axle};

/// A cause is rejected if it increases the evidence only because the fit without causes ended in a wrong minimum.
#[test]
fn a_fit_without_causes_that_went_astray_is_replaced() {
    let loaded = shipped_axle();
    let problem = loaded.problem();
    let (subject, none) = of_the_axle(&problem);
    let none = Arc::new(none);
    let mut search = Search::new(&subject, Arc::clone(&none), Data::All);
    let candidates = search.candidates(&none, f64::NEG_INFINITY);
    let fits = candidates.iter().filter_map(|(h, weighed)| {
        let chosen = vec![(h.clone(), weighed.guesses.clone())];
        fit(
            &subject,
            &chosen,
            Some((&*none, weighed.x.as_slice())),
            Data::All,
        )
    });
    let best = fits.max_by(|a, b| a.ln_posterior().total_cmp(&b.ln_posterior()));
    let with_cause = Arc::new(best.expect("one can be fitted"));
    // No cause acts in this study.
    assert!(with_cause.ln_posterior() < none.ln_posterior());
    let mut astray = (*none).clone();
    astray.posterior.ln_z -= 0.5 * MODEST;
    astray.x[0] += 1.0;
    let mut search = Search::new(&subject, Arc::new(astray), Data::All);
    let found = search.held_against_none(Arc::clone(&with_cause));
    assert!(found.effects.is_empty());
    assert!((search.none.ln_posterior() - none.ln_posterior()).abs() < 0.1);
    // Against the correct fit without causes, the cause is kept; later stages decide about it.
    let mut search = Search::new(&subject, none, Data::All);
    let kept = search.held_against_none(Arc::clone(&with_cause));
    assert!(Arc::ptr_eq(&kept, &with_cause));
}
