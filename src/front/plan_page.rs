//! Page of a plan: the recommended measurements and their gains.

use admire_design::{Combination, Plan, Ranked, Undecided};
use admire_identify::LoadedStudy;
use admire_report::{Align, Bars, Figure, Page, Scene, Table, VERSION, number};
use admire_results::Timestamp;

/// Largest number of candidates in a bar chart.
const MAX_BARS: usize = 6;
/// Smallest increase of a probability that counts as a gain.
pub(crate) const MIN_PROBABILITY_GAIN: f64 = 0.005;

/// States that no available load separates two explanations, and names the instruments that would.
pub(crate) fn without_loads(undecided: &Undecided) -> String {
    let all = undecided.would_separate.iter().map(ToString::to_string);
    let all: Vec<String> = all.collect();
    let would = if all.is_empty() {
        "neither does any mark, curve or load cell".to_string()
    } else {
        format!("these measurements would: {}", all.join("; "))
    };
    format!(
        "no load in the range distinguishes the two (chi-square {:.1} at most); {would}",
        undecided.by_loads
    )
}

/// Formats a combination of stiffnesses, such as `BUSHING/1.KT.3 - 0.5 BUSHING/2.K.1`. The shares are relative to the largest share.
pub(crate) fn name(combination: &Combination) -> String {
    let mut shares: Vec<(&String, f64)> = combination
        .combination
        .iter()
        .map(|(address, share)| (address, *share))
        .collect();
    shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let largest = shares.first().map_or(1.0, |(_, share)| *share);
    let mut text = String::new();
    for (address, share) in shares {
        let part = share / largest;
        let sign = match (part < 0.0, text.is_empty()) {
            (_, true) => "",
            (true, false) => " - ",
            (false, false) => " + ",
        };
        text += sign;
        if part.abs() < 0.995 {
            text += &format!("{:.2} ", part.abs());
        }
        text += address;
    }
    text
}

/// Formats a percentage with one decimal. A value that rounds to zero is printed without a sign.
pub(crate) fn percent(value: f64) -> String {
    format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0)
}

/// Mark of a load outside the range of the study's cases, in the name of a candidate.
const BEYOND: &str = "(beyond)";

/// Returns the name of a candidate as it stands in a sentence.
fn in_words(what: &str) -> String {
    what.replace(BEYOND, "(outside the range of loads so far)")
}

/// Formats a standard deviation with two digits.
fn two_digits(value: f64) -> String {
    number(value, Some(value))
}

/// Returns the relative decrease of a standard deviation in percent.
pub(crate) fn fall(before: f64, after: f64) -> f64 {
    if before > 0.0 {
        100.0 * (1.0 - after / before)
    } else {
        0.0
    }
}

/// Names the columns of a ranking that give decreases of standard deviations, such as `K1 to K3, toe, camber, centre`.
pub(crate) fn fall_columns(found: &Plan) -> String {
    let combinations = match found.combinations.len() {
        0 => None,
        1 => Some("K1".to_string()),
        count => Some(format!("K1 to K{count}")),
    };
    let curves = found.curves.as_ref();
    let curves = curves.map(|_| "toe, camber, centre".to_string());
    let names: Vec<String> = combinations.into_iter().chain(curves).collect();
    names.join(", ")
}

/// Returns the address with the largest share of a combination.
fn main_address(combination: &Combination) -> &str {
    let shares = combination.combination.iter();
    let largest = shares.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    largest.map_or("", |(address, _)| address)
}

/// Describes the gains of a candidate in words.
fn gains(found: &Plan, best: &Ranked, scene: &Scene) -> Vec<String> {
    let mut out = Vec::new();
    let combinations = found.combinations.iter().zip(&best.sd_log);
    let most =
        combinations.max_by(|a, b| fall(a.0.sd_log, *a.1).total_cmp(&fall(b.0.sd_log, *b.1)));
    if let Some((combination, after)) = most {
        let by = fall(combination.sd_log, *after);
        if by >= 1.0 {
            out.push(format!(
                "the uncertainty of {} falls by {by:.0} %",
                scene.named(main_address(combination))
            ));
        }
    }
    if let (Some(before), Some(after)) = (&found.curves, &best.curves) {
        let toe = fall(before.sd.toe_deg, after.toe_deg);
        let camber = fall(before.sd.camber_deg, after.camber_deg);
        if toe.max(camber) >= 1.0 {
            out.push(format!(
                "the uncertainty of the predicted toe falls by {toe:.0} %, and that of camber by {camber:.0} %"
            ));
        }
    }
    if let (Some(undecided), Some(causes)) = (&found.causes, best.causes)
        && causes.probability_shift >= MIN_PROBABILITY_GAIN
    {
        let [a, b] = &undecided.between;
        out.push(format!("{a} and {b} are easier to distinguish"));
    }
    out
}

