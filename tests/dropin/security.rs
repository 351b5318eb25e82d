use std::path::Path;
use std::process::Command;

use crate::run::{Results, SLIDER, folder, mdi, mdi_with, text};

#[test]
fn a_command_file_writes_only_in_the_folders_of_its_run() {
    let outside = folder(&[]);
    let target = outside.path().join("x");
    let acf = format!(
        "\nfile/model=slider, output_prefix=\"{}\"\nSIM/STAT\n",
        target.display()
    );
    let inside = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let ran = mdi(inside.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
    assert_eq!(std::fs::read_dir(outside.path()).unwrap().count(), 0);

    let allowed = outside.path().display().to_string();
    let ran = mdi_with(
        inside.path(),
        &["ru-s", "run"],
        "",
        &[("ADMIRE_ALLOW_PATH", &allowed)],
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(outside.path(), "x.res").steps.len(), 1);
}

#[test]
fn saving_overwrites_no_other_file() {
    let acf = "\nfile/model=slider\nSIM/STAT\nSAVE/FILE=notes.txt\nSAVE/FILE=../escaped.sav\n";
    let folder = folder(&[
        ("slider.adm", SLIDER),
        ("run.acf", acf),
        ("notes.txt", "mine"),
    ]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert!(ran.stdout.contains("not a saved state"), "{}", ran.stdout);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
    assert_eq!(
        std::fs::read(folder.path().join("notes.txt")).unwrap(),
        b"mine"
    );
}

#[test]
fn absurd_sizes_are_refused_at_once() {
    for command in [
        "SIMULATE/STATICS, END=1, STEPS=2000000000",
        "SIMULATE/STATICS, END=1, DTOUT=1E-300",
        "FILE/COMMAND=run",
    ] {
        let acf =
            format!("\nfile/model=slider\nDEACTIVATE/JOINT, RANGE=2, 4000000000\n{command}\n");
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
        let start = std::time::Instant::now();
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert!(start.elapsed().as_secs() < 20, "{command}");
        assert_ne!(ran.code, 0, "{command}: {}", ran.stdout);
        assert!(ran.stdout.contains("---- START: ERROR ----"), "{command}");
    }
}

/// Returns all paths below a folder.
fn listing(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.is_symlink() {
            found.extend(listing(&path));
        }
        found.push(path.display().to_string());
    }
    found.sort();
    found
}

/// Returns the source files of the program itself.
fn sources() -> Vec<String> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let all = listing(&src).into_iter();
    all.filter(|path| Path::new(path).extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// Creates a folder `run` with the slider and a command file, beside a folder `victim` with a foreign file.
fn beside_a_victim(commands: &str) -> tempfile::TempDir {
    let place = folder(&[]);
    for name in ["run", "victim", "victim/deeper"] {
        std::fs::create_dir(place.path().join(name)).unwrap();
    }
    std::fs::write(place.path().join("victim/mine.res"), "mine").unwrap();
    std::fs::write(place.path().join("run/slider.adm"), SLIDER).unwrap();
    let commands = commands.replace("PLACE", &place.path().display().to_string());
    std::fs::write(place.path().join("run/run.acf"), commands).unwrap();
    place
}

#[test]
fn no_spelling_of_a_path_leads_out_of_the_folders_of_a_run() {
    for commands in [
        "\nfile/model=slider, output_prefix=PLACE/victim/mine\nSIM/STAT\n",
        "\nfile/model=slider, output_prefix=../victim/mine\nSIM/STAT\n",
        "\nfile/model=slider, output_prefix=..\\victim\\mine\nSIM/STAT\n",
        "\nfile/model=slider, output_prefix=\"C:PLACE/victim/mine\"\nSIM/STAT\n",
        "\nfile/model=slider, output_prefix=x/../../victim/mine\nSIM/STAT\n",
        "slider\n../victim/mine\nSIM/STAT\n",
        "\nfile/model=slider\nSIM/STAT\nSAVE/FILE=PLACE/victim/new\n",
        "\nfile/model=slider\nSIM/STAT\nSAVE/FILE=../victim/mine.res\n",
        // A command file or model elsewhere, under any name, does not open its folder for writing.
        "\nFILE/COMMAND=PLACE/victim/mine.res\nfile/model=slider, output_prefix=PLACE/victim/mine\nSIM/STAT\n",
        "\nfile/model=PLACE/victim/mine.res, output_prefix=PLACE/victim/new\nSIM/STAT\n",
    ] {
        let place = beside_a_victim(commands);
        let before = listing(&place.path().join("victim"));
        mdi(&place.path().join("run"), &["ru-s", "run"]);
        assert_eq!(
            text(&place.path().join("victim"), "mine.res"),
            "mine",
            "{commands}"
        );
        assert_eq!(listing(&place.path().join("victim")), before, "{commands}");
    }
}

#[cfg(unix)]
#[test]
fn links_are_followed_before_they_are_judged() {
    use std::os::unix::fs::symlink;
    let commands = "\nfile/model=slider\nSIM/STAT\nSTOP\n";
    // Links in place of the results file, to a file that does not exist, and to a folder.
    for (link, to) in [
        ("slider.res", "victim/mine.res"),
        ("slider.msg", "victim/new"),
        ("slider.out", "victim/deeper"),
    ] {
        let place = beside_a_victim(commands);
        symlink(place.path().join(to), place.path().join("run").join(link)).unwrap();
        let before = listing(&place.path().join("victim"));
        let ran = mdi(&place.path().join("run"), &["ru-s", "run"]);
        assert_ne!(ran.code, 0, "{link}: {}", ran.stdout);
        assert_eq!(
            text(&place.path().join("victim"), "mine.res"),
            "mine",
            "{link}"
        );
        assert_eq!(listing(&place.path().join("victim")), before, "{link}");
    }
    let place = beside_a_victim("\nfile/model=slider, output_prefix=link/mine\nSIM/STAT\n");
    symlink(place.path().join("victim"), place.path().join("run/link")).unwrap();
    let ran = mdi(&place.path().join("run"), &["ru-s", "run"]);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
    assert_eq!(text(&place.path().join("victim"), "mine.res"), "mine");
}

#[test]
fn a_model_elsewhere_may_have_its_results_beside_it_and_no_deeper() {
    let place = beside_a_victim(
        "\nfile/model=PLACE/victim/slider, output_prefix=PLACE/victim/answer\nSIM/STAT\n",
    );
    std::fs::write(place.path().join("victim/slider.adm"), SLIDER).unwrap();
    let ran = mdi(&place.path().join("run"), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(
        Results::read(&place.path().join("victim"), "answer.res")
            .steps
            .len(),
        1
    );
    let acf = format!(
        "\nfile/model={0}/slider, output_prefix={0}/deeper/answer\nSIM/STAT\n",
        place.path().join("victim").display()
    );
    std::fs::write(place.path().join("run/run.acf"), acf).unwrap();
    let ran = mdi(&place.path().join("run"), &["ru-s", "run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
}

#[test]
fn decks_and_command_files_start_no_process() {
    let deck = SLIDER
        .replacen(
            "A slider on a spring",
            "$(touch pwned) `touch pwned`; touch pwned",
            1,
        )
        .replacen("REQUEST/1", "STRING/1, STRING=$(touch pwned)\nREQUEST/1", 1);
    let acf = "\nfile/model=slider, output_prefix=$(touch pwned)\n! `touch pwned`\n!touch pwned\nSIM/STAT\n\
        ENVIRONMENT/NAME=PATH, VALUE=.\nPREFERENCES/LIBPATH=.\nCONTROL/FUNCTION=USER(1)\\, ROUTINE=evil::sub\n\
        SAVE/FILE=x;touch pwned\nRELOAD/FILE=|touch pwned\nSTOP\n";
    let folder = folder(&[
        ("slider.adm", &deck),
        ("run.acf", acf),
        ("evil.so", "not a library"),
    ]);
    mdi(folder.path(), &["ru-s", "run; touch pwned"]);
    mdi(folder.path(), &["ru-s", "run"]);
    assert!(!folder.path().join("pwned").exists());
    // Code that starts programs or ends their processes is reached only by a study or by a user's own command; the guide is shown by the
    // user's pager, and a page by the opener of the system; the build script asks git for the commit.
    let allowed = [
        "src/session/backend/process",
        "src/cli/doctor.rs",
        "src/cli/opening.rs",
        "src/cli/pager.rs",
        "src/cli/sweep_slurm.rs",
        "src/report/build.rs",
    ];
    let starts: Vec<String> = sources()
        .into_iter()
        .filter(|path| {
            std::fs::read_to_string(path)
                .unwrap()
                .contains("Command::new(")
        })
        .map(|path| path.replace('\\', "/"))
        .collect();
    assert!(
        starts
            .iter()
            .all(|path| allowed.iter().any(|place| path.contains(place))),
        "{starts:?}"
    );
}

#[test]
fn interfaces_that_only_unix_has_are_in_four_files() {
    let found: Vec<String> = sources()
        .into_iter()
        .filter(|path| {
            let text = std::fs::read_to_string(path).unwrap();
            [
                "os::unix",
                "os::linux",
                "cfg(unix)",
                "libc::",
                "/dev/",
                "/proc/",
            ]
            .iter()
            .any(|word| text.contains(word))
        })
        .map(|path| path.replace('\\', "/"))
        .collect();
    assert!(
        found.iter().all(|path| {
            path.ends_with("src/front/permissions.rs")
                || path.ends_with("src/session/backend/process_tree.rs")
                || path.ends_with("src/study/leftover.rs")
                || path.ends_with("src/sweep/folder.rs")
        }),
        "{found:?}"
    );
}

#[test]
fn nothing_endless_is_read_or_tried() {
    // A device never ends, a matrix with four thousand million rows is not created, and a large MAXIT must not hang.
    let matrix = "MATRIX/1, SPARSE, ROWS=4294967296, COLUMNS=4294967296, I=1, J=1, VALUES=1\nARRAY/1, X, SIZE=4000000000\n\
        ARRAY/2, U, SIZE=1, VARIABLES=1\nVARIABLE/1, FUNCTION=0\nLSE/1, X=1, U=2, A=1, B=1\nREQUEST/1";
    for (deck, command) in [
        (SLIDER.to_string(), "RELOAD/FILE=/dev/zero"),
        (SLIDER.to_string(), "FILE/COMMAND=/dev/zero"),
        (SLIDER.to_string(), "FILE/MODEL=/dev/zero"),
        (SLIDER.replacen("REQUEST/1", matrix, 1), "SIM/STAT"),
        (
            SLIDER.replace("K=10", "K=0"),
            "EQUILIBRIUM/MAXIT=2000000000\nSFORCE/1, FUNCTION=5\nSIM/STAT",
        ),
        (SLIDER.to_string(), "SIM/STAT, END=1, STEPS=1E300"),
        (SLIDER.to_string(), "SIM/STAT, END=1E300, STEPS=100001"),
        (
            SLIDER.to_string(),
            "DEACTIVATE/SFORCE, RANGE=1, 4294967295\nACTIVATE/SFORCE, RANGE=0, 1E30",
        ),
    ] {
        let acf = format!("\nfile/model=slider\n{command}\nSTOP\n");
        let folder = folder(&[("slider.adm", &deck), ("run.acf", &acf)]);
        let start = std::time::Instant::now();
        let ran = mdi_with(folder.path(), &["ru-s", "run"], "", &[("MDI_STRICT", "1")]);
        assert!(start.elapsed().as_secs() < 60, "{command}");
        assert!(
            (0..=3).contains(&ran.code),
            "{command}: {} {}",
            ran.code,
            ran.stderr
        );
        assert!(
            !ran.stderr.contains("panicked"),
            "{command}: {}",
            ran.stderr
        );
        assert!(
            ran.stdout.contains("---- START: "),
            "{command}: {}",
            ran.stdout
        );
    }
}

fn solve(folder: &Path, words: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .arg("solve")
        .args(words)
        .env_remove("ADMIRE_ALLOW_PATH")
        .output()
        .unwrap()
}

#[test]
fn admire_solve_reads_only_the_folders_of_the_run() {
    for command in [
        "file/model=PLACE/victim/slider",
        "file/model=../victim/slider",
        "FILE/COMMAND=../victim/other",
    ] {
        let place = beside_a_victim(&format!("\n{command}\nSIM/STAT\nSTOP\n"));
        let victim = place.path().join("victim");
        std::fs::write(victim.join("slider.adm"), SLIDER).unwrap();
        std::fs::write(victim.join("other.acf"), "\nfile/model=slider\n").unwrap();
        let run = place.path().join("run");
        let refused = solve(&run, &["run.acf"]);
        let said = String::from_utf8_lossy(&refused.stdout).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(
            said.contains("[read-outside]") && !said.contains("Model Title"),
            "{said}"
        );
        let allowed = solve(
            &run,
            &["run.acf", "--allow-path", &victim.display().to_string()],
        );
        assert_eq!(
            allowed.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&allowed.stdout)
        );
    }
}

#[test]
fn property_files_are_read_in_the_folders_of_the_deck() {
    let place = beside_a_victim("");
    let curve = "[MDI_HEADER]\nFILE_TYPE='spr'\n[CURVE]\n{disp force}\n0 0\n1 2\n2 4\n3 6\n";
    std::fs::write(place.path().join("victim/secret.spr"), curve).unwrap();
    let run = place.path().join("run");
    std::fs::write(run.join("own.spr"), curve).unwrap();
    for (file, outside) in [("../victim/secret.spr", true), ("own.spr", false)] {
        let deck = SLIDER.replacen("REQUEST/1", &format!("SPLINE/1, FILE={file}\nREQUEST/1"), 1);
        std::fs::write(run.join("slider.adm"), deck).unwrap();
        let checked = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(&run)
            .args(["check", "slider.adm", "--format", "plain"])
            .env_remove("ADMIRE_ALLOW_PATH")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&checked.stdout).into_owned()
            + &String::from_utf8_lossy(&checked.stderr);
        assert_eq!(said.contains("[read-outside]"), outside, "{file}: {said}");
    }
}

/// Checks that control sequences in titles, paths and commands are displayed on the console and not executed; the message file keeps them
/// unchanged.
#[test]
fn the_console_of_a_run_commands_no_terminal() {
    let deck = SLIDER.replace("A slider", "A \u{1b}]0;owned\u{7}slider");
    let acf = "\nfile/model=slider\nfile/model=\u{1b}[31mother\nSIM/STAT\nRED\u{9b}31m/1\nSTOP\n";
    let folder = folder(&[("slider.adm", &deck), ("run.acf", acf)]);
    let ran = mdi(
        folder.path(),
        &["-c", "ru-standard", "i", "run.acf", "exit"],
    );
    let all = format!("{}{}", ran.stdout, ran.stderr);
    assert!(all.contains("\\u001b"), "{all}");
    let obeyed = all
        .chars()
        .find(|c| c.is_control() && !"\r\n\t".contains(*c));
    assert_eq!(obeyed, None, "{all:?}");
}

/// Checks that names and titles are inserted into HTML pages as text; a browser reads the pages in `tests/pages`.
#[test]
fn no_name_becomes_a_part_of_a_page() {
    let place = folder(&[("run.acf", "\nfile/model=model\nSIM/STAT\nSTOP\n")]);
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    for entry in std::fs::read_dir(shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, place.path().join(path.file_name().unwrap())).unwrap();
    }
    let breaking = "</script><img src=x onerror=alert(1)>";
    let deck = text(place.path(), "model.adm");
    let title = deck.lines().next().unwrap().to_string();
    let deck = deck.replacen(&title, breaking, 1).replacen(
        "adams_view_name='A_J'",
        &format!("adams_view_name='{breaking}'"),
        1,
    );
    assert_eq!(deck.matches(breaking).count(), 2);
    std::fs::write(place.path().join("model.adm"), deck).unwrap();
    assert_eq!(mdi(place.path(), &["ru-s", "run"]).code, 0);
    for (words, page) in [
        (&["view", "model.adm", "-o", "deck.html"][..], "deck.html"),
        (&["view", "model.res", "-o", "results.html"], "results.html"),
        (&["identify", "--out", "fit", "."], "fit/report.html"),
        (&["diagnose", "--out", "found", "."], "found/report.html"),
        (
            &["kc", "model.adm", "--config", "kc.toml", "--out", "kc"],
            "kc/report.html",
        ),
    ] {
        let ran = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(place.path())
            .args(words)
            .output()
            .unwrap();
        assert!(
            matches!(ran.status.code(), Some(0 | 3)),
            "{words:?}: {ran:?}"
        );
        let page = text(place.path(), page);
        assert!(page.contains("</html>"), "{words:?}");
        assert!(!page.contains("<img"), "{words:?}");
        let (opened, closed) = (
            page.matches("<script").count(),
            page.matches("</script>").count(),
        );
        assert_eq!(opened, closed, "{words:?}");
    }
}
