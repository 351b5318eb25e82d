use super::{Chart, DrawingError, Figure, Series, SeriesStyle};
use admire_identify::{Fit, LoadedStudy, ParameterFit};

/// Draws the values of all parameters over the iterations of a fit. There is one chart per element, so that many parameters remain readable.
/// `named` splits the address of a parameter into the name of the element and the name of the parameter in that element.
pub(super) fn convergence(
    loaded: &LoadedStudy,
    fit: &Fit,
    named: impl Fn(&str) -> (String, String),
) -> Result<Vec<Figure>, DrawingError> {
    if fit.history.len() < 2 {
        return Ok(Vec::new());
    }
    let reference = loaded.reference_values();
    let known = reference.iter().any(Option::is_some);
    let mut groups: Vec<(String, Vec<Series>)> = Vec::new();
    // A change that begins at zero has no ratio to its end.
    let is_ratio = |(_, parameter): &(usize, &ParameterFit)| parameter.form != Some("change");
    for (k, parameter) in fit.parameters.iter().enumerate().filter(is_ratio) {
        let over = reference
            .get(k)
            .copied()
            .flatten()
            .unwrap_or(parameter.value);
        let points = fit.history.iter().enumerate();
        let points = points
            .map(|(i, values)| (i as f64, values[k] / over))
            .collect();
        let (element, number) = named(&parameter.address);
        let series = Series::new(&number, SeriesStyle::LinePoints, points);
        match groups.iter_mut().find(|(name, _)| *name == element) {
            Some((_, list)) => list.push(series),
            None => groups.push((element, vec![series])),
        }
    }
    let charts = groups.into_iter().map(|(element, series)| Chart {
        title: element,
        x: "iteration".to_string(),
        y: if known {
            "value / reference"
        } else {
            "value / final value"
        }
        .to_string(),
        series,
        log_y: true,
        level: Some(1.0),
        ..Chart::default()
    });
    charts.map(|chart| Figure::chart(&chart, "")).collect()
}
