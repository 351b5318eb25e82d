use crate::run::{SLIDER, folder, mdi};

/// Returns the console output from the first command on, without the parts that differ from run to run.
fn said(deck: &str, acf: &str) -> String {
    let folder = folder(&[("slider.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let start = ran.stdout.find(" command:").unwrap_or(0);
    let end = ran
        .stdout
        .find("Finished -----")
        .unwrap_or(ran.stdout.len());
    let here = std::path::absolute(folder.path())
        .unwrap()
        .canonicalize()
        .unwrap();
    let text = ran.stdout[start..end]
        .replace(&here.display().to_string(), "FOLDER")
        .replace(&folder.path().display().to_string(), "FOLDER")
        .replace("FOLDER\\", "FOLDER/");
    assert!(ran.stderr.is_empty(), "{}", ran.stderr);
    // Iteration details are left out, because they depend on the solver.
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| {
            !line.trim_start().starts_with(|c: char| c.is_ascii_digit()) || line.contains('|')
        })
        .map(|line| line.split(": no equilibrium after").next().unwrap())
        .collect();
    format!("exit code {}\n{}", ran.code, lines.join("\n").trim_end())
}

const RUN: &str = "\nfile/model=slider\nSIMULATE/STATIC\nSTOP\n";

#[test]
fn an_undefined_marker() {
    let deck = SLIDER.replace("I=21, J=11", "I=99, J=11");
    insta::assert_snapshot!(said(&deck, RUN));
}

#[test]
fn a_missing_file() {
    insta::assert_snapshot!(said(SLIDER, "\nfile/model=slyder\nSIMULATE/STATIC\nSTOP\n"));
}

#[test]
fn a_misspelt_keyword_in_the_deck() {
    let deck = SLIDER.replace("SPRINGDAMPER", "SPRINGDAMER");
    insta::assert_snapshot!(said(&deck, RUN));
}

/// Checks an unknown argument of INTEGRATOR and of SPRINGDAMPER.
///
/// The documented argument list of INTEGRATOR is incomplete, so the deck runs with a note. The list of SPRINGDAMPER is complete, so this is
/// an error.
#[test]
fn an_argument_of_a_statement_known_in_part() {
    let deck = |line: &str| SLIDER.replacen("END", &format!("{line}\nEND"), 1);
    let said_in_part = said(&deck("INTEGRATOR/PROFILE"), RUN);
    assert!(said_in_part.starts_with("exit code 0"), "{said_in_part}");
    assert!(said_in_part.contains("INTEGRATOR has no known argument PROFILE"));
    let deck = SLIDER.replace("SPRINGDAMPER/1", "SPRINGDAMPER/1, PROFILE");
    assert_ne!(deck, SLIDER);
    let said = said(&deck, RUN);
    assert!(
        said.contains("SPRINGDAMPER has no argument PROFILE"),
        "{said}"
    );
    assert!(said.contains("cannot be simulated"), "{said}");
}

#[test]
fn a_misspelt_command() {
    insta::assert_snapshot!(said(
        SLIDER,
        "\nfile/model=slider\nSFORSE/1, FUNCTION=5\nSIMULATE/STATIC\nSTOP\n"
    ));
}

#[test]
fn no_equilibrium() {
    let deck = SLIDER.replace("K=10", "K=0");
    insta::assert_snapshot!(said(
        &deck,
        "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSIMULATE/STATIC\nSTOP\n"
    ));
}