/// Draws the gains of the candidates for one quantity, in percent or as a probability. `None` if no candidate has a gain.
fn chart(
    found: &Plan,
    title: &str,
    x: &str,
    gain: &dyn Fn(&Ranked) -> Option<f64>,
) -> Option<Figure> {
    let mut rows: Vec<(String, [f64; 2])> = found
        .candidates
        .iter()
        .filter_map(|ranked| Some((ranked.what.clone(), [0.0, gain(ranked)?])))
        .take(MAX_BARS)
        .collect();
    rows.retain(|(_, ends)| ends[1].is_finite());
    if rows.iter().all(|(_, ends)| ends[1].abs() < 1e-3) {
        return None;
    }
    let bars = Bars {
        title: title.to_string(),
        x: x.to_string(),
        rows,
        level: 0.0,
    };
    Some(Figure::bars(
        &bars,
        "The best candidates, in the order of the ranking.",
    ))
}

/// Creates the page of a plan as HTML text. `count` is the number of candidates in the ranking.
pub(crate) fn plan_page(loaded: &LoadedStudy, found: &Plan, count: usize) -> String {
    let mut scene = Scene::of_study(loaded);
    let best = found.candidates.first();
    let answer = match best {
        Some(best) => {
            let gains = gains(found, best, &scene);
            let gains = if gains.is_empty() {
                "The expected gain is small".to_string()
            } else {
                format!("Then {}", gains.join("; "))
            };
            format!("Measure next: {}. {gains}.", in_words(&best.what))
        }
        None => "Nothing needs to be measured for this purpose.".to_string(),
    };
    let title = loaded.dataset.title();
    let mut page = Page::new("Plan of measurements", title.trim(), &answer);
    page.origin(&[
        ("Study", loaded.study.folder.display().to_string()),
        ("Deck", loaded.study.deck_path.display().to_string()),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        ("Made by", format!("admire {VERSION}")),
        (
            "Inputs",
            format!("SHA-256 {}", loaded.study.inputs_sha256()),
        ),
    ]);
    page.meaning();
    let mut figures = Vec::new();
    for (k, combination) in found.combinations.iter().enumerate().take(2) {
        let title = format!(
            "Decrease of the uncertainty of K{}, mainly {}",
            k + 1,
            scene.named(main_address(combination))
        );
        let gain = |ranked: &Ranked| Some(fall(combination.sd_log, *ranked.sd_log.get(k)?));
        figures.extend(chart(
            found,
            &title,
            "decrease of the standard deviation [%]",
            &gain,
        ));
    }
    if let Some(curves) = &found.curves {
        let gain = |ranked: &Ranked| Some(fall(curves.sd.toe_deg, ranked.curves.as_ref()?.toe_deg));
        let x = "decrease of the standard deviation [%]";
        figures.extend(chart(
            found,
            "Decrease of the uncertainty of the predicted toe",
            x,
            &gain,
        ));
    }
    if let Some(undecided) = &found.causes {
        let [a, b] = &undecided.between;
        let title = format!("Choice between {a} and {b}");
        let gain = |ranked: &Ranked| Some(ranked.causes?.probability_shift);
        figures.extend(chart(
            found,
            &title,
            "expected rise of the probability of the true one",
            &gain,
        ));
    }
    page.figures(&figures);
    for combination in &found.combinations {
        scene.highlight(main_address(combination), "worst determined");
    }
    page.scene(&scene);
    lines(&mut page, found);
    page.table(&ranking(found, count));
    let columns = fall_columns(found);
    let mut legend = Vec::new();
    if !columns.is_empty() {
        legend.push(format!(
            "{columns}: decrease of the standard deviation in percent."
        ));
    }
    if !found.combinations.is_empty() {
        legend.push("K1 is the worst-determined combination; all are listed above.".to_string());
    }
    if found.causes.is_some() {
        let meaning = "cause: expected rise of the probability of the true explanation.";
        legend.push(meaning.to_string());
    }
    let mut candidates = found.candidates.iter();
    if candidates.any(|ranked| ranked.what.contains(BEYOND)) {
        let meaning = "(beyond): load outside the range of the load cases of the study.";
        legend.push(meaning.to_string());
    }
    page.note(&legend.join(" "));
    page.detail("Measurements that are not possible or were not considered");
    if !found.not_possible.is_empty() {
        page.list(&found.not_possible);
    }
    if found.left_out > 0 {
        page.note(&format!(
            "Combinations of loads that were not considered: {}.",
            found.left_out
        ));
    }
    page.finish(&format!("admire {VERSION}"))
}

