use std::path::PathBuf;

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

use crate::front::plan_page::{
    MIN_PROBABILITY_GAIN, fall, fall_columns, name, percent, plan_page, without_loads,
};
use crate::front::{foreign_parts, suggested};
use admire_design::{Aim, Combination, Plan, Ranked, plan};
use admire_diagnosis::Progress as Watched;
use admire_diagnosis::study_fit::{no_wheel, nothing_to_identify};
use admire_identify::estimate_noise;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::format::Format;
use super::input::study;
use super::opening::Opening;
use super::output_folder::{Forced, refuse_replacing, write_folder};
use super::plausibility::{before_a_fit, deck_warnings};
use super::progress::{Count, Progress};
use super::shell::{Exit, Shell};
use super::width::{hanging, table_text};

/// Recommend which test, load or mark to add to a study, ranked by the expected gain.
///
/// Considers further load cases, repeated cases, marks on parts, curves of the wheel and load cells, as far as `[plan] available` of the
/// study lists them. For each, it computes the effect on three quantities: the worst-determined stiffnesses, the predicted wheel position
/// and angles, and the choice between causes that the readings do not distinguish. With --out, it writes `plan.json`, `report.html`, and
/// `suggested.csv` with load cases to append to the study's file.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire plan corpus/pseudo-mcpherson --for stiffnesses\n  admire plan my-axle --count 5 --out next\n  tail -n +2 next/suggested.csv | head -1 >> my-axle/load_cases.csv"
)]
pub(super) struct Arguments {
    /// Folder of the study.
    study: PathBuf,
    /// Folder for `plan.json`, `suggested.csv` and `report.html`. Without this option, nothing is written.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Purpose of the measurement; by default, all three, which takes as long as a diagnosis.
    #[arg(long = "for", value_enum, value_name = "WHAT")]
    aim: Option<AimChoice>,
    /// Number of candidates shown.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=1000))]
    count: u16,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    forced: Forced,
}

/// Choice of the aim on the command line.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
enum AimChoice {
    /// Stiffnesses: the three worst-determined combinations of unknowns.
    Stiffnesses,
    /// Prediction of toe, camber and wheel centre over the load cases of the study.
    Curves,
    /// Choice between two causes that the readings do not distinguish; takes as long as a diagnosis.
    Causes,
}

/// Names of the output files.
const OUTPUTS: [&str; 3] = ["plan.json", "suggested.csv", "report.html"];

/// Smallest decrease of a standard deviation, in percent, that counts as a gain.
const NOTHING: f64 = 0.1;
/// Largest number of impossible measurements that are named.
const SHOWN: usize = 4;

/// Ranks the candidate measurements, writes the outputs and prints the result.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if let Some(out) = &arguments.out {
        refuse_replacing(out, &OUTPUTS, arguments.forced.replacing(), shell)?;
    }
    let mut loaded = study(&arguments.study, shell)?;
    let aim = match arguments.aim {
        None => Aim::All,
        Some(AimChoice::Stiffnesses) => Aim::Stiffnesses,
        Some(AimChoice::Curves) => Aim::Curves,
        Some(AimChoice::Causes) => Aim::Causes,
    };
    if aim == Aim::Stiffnesses && loaded.unknowns.is_empty() {
        return Err(shell.fail(nothing_to_identify(&loaded)));
    }
    let foreign = foreign_parts(&loaded);
    if !foreign.is_empty() {
        shell.complain(&foreign);
        return Err(Exit::Findings);
    }
    before_a_fit(&loaded, arguments.forced.force, shell)?;
    let no_fit = |error: &dyn std::fmt::Display| {
        shell.fail(Diagnostic::error(Code::NoFit, error.to_string()));
        Exit::NoAnswer
    };
    estimate_noise(&mut loaded, None).map_err(|error| no_fit(&error))?;
    let watched = Watched::default();
    let seen = watched.clone();
    let bar = Progress::new("planning", shell, move || {
        let count = Count {
            done: seen.sweeps(),
            of: None,
            what: "sweeps",
        };
        Some((seen.stage(), count))
    });
    let found = plan(&loaded.problem(), aim, &watched);
    drop(bar);
    let found = found.map_err(|error| {
        deck_warnings(&loaded, shell);
        no_fit(&error)
    })?;
    if aim == Aim::Curves && found.curves.is_none() {
        return Err(shell.fail(no_wheel()));
    }
    let count = usize::from(arguments.count);
    if let Some(out) = &arguments.out {
        let page = plan_page(&loaded, &found, count);
        let texts = [found.to_json(), suggested(&loaded, &found, count), page];
        let files: Vec<(PathBuf, Vec<u8>)> = OUTPUTS
            .map(PathBuf::from)
            .into_iter()
            .zip(texts.map(String::into_bytes))
            .collect();
        write_folder(out, &files, arguments.forced.replacing(), shell)?;
        shell.say(&format!("report: {}\n", out.join("report.html").display()));
        arguments.opening.open(&out.join("report.html"), shell);
    }
    if shell.format == Format::Json {
        shell.print(&found.to_json());
    } else {
        let length = loaded.model.units.length.word;
        shell.print(&words(&found, count, length));
    }
    Ok(Exit::Fine)
}

