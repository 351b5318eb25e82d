use admire_sweep::SweepPlan;

use super::{Bench, admire, said, shown};

/// Returns a plan of the pseudo McPherson study, in which the front arm is longer or shorter than in the deck.
fn plan(keep: &str) -> Bench {
    let bench = Bench::new(|_| {
        format!(
            "study = \"study\"\nseed = 1\n[sampling]\nplan = \"full-factorial\"\n[[vary]]\nname = \"arm\"\naddress = \"MARKER/2.QP.3\"\n\
             apply = \"offset\"\nvalues = [-0.5, 0.0, 0.5]\n{keep}"
        )
    });
    let study = bench.path("study");
    std::fs::create_dir(&study).expect("a folder");
    for entry in std::fs::read_dir(super::root().join("corpus/pseudo-mcpherson")).expect("corpus") {
        let path = entry.expect("an entry").path();
        std::fs::copy(&path, study.join(path.file_name().expect("a name"))).expect("a copy");
    }
    bench
}

const KEEP: &str = "[[keep]]\nidentification = \"parameters[BUSHING/1.K.*].value\"\nname = \"K\"\n\
    [[keep]]\nidentification = \"fit_test.chi2\"\n";

#[test]
fn a_study_with_another_deck_gives_what_identify_gives_on_it() {
    let bench = plan(KEEP);
    let ran = bench.sweep("out", &["--jobs", "2"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let rows = bench.rows("out", 1);
    assert_eq!(rows.len(), 3);
    let (deck, study) = (bench.path("study/model.adm"), bench.path("study"));
    // The third case, run separately.
    let plan = SweepPlan::read(&bench.path("sweep.toml"));
    let plan = plan.value.expect("a plan");
    let varied = plan.deck_with(&plan.numbers(2)).expect("a deck");
    std::fs::write(&deck, varied.bytes()).expect("written");
    let out = bench.path("single");
    let ran = admire(&["identify", shown(&study), "--out", shown(&out)]);
    assert!(ran.status.success(), "{}", said(&ran));
    let text = std::fs::read_to_string(out.join("identification.json")).expect("the answer");
    // serde_json may round the last bit of a number differently from the standard library.
    let numbers = |key: &str| -> Vec<f64> {
        let mark = format!("\"{key}\": ");
        let mut pieces = text.split(mark.as_str());
        pieces.next();
        pieces
            .filter_map(|piece| piece.split([',', '\n']).next()?.parse().ok())
            .collect()
    };
    let mut expected = numbers("value")[..3].to_vec();
    expected.push(numbers("chi2")[0]);
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&rows[2].0.outputs), bits(&expected));
    assert_ne!(bits(&rows[1].0.outputs), bits(&expected));
}

#[test]
fn a_diagnosis_of_every_case_is_that_of_the_command() {
    // The third arm is wrong by three millimetres, so tolerances no longer explain the study.
    let keep = "[[keep]]\ndiagnosis = \"baseline.chi2_per_dof\"\n[[keep]]\ndiagnosis = \"none_of_these\"\n\
        [[keep]]\ndiagnosis = \"findings[dry-friction@BUSHING/1.K.1].probability\"\n";
    let bench = plan(keep);
    let file = bench.path("sweep.toml");
    let text = std::fs::read_to_string(&file).expect("the plan");
    let text = text
        .replace("[-0.5, 0.0, 0.5]", "[0.0, 3.0]")
        .replace("seed = 1\n", "seed = 1\ncheck_gain = \"quick\"\n");
    std::fs::write(&file, text).expect("written");
    let ran = bench.sweep("out", &["--jobs", "2"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let rows = bench.rows("out", 1);
    assert_eq!(rows.len(), 2);
    let plan = SweepPlan::read(&file).value.expect("a plan");
    let varied = plan.deck_with(&plan.numbers(1)).expect("a deck");
    std::fs::write(bench.path("study/model.adm"), varied.bytes()).expect("written");
    let (study, out) = (bench.path("study"), bench.path("single"));
    let words = ["diagnose", shown(&study), "--out", shown(&out)];
    let ran = admire(&[&words[..], &["--check-gain", "quick"]].concat());
    assert!(ran.status.success(), "{}", said(&ran));
    let text = std::fs::read_to_string(out.join("diagnosis.json")).expect("the answer");
    let number = |key: &str| -> f64 {
        let from = text.find(&format!("\"{key}\": ")).expect("the field") + key.len() + 4;
        let digits = text[from..].split([',', '\n']).next().expect("a number");
        digits.parse().expect("a number")
    };
    let single = [number("chi2_per_dof"), number("none_of_these")].map(f64::to_bits);
    let of = |row: usize| [0, 1].map(|k: usize| rows[row].0.outputs[k].to_bits());
    assert_eq!(of(1), single);
    assert_ne!(of(0), single);
    // No friction was found in this case.
    assert!(rows[0].0.outputs[2].is_nan());
}

#[test]
fn places_that_no_answer_has_are_refused() {
    for (keep, message) in [
        (
            "[[keep]]\nidentification = \"parametres[*].value\"\n",
            "has no field `parametres`",
        ),
        (
            "[[keep]]\nidentification = \"a[b\"\n",
            "a field of the result",
        ),
        (
            "[[keep]]\nidentification = \"parameters[BUSHING/9.K.1].value\"\n",
            "`BUSHING/9.K.1`",
        ),
        (
            "[[keep]]\nidentification = \"parameters[BUSHING/1.K.1].unit\"\n",
            "is not a number",
        ),
        ("[[keep]]\ncolumn = \"KNUCKLE_XFORM.Z\"\n", "from a study"),
    ] {
        let bench = plan(keep);
        let ran = bench.sweep("out", &[]);
        assert_eq!(ran.status.code(), Some(1), "{}", said(&ran));
        assert!(said(&ran).contains(message), "{}", said(&ran));
        assert!(!bench.path("out").exists());
    }
}

#[cfg(unix)]
#[test]
fn recorded_runs_are_replayed_without_the_program() {
    let solver = |command: &str| {
        let command = command.to_string();
        move |text: String| {
            let text = text.replace("cases = 1000", "cases = 4");
            format!("{text}\n[solver]\n{command}recordings = \"recorded\"\n")
        }
    };
    let mdi = env!("CARGO_BIN_EXE_mdi");
    let bench = Bench::new(solver(&format!(
        "command = [\"{mdi}\", \"-c\", \"ru-s\", \"i\", \"{{acf}}\", \"exit\"]\n"
    )));
    let ran = bench.sweep("out", &["--jobs", "2"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let recorded = bench.rows("out", super::NUMBERS);
    let text = std::fs::read_to_string(bench.path("sweep.toml")).expect("the plan");
    let from = text.find("command = [\"").expect("the command");
    let to = from + text[from..].find('\n').expect("a line") + 1;
    let replay = format!("{}{}", &text[..from], &text[to..]);
    std::fs::write(bench.path("sweep.toml"), &replay).expect("written");
    let ran = bench.sweep("replayed", &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    let replayed = bench.rows("replayed", super::NUMBERS);
    assert!(
        replayed
            .iter()
            .map(super::bits)
            .eq(recorded.iter().map(super::bits))
    );
    // The additional case was never recorded.
    let more = replay.replace("cases = 4", "cases = 5");
    std::fs::write(bench.path("sweep.toml"), more).expect("written");
    bench.sweep("more", &[]);
    let rows = bench.rows("more", super::NUMBERS);
    let missing = rows
        .iter()
        .filter(|(row, _)| row.reason.contains("no recording"));
    assert!(missing.count() >= 1);
}