/// Adds the least known combinations and the next step.
fn lines(page: &mut Page, found: &Plan) {
    let combinations = found.combinations.iter().enumerate();
    let least = combinations.map(|(k, combination)| {
        let share = 100.0 * combination.sd_log;
        let what = name(combination);
        format!("K{}, standard deviation {share:.0} %: {what}", k + 1)
    });
    let wheel = found.curves.iter().map(|curves| {
        format!(
            "{}: standard deviation of predicted toe {} deg, of predicted camber {} deg",
            curves.wheel,
            two_digits(curves.sd.toe_deg),
            two_digits(curves.sd.camber_deg)
        )
    });
    let undecided = found.causes.iter().flat_map(|undecided| {
        let [a, b] = &undecided.between;
        let [p, q] = undecided.probability.map(|p| 100.0 * p);
        let loads = (!undecided.is_separated_by_loads()).then(|| without_loads(undecided));
        std::iter::once(format!("{a} ({p:.0} %) or {b} ({q:.0} %)")).chain(loads)
    });
    let next = found.candidates.first().map(|best| {
        let cases = match best.cases.len() {
            0 => "in all cases".to_string(),
            1 => "in 1 case of suggested.csv".to_string(),
            count => format!("in {count} cases of suggested.csv"),
        };
        format!("Measure {}, {cases}", in_words(&best.what))
    });
    page.found(&[
        ("Worst-determined combinations", least.collect()),
        ("Predicted wheel", wheel.collect()),
        ("Undecided causes", undecided.collect()),
        ("To do next", next.into_iter().collect()),
    ]);
}

/// Tabulates the best candidates, with the gains of each.
fn ranking(found: &Plan, count: usize) -> Table {
    let combinations = 1..=found.combinations.len();
    let names: Vec<String> = combinations.map(|k| format!("K{k}")).collect();
    let mut columns = vec![("measurement", Align::Wrap), ("cases", Align::Right)];
    columns.extend(names.iter().map(|name| (name.as_str(), Align::Right)));
    if found.curves.is_some() {
        columns.extend(["toe", "camber", "centre"].map(|name| (name, Align::Right)));
    }
    if found.causes.is_some() {
        columns.push(("cause", Align::Right));
    }
    let mut table = Table::new(&columns);
    for ranked in found.candidates.iter().take(count) {
        let cases = match ranked.cases.len() {
            0 => "all".to_string(),
            count => count.to_string(),
        };
        let mut row = vec![ranked.what.clone(), cases];
        let combinations = found.combinations.iter().zip(&ranked.sd_log);
        row.extend(combinations.map(|(own, after)| percent(fall(own.sd_log, *after))));
        if let (Some(before), Some(after)) = (&found.curves, &ranked.curves) {
            let before = before.sd;
            row.push(percent(fall(before.toe_deg, after.toe_deg)));
            row.push(percent(fall(before.camber_deg, after.camber_deg)));
            row.push(percent(fall(before.position, after.position)));
        }
        if found.causes.is_some() {
            let shift = ranked.causes.map(|causes| causes.probability_shift);
            row.push(shift.map_or_else(String::new, |shift| format!("{shift:.2}")));
        }
        table.row(row);
    }
    table
}