/// Formats the result as text.
fn words(found: &Plan, count: usize, length: &str) -> String {
    let mut text = String::new();
    for (k, combination) in found.combinations.iter().enumerate() {
        if k == 0 {
            text += "worst-determined combinations of unknowns, with the standard deviation (sd) of\n\
                     ln K (of an unknown change: in units of its prior sd):\n";
        }
        let head = format!("  K{}  {:.3}  ", k + 1, combination.sd_log);
        text += &hanging(&head, &name(combination));
    }
    if let Some(curves) = &found.curves {
        let line = format!(
            "{}: toe {:.2e} deg, camber {:.2e} deg, centre {:.2e} {length}",
            curves.wheel, curves.sd.toe_deg, curves.sd.camber_deg, curves.sd.position
        );
        text += "sd of the predicted wheel position and angles over the load cases of the study:\n";
        text += &hanging("  ", &line);
    }
    if let Some(undecided) = &found.causes {
        let [a, b] = &undecided.between;
        let [p, q] = undecided.probability;
        text += &hanging("undecided: ", &format!("{a} ({p:.2}) or {b} ({q:.2})"));
        if !undecided.is_separated_by_loads() {
            text += &hanging("", &without_loads(undecided));
        }
    } else if matches!(found.aim, Aim::All | Aim::Causes) {
        text += "the readings distinguish all explanations\n";
    }
    if found.candidates.is_empty() {
        return text;
    }
    text += "\n";
    text += &table(found, count);
    let columns = fall_columns(found);
    if !columns.is_empty() {
        text += &hanging(&format!("{columns}: "), "decrease of the sd in percent");
    }
    if found.causes.is_some() {
        let meaning = "expected rise of the probability of the true explanation";
        text += &hanging("cause: ", meaning);
    }
    text += "\n";
    if let Some(best) = found.candidates.first() {
        text += &hanging("", &sentence(found, best));
    }
    if !found.not_possible.is_empty() {
        let mut what = found.not_possible.clone();
        let more = what.len().saturating_sub(SHOWN);
        what.truncate(SHOWN);
        if more > 0 {
            what.push(format!("and {more} more"));
        }
        text += &hanging("not possible: ", &what.join("; "));
    }
    if found.left_out > 0 {
        text += &format!(
            "combinations of loads that were not considered: {}\n",
            found.left_out
        );
    }
    text
}

fn table(found: &Plan, count: usize) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(80);
    let mut head = vec![
        String::new(),
        "measurement".to_string(),
        "cases".to_string(),
    ];
    head.extend((1..=found.combinations.len()).map(|k| format!("K{k}")));
    if found.curves.is_some() {
        head.extend(["toe", "camber", "centre"].map(String::from));
    }
    if found.causes.is_some() {
        head.push("cause".to_string());
    }
    table.set_header(head);
    for (k, ranked) in found.candidates.iter().take(count).enumerate() {
        let cases = match ranked.cases.len() {
            0 => "all".to_string(),
            count => count.to_string(),
        };
        let mut row = vec![format!("{}", k + 1), ranked.what.clone(), cases];
        for (combination, after) in found.combinations.iter().zip(&ranked.sd_log) {
            row.push(percent(fall(combination.sd_log, *after)));
        }
        if let (Some(before), Some(after)) = (&found.curves, &ranked.curves) {
            let before = before.sd;
            for (before, after) in [
                (before.toe_deg, after.toe_deg),
                (before.camber_deg, after.camber_deg),
                (before.position, after.position),
            ] {
                row.push(percent(fall(before, after)));
            }
        }
        if found.causes.is_some() {
            let shift = ranked.causes.map(|causes| causes.probability_shift);
            row.push(shift.map_or_else(String::new, |shift| format!("{shift:.2}")));
        }
        table.add_row(row);
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 1));
        if k >= 2 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table_text(&table) + "\n"
}

/// Describes the gains of the best candidate in a sentence.
fn sentence(found: &Plan, best: &Ranked) -> String {
    let mut gains = Vec::new();
    let worst = found.combinations.iter().zip(&best.sd_log);
    let most = worst.max_by(|a, b| {
        let gain = |(combination, sd): (&Combination, &f64)| fall(combination.sd_log, *sd);
        gain(*a).total_cmp(&gain(*b))
    });
    if let (Some((combination, sd)), true) =
        (most, matches!(found.aim, Aim::All | Aim::Stiffnesses))
    {
        gains.push(if fall(combination.sd_log, *sd) < NOTHING {
            let nats = best.information.unwrap_or_default();
            format!(
                "does not lower the sd of the worst-determined combinations, but gives {nats:.1} nats of information about all stiffnesses together"
            )
        } else {
            format!(
                "lowers the sd of ln {} from {:.3} to {sd:.3}",
                name(combination),
                combination.sd_log
            )
        });
    }
    if let (Some(before), Some(after), true) = (
        &found.curves,
        &best.curves,
        matches!(found.aim, Aim::All | Aim::Curves),
    ) {
        let toe = fall(before.sd.toe_deg, after.toe_deg);
        let camber = fall(before.sd.camber_deg, after.camber_deg);
        gains.push(format!(
            "lowers the sd of predicted toe by {toe:.0} % and of camber by {camber:.0} %"
        ));
    }
    if let (Some(undecided), Some(causes)) = (&found.causes, best.causes) {
        let [a, b] = &undecided.between;
        gains.push(if causes.probability_shift < MIN_PROBABILITY_GAIN {
            format!("does not distinguish {a} from {b}")
        } else {
            let word = if causes.at_least { "at least " } else { "" };
            format!(
                "is expected to raise the probability of the true explanation ({a} or {b}) by {word}{:.2}",
                causes.probability_shift
            )
        });
    }
    let gains = match gains.split_last() {
        None => "is expected to gain nothing for this purpose".to_string(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{}, and {last}", rest.join(", ")),
    };
    format!("Next: {}. It {gains}.", best.what)
}
