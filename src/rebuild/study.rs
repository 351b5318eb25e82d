use std::fmt::Write as _;

use admire_solver::mechanics::Vec3;

use super::deck::Deck;
use super::mechanism::Mechanism;
use super::record::Record;
use super::settings::MARK_DISTANCE_RELATIVE;

/// Returns the files of a study: `study.toml`, load cases and marks. Each state of the results is a load case. Each moving part carries four marks,
/// whose readings follow from the poses in the results.
pub(crate) fn study_files(
    record: &Record,
    mechanism: &Mechanism,
    deck: &Deck,
    name: &str,
) -> Vec<(String, String)> {
    let distance = MARK_DISTANCE_RELATIVE * mechanism.size;
    let cases = cases(record);
    let moving: Vec<usize> = (1..record.bodies.len())
        .filter(|k| moves(record, *k, mechanism.size))
        .collect();
    let marks = [
        Vec3::zeros(),
        Vec3::x() * distance,
        Vec3::y() * distance,
        Vec3::z() * distance,
    ];
    let mut on_parts = "part,mark,x,y,z\n".to_string();
    for body in &moving {
        for (k, mark) in marks.iter().enumerate() {
            let _ = writeln!(
                on_parts,
                "PART/{},{},{:?},{:?},{:?}",
                deck.parts[*body],
                k + 1,
                mark.x,
                mark.y,
                mark.z
            );
        }
    }
    let mut measured = "case,part,mark,x,y,z\n".to_string();
    for (state, case) in cases.iter().enumerate() {
        for body in &moving {
            for (k, mark) in marks.iter().enumerate() {
                let place = record.bodies[*body].poses[state].point(mark);
                let _ = writeln!(
                    measured,
                    "{case},PART/{},{},{:?},{:?},{:?}",
                    deck.parts[*body],
                    k + 1,
                    place.x,
                    place.y,
                    place.z
                );
            }
        }
    }
    let mut loads = "case".to_string();
    for drive in &deck.drives {
        let _ = write!(loads, ",{}", drive.name);
    }
    loads.push('\n');
    for (state, case) in cases.iter().enumerate() {
        loads += case;
        for drive in &deck.drives {
            let _ = write!(loads, ",{:?}", drive.values[state]);
        }
        loads.push('\n');
    }
    let mut study = format!(
        "# Made from results by `admire rebuild`. Every state of the results is a load case; the marks are the poses of the results.\n\
         # They have no noise: sigma is that of a coordinate measuring machine.\n\
         [model]\ndeck = \"{name}\"\n\n[loads]\nfile = \"load_cases.csv\"\n\n[loads.columns]\n"
    );
    for drive in &deck.drives {
        let _ = writeln!(study, "{} = \"{}\"", drive.name, drive.address);
    }
    study += "\n[marks]\non_parts = \"marks_on_parts.csv\"\nmeasured = \"marks_measured.csv\"\nsigma = 0.02\n";
    vec![
        ("study.toml".to_string(), study),
        ("load_cases.csv".to_string(), loads),
        ("marks_on_parts.csv".to_string(), on_parts),
        ("marks_measured.csv".to_string(), measured),
    ]
}

/// Returns a label for each state: its number, preceded by the name of its file if there are several files.
fn cases(record: &Record) -> Vec<String> {
    let several = record.runs.len() > 1;
    let mut cases = Vec::new();
    for run in &record.runs {
        for k in 1..=run.states.len() {
            let plain: String = run
                .name
                .chars()
                .map(|c| if c == ',' || c == '"' { '_' } else { c })
                .collect();
            cases.push(if several {
                format!("{plain} {k}")
            } else {
                k.to_string()
            });
        }
    }
    cases
}

fn moves(record: &Record, body: usize, size: f64) -> bool {
    let poses = &record.bodies[body].poses;
    poses.iter().any(|pose| {
        (pose.p - poses[0].p).norm() > 1e-9 * size || (pose.R - poses[0].R).amax() > 1e-9
    })
}
