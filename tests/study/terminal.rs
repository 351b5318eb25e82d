use super::run::{admire, copied};

/// Returns the commands that `admire --help` lists.
fn commands() -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let help = admire(folder.path(), &["--help"]).out;
    let list = help
        .split("Commands:\n")
        .nth(1)
        .unwrap()
        .split("\n\n")
        .next()
        .unwrap();
    let name = |line: &str| {
        let word = line
            .strip_prefix("  ")
            .filter(|rest| !rest.starts_with(' '))?;
        word.split_whitespace().next().map(str::to_string)
    };
    list.lines()
        .filter_map(name)
        .filter(|name| name != "help")
        .collect()
}

#[test]
fn every_command_shows_an_example_of_itself() {
    let folder = tempfile::tempdir().unwrap();
    let commands = commands();
    assert!(commands.len() > 30, "{commands:?}");
    let lacking: Vec<&String> = commands
        .iter()
        .filter(|name| {
            let help = admire(folder.path(), &[name, "--help"]).out;
            let examples = help.rsplit("Examples").next().unwrap_or_default();
            !help.contains("Examples") || !examples.contains(&format!("admire {name}"))
        })
        .collect();
    assert!(lacking.is_empty(), "{lacking:?}");
}

#[test]
fn a_manual_page_of_every_command_is_installed() {
    let folder = tempfile::tempdir().unwrap();
    let said = admire(folder.path(), &["install", "--prefix", "usr"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let pages = folder.path().join("usr/share/man/man1");
    for name in commands() {
        let text = std::fs::read_to_string(pages.join(format!("admire-{name}.1"))).unwrap();
        assert!(
            text.contains(".SH SYNOPSIS") && text.contains("Examples"),
            "{name}"
        );
    }
    let main = std::fs::read_to_string(pages.join("admire.1")).unwrap();
    assert!(main.contains("First steps"));
    for path in [
        "bash-completion/completions/admire",
        "zsh/site-functions/_admire",
        "fish/vendor_completions.d/admire.fish",
    ] {
        let text = std::fs::read_to_string(folder.path().join("usr/share").join(path)).unwrap();
        assert!(text.contains("COMPLETE"), "{path}");
    }
}

#[test]
fn the_doctor_finds_the_solver_and_a_program_that_answers() {
    let (folder, study) = copied("pseudo-mcpherson");
    let said = admire(folder.path(), &["doctor"]);
    assert_eq!(said.code, 0, "{}", said.out);
    assert!(
        said.out.contains("mdi of admire") && said.out.contains("writable"),
        "{}",
        said.out
    );
    let version = admire(folder.path(), &["--version"]).out;
    assert!(
        version.contains(env!("CARGO_PKG_VERSION")) && version.trim_end().ends_with(')'),
        "{version}"
    );
    let text = std::fs::read_to_string(study.join("study.toml")).unwrap();
    let with = |program: &str| {
        let solver = format!(
            "[solver]\nbackend = \"command\"\ncommand = ['{program}', \"-c\", \"ru-standard\", \"i\", \"{{acf}}\", \"exit\"]\n"
        );
        std::fs::write(study.join("study.toml"), text.clone() + &solver).unwrap();
        admire(folder.path(), &["doctor", "study"])
    };
    let said = with(env!("CARGO_BIN_EXE_mdi"));
    assert_eq!(said.code, 0, "{}", said.out);
    assert!(said.out.contains("prints: admire"), "{}", said.out);
    let said = with("no-such-solver");
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(
        said.out.contains("`no-such-solver` was not found"),
        "{}",
        said.out
    );
}

#[test]
fn stages_are_said_as_much_as_is_asked_for() {
    let (folder, _study) = copied("pseudo-mcpherson");
    let fit = |more: &[&str]| {
        let arguments = [
            &["identify", "study", "--out", "out", "--method", "direct"],
            more,
        ]
        .concat();
        admire(folder.path(), &arguments).err
    };
    assert!(fit(&["-v"]).contains("identifying\n"));
    assert!(!fit(&[]).contains("identifying"));
    assert_eq!(fit(&["--quiet"]), "");
    // A quiet command reports complaints, but no notes.
    let (folder, _study) = copied("kc-curves");
    let words = ["plan", "study", "--for", "stiffnesses"];
    let note = "curves of the rig";
    assert!(admire(folder.path(), &words).err.contains(note));
    assert_eq!(
        admire(folder.path(), &[&words[..], &["-q"]].concat()).err,
        ""
    );
}

/// Checks that a page on a terminal is shown by the pager of the user; `script` provides the terminal.
#[test]
#[cfg(unix)]
fn a_page_of_the_guide_goes_through_the_pager() {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_admire");
    let shown = |pager: &str| {
        let mut command = std::process::Command::new("script");
        let line = format!("'{program}' guide install");
        let run = command
            .args(["-q", "-e", "-c", &line, "/dev/null"])
            .env("PAGER", pager)
            .current_dir(folder.path())
            .stdin(std::process::Stdio::null())
            .output();
        let Ok(run) = run else {
            println!("SKIPPED: there is no program `script`");
            return None;
        };
        assert!(run.status.success(), "{run:?}");
        Some(String::from_utf8_lossy(&run.stdout).replace('\r', ""))
    };
    let plain = admire(folder.path(), &["guide", "install"]).out;
    let Some(paged) = shown("sed s/^/PAGED/") else {
        return;
    };
    let lines = plain.lines();
    let expected = lines.fold(String::new(), |text, line| text + "PAGED" + line + "\n");
    assert_eq!(paged, expected);
    // A missing pager counts as none.
    assert_eq!(shown("no-such-pager").unwrap(), plain);
}

/// Checks that pages keep to 80 columns, except for code and for paths that cannot be broken.
#[test]
fn pages_of_the_guide_keep_to_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    for page in ["study", "kc", "sweep", "tutorial"] {
        let said = admire(folder.path(), &["guide", page]);
        let wide: Vec<&str> = said
            .out
            .lines()
            .filter(|line| line.chars().count() > 80)
            .collect();
        assert!(said.code == 0 && wide.is_empty(), "{page}: {wide:#?}");
    }
}
