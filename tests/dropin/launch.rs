use crate::run::{Results, SLIDER, folder, mdi, mdi_with, text};

const RUN: &str = "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSIMULATE/STATIC\nSTOP\n";

#[test]
fn every_launch_form_runs_the_command_file() {
    for words in [
        &["-c", "ru-standard", "i", "run.acf", "exit"][..],
        &["ru-s", "b", "run.acf"],
        &["ru-s", "i", "run.acf"],
        &["ru-standard", "run"],
        &["ru-solver", "run.acf"],
        &["-t", "4", "ru-s", "n", "\"run.acf\""],
        &["run"],
    ] {
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", RUN)]);
        let ran = mdi(folder.path(), words);
        assert_eq!(ran.code, 0, "{words:?}: {}", ran.stdout);
        let results = Results::read(folder.path(), "slider.res");
        let z = results.column("block_XFORM", "Z");
        assert!(
            z.len() == 1 && (z[0] - 0.5).abs() < 1e-9,
            "{words:?}: {z:?}"
        );
        assert_eq!(ran.stdout, text(folder.path(), "slider.msg"), "{words:?}");
    }
}

#[test]
fn commands_are_read_from_standard_input() {
    let folder = folder(&[("slider.adm", SLIDER)]);
    let ran = mdi_with(folder.path(), &["-c", "ru-standard", "i", "exit"], RUN, &[]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(folder.path(), "slider.res").steps.len(), 1);
}

#[test]
fn first_lines_come_in_three_forms() {
    let body = "SFORCE/1, FUNCTION=5\nSIMULATE/STATIC\nSTOP\n";
    for (head, prefix) in [
        ("\nfile/model=slider\n", "slider"),
        ("file/model=slider.adm, output_prefix=other\n", "other"),
        ("slider\nother\n", "other"),
        ("slider\n\n", "slider"),
        ("slider.adm\n \n", "slider"),
        ("\u{feff}slider\nother\n", "other"),
    ] {
        let acf = format!("{head}{body}\u{1a}");
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
        let ran = mdi(folder.path(), &["ru-s", "run.acf"]);
        assert_eq!(ran.code, 0, "{head:?}: {}", ran.stdout);
        let results = Results::read(folder.path(), &format!("{prefix}.res"));
        assert_eq!(results.steps.len(), 1, "{head:?}");
        assert!(text(folder.path(), &format!("{prefix}.msg")).contains("End Static Solution"));
    }
}

#[test]
fn files_with_dos_line_ends_give_the_same_answer() {
    let (deck, acf) = (SLIDER.replace('\n', "\r\n"), RUN.replace('\n', "\r\n"));
    let folder = folder(&[("slider.adm", &deck), ("run.acf", &acf)]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 0);
    let z = Results::read(folder.path(), "slider.res").column("block_XFORM", "Z");
    assert!((z[0] - 0.5).abs() < 1e-9);
}

#[test]
fn paths_of_other_computers_and_other_cases_are_found_with_a_warning() {
    let acf = "\nfile/model=C:\\Users\\somebody\\SLIDER\nSIMULATE/STATIC\nSTOP\n";
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(ran.stdout.contains("[foreign-path]"), "{}", ran.stdout);
}

#[test]
fn user_libraries_are_refused_by_name() {
    let folder = folder(&[]);
    let ran = mdi(
        folder.path(),
        &["-c", "ru-user", "i", "my.so", "run.acf", "exit"],
    );
    assert_eq!(ran.code, 2);
    assert!(
        ran.stdout.contains("`ru-user` cannot be run"),
        "{}",
        ran.stdout
    );
}
