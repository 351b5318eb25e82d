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
        &["acar", "ru-solver", "run.acf"],
        &["aview", "ru-st", "b", "RUN.ACF"],
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

/// Checks scripts that answer the launcher's menus on standard input, one word per line.
#[test]
fn menus_are_answered_on_standard_input() {
    let folder = folder(&[("slider.adm", SLIDER), ("my run.acf", RUN)]);
    for (words, menu) in [
        (&[][..], "ru-standard\ni\nmy run.acf\nexit\n"),
        (&["-c", "ru-standard"], "i\nmy run.acf\nexit\n"),
        (&["-c", "ru-standard", "i"], "my run.acf\n"),
    ] {
        let ran = mdi_with(folder.path(), words, menu, &[]);
        assert_eq!(ran.code, 0, "{words:?}: {}", ran.stdout);
        assert_eq!(Results::read(folder.path(), "slider.res").steps.len(), 1);
        std::fs::remove_file(folder.path().join("slider.res")).unwrap();
    }
}

/// Checks that every launch leaves a message file with the last lines of ADAMS, because scripts poll it for the end of a run.
#[test]
fn every_launch_leaves_a_message_file_with_its_last_lines() {
    for (words, input, name) in [
        (
            &["-c", "ru-user", "i", "my.so", "run.acf", "exit"][..],
            "",
            "run.msg",
        ),
        (&["acar", "ru-acar", "b", "x.cmd"], "", "x.msg"),
        (&["ru-standard", "nowhere"], "", "nowhere.msg"),
        (
            &["ru-standard"],
            "ru-user\ni\nlib\nother.acf\n",
            "other.msg",
        ),
        (&["ru-standard"], "\nstop\n", "adams.msg"),
    ] {
        let folder = folder(&[]);
        let ran = mdi_with(folder.path(), words, input, &[]);
        let messages = text(folder.path(), name);
        let lines: Vec<&str> = messages.lines().collect();
        let tail = &lines[lines.len().saturating_sub(2)..];
        assert!(
            tail[0] == "Finished -----" && tail[1].starts_with("Elapsed time = "),
            "{words:?}: {messages}"
        );
        assert_eq!(ran.code == 0, input == "\nstop\n", "{words:?}");
    }
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

#[test]
fn other_products_are_refused_by_name_and_are_file_names_after_the_word() {
    let folder = folder(&[
        ("slider.adm", SLIDER),
        ("controls.acf", RUN),
        ("n.acf", RUN),
    ]);
    for words in [
        &["acar", "ru-acar", "b", "x.cmd"][..],
        &["aview", "ru-standard", "i", "x.cmd"],
        &["acar", "run.acf"],
        &["ru-u", "lib", "run.acf"],
    ] {
        let ran = mdi(folder.path(), words);
        assert_eq!(ran.code, 2, "{words:?}");
        assert!(
            ran.stdout.contains("cannot be run by this solver"),
            "{}",
            ran.stdout
        );
        assert!(
            words
                .iter()
                .any(|word| ran.stdout.contains(&format!("`{word}`"))),
            "{}",
            ran.stdout
        );
        assert!(!folder.path().join("slider.res").exists());
    }
    let ran = mdi(folder.path(), &["ru-standard", "controls"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
}

#[test]
fn unknown_words_are_skipped_with_a_warning() {
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", RUN)]);
    let line = "-t 4 -c ru-standard n 16mb i run.acf more exit";
    let ran = mdi(folder.path(), &line.split(' ').collect::<Vec<_>>());
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    for word in ["`-t 4`", "`n`", "`16mb`", "`more`"] {
        let said = format!("the word {word} of the command line is unknown and is ignored");
        assert!(ran.stdout.contains(&said), "{word}: {}", ran.stdout);
    }
    assert_eq!(ran.stdout.matches("---- START: WARNING ----").count(), 4);
}

#[test]
fn the_name_it_is_started_under_does_not_matter() {
    let tools = folder(&[]);
    for name in ["adams2024_1", "mdi2005", "ADAMS08", "my solver.exe"] {
        let program = tools.path().join(name);
        std::fs::copy(env!("CARGO_BIN_EXE_mdi"), &program).unwrap();
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", RUN)]);
        for words in [&["ru-standard", "run"][..], &["run"]] {
            let mut command = std::process::Command::new(&program);
            command.args(words).current_dir(folder.path());
            command.stdout(std::process::Stdio::null());
            // A process started by another test in the meantime may still have the copy open for writing.
            let status = loop {
                match command.status() {
                    Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => {
                        std::thread::sleep(std::time::Duration::from_millis(10));
                    }
                    status => break status.unwrap(),
                }
            };
            assert!(status.success(), "{name}");
            assert_eq!(
                Results::read(folder.path(), "slider.res").steps.len(),
                1,
                "{name}"
            );
        }
    }
}

#[test]
fn paths_are_found_as_scripts_write_them() {
    for (written, warning) in [
        ("my runs/the slider", None),
        (r"my runs\the slider.adm", None),
        (r#""my runs\the slider""#, None),
        ("'my runs/the slider.adm'", None),
        ("  my runs/the slider  ", None),
        // Windows does not distinguish upper and lower case.
        (
            r"MY RUNS\The Slider.ADM",
            (!cfg!(windows)).then_some("[file-name-case]"),
        ),
        (r"D:\work\the slider", Some("[foreign-path]")),
        ("/home/somebody/else/the slider.adm", Some("[foreign-path]")),
    ] {
        let acf = format!(
            "\nfile/model={written}, output_prefix=out\nSFORCE/1, FUNCTION=5\nSIMULATE/STATIC\nSTOP\n"
        );
        let folder = folder(&[("run.acf", &acf)]);
        std::fs::create_dir(folder.path().join("my runs")).unwrap();
        std::fs::write(folder.path().join("my runs/the slider.adm"), SLIDER).unwrap();
        if warning == Some("[foreign-path]") {
            std::fs::write(folder.path().join("the slider.adm"), SLIDER).unwrap();
        }
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{written}: {}", ran.stdout);
        assert_eq!(
            Results::read(folder.path(), "out.res").steps.len(),
            1,
            "{written}"
        );
        match warning {
            Some(code) => assert!(ran.stdout.contains(code), "{written}: {}", ran.stdout),
            None => assert!(!ran.stdout.contains("WARNING"), "{written}: {}", ran.stdout),
        }
    }
    // The path of the command file itself: absolute, with blanks, and in quotes left by a shell.
    let folder = folder(&[("slider.adm", SLIDER)]);
    let acf = folder.path().join("a run.acf");
    std::fs::write(&acf, RUN).unwrap();
    for word in [acf.display().to_string(), format!("\"{}\"", acf.display())] {
        let ran = mdi(folder.path(), &["-c", "ru-standard", "i", &word, "exit"]);
        assert_eq!(ran.code, 0, "{}", ran.stdout);
    }
}

#[test]
fn byte_order_marks_and_the_end_of_dos_files_are_tolerated() {
    let marked = |text: &str| format!("\u{feff}{text}\u{1a}\u{1a}");
    for acf in [
        "\nfile/model=slider\nSIM/STAT\nSTOP\n",
        "slider\n\nSIM/STAT\n",
        "\r\nfile/model=slider\r\nSIM/STAT\r\n",
    ] {
        let folder = folder(&[("slider.adm", &marked(SLIDER)), ("run.acf", &marked(acf))]);
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert_eq!(ran.code, 0, "{acf:?}: {}", ran.stdout);
        assert_eq!(
            Results::read(folder.path(), "slider.res").steps.len(),
            1,
            "{acf:?}"
        );
        assert!(
            !ran.stdout.contains("ERROR") && !ran.stdout.contains("WARNING"),
            "{acf:?}: {}",
            ran.stdout
        );
    }
}

/// Replaces every number of a line by `#`, so that lines of different runs can be compared.
fn without_numbers(line: &str) -> String {
    let mut out = String::new();
    for word in line.split_whitespace() {
        let digits = word.trim_end_matches(['s', ',', '%', '.']);
        let number = digits.parse::<f64>().is_ok();
        out += if number { "#" } else { word };
        out += if number { &word[digits.len()..] } else { "" };
        out.push(' ');
    }
    out.trim_end().to_string()
}

/// Checks that the message lines that readers expect have the form of lines in real message files.
#[test]
fn lines_that_readers_look_for_are_those_of_real_message_files() {
    let Some(real) = crate::common::shared("real-decks") else {
        return;
    };
    let mut known = std::collections::BTreeSet::new();
    for path in crate::common::files_below(&real, "msg") {
        let bytes = std::fs::read(path).unwrap();
        known.extend(String::from_utf8_lossy(&bytes).lines().map(without_numbers));
    }
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", RUN)]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 0);
    let ours = text(folder.path(), "slider.msg");
    let mut seen = 0;
    for line in ours.lines() {
        let start = line.trim_start();
        let looked_for = [
            "Begin ",
            "End ",
            "Static Solution",
            "Residual imbalance",
            "Finished",
            "Elapsed time",
            "---- ",
        ];
        if looked_for.iter().any(|word| start.starts_with(word)) {
            assert!(known.contains(&without_numbers(line)), "{line}");
            seen += 1;
        }
    }
    assert!(seen >= 6, "{ours}");
    // The banner states the format and the program that writes it.
    assert!(ours.contains("A d a m s   C++   S o l v e r") && ours.contains("admire "));
}

/// Checks that a dataset named on the command line beside the command file is not executed as commands.
///
/// Its title would otherwise name a model, and its second line the output files.
#[test]
fn a_dataset_on_the_command_line_is_not_executed() {
    let deck = SLIDER.replacen('\n', "\n!\n", 1);
    let names = |folder: &std::path::Path| {
        let all = std::fs::read_dir(folder).unwrap().flatten();
        let mut all: Vec<String> = all
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        all.sort();
        all
    };
    let folder = folder(&[
        ("x.adm", &deck),
        ("x.acf", "\nfile/model=x\nSIM/STAT\nSTOP\n"),
    ]);
    let ran = mdi(folder.path(), &["ru-standard", "b", "x.adm", "x.acf"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(!names(folder.path()).iter().any(|name| name.contains('!')));
    assert!(folder.path().join("x.res").is_file());
    let folder = crate::run::folder(&[("x.adm", &deck)]);
    let ran = mdi(folder.path(), &["ru-standard", "b", "x.adm"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(ran.stdout.contains("is a dataset"), "{}", ran.stdout);
    assert_eq!(names(folder.path()), ["x.adm", "x.msg"]);
}
