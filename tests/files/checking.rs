//! Tests of `admire check` from the command line: command files with their decks, statements that ADAMS rejects, and the filters and
//! formats of the output.

use std::path::Path;

use super::folder::{Folder, run};
use crate::common::{files_below, shared};

const DECK: &str = "a title\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\n\
MARKER/10, PART=1\nPART/2, MASS=1.5, CM=20, IP=1E4, 1E4, 1E4\nMARKER/20, PART=2\nJOINT/1, REVOLUTE, I=20, J=10\n\
JOINT/7, REVOLUTE, I=20, J=10\nSFORCE/3, I=20, J=10, ROTATIONAL, FUNCTION=2*AZ(20,10)\nACCGRAV/KGRAV=-9806.65\nEND\n";

impl Folder {
    /// Runs `admire` and returns the exit code and the text of both output streams.
    fn said(&self, words: &[&str]) -> (i32, String) {
        let (code, out, errors) = self.run(words);
        (code, out + &errors)
    }

    /// Checks a command file in the folder of the deck. Returns the exit code and the diagnostics, one per line.
    fn commands(&self, commands: &str) -> (i32, String) {
        self.write("r.acf", &format!("\nfile/model=d\n{commands}"));
        self.said(&["check", "r.acf", "--format", "plain"])
    }

    /// Checks a deck. Returns the exit code and the diagnostics, one per line.
    fn deck(&self, text: &str) -> (i32, String) {
        self.write("x.adm", text);
        self.said(&["check", "x.adm", "--format", "plain"])
    }
}

/// Runs `admire` in a folder and returns the exit code and the text of both output streams.
fn said(folder: &Path, words: &[&str]) -> (i32, String) {
    let (code, out, errors) = run(folder, words);
    (code, out + &errors)
}

#[test]
fn commands_name_objects_of_their_deck() {
    let folder = Folder::with(DECK);
    let (code, said) = folder.commands("DEACTIVATE/JOINT, ID=4711\n");
    assert_eq!(code, 1, "{said}");
    assert!(
        said.starts_with("r.acf:3:22: error[undefined-id]: JOINT/4711 is not in d.adm"),
        "{said}"
    );
    let (code, said) = folder.commands("DEACTIVATE/JOINT, RANGE=100, 200\n");
    assert_eq!(code, 0);
    assert!(
        said.contains("warning[undefined-id]: no JOINT of d.adm has an id from 100 to 200"),
        "{said}"
    );
    for (wrong, message) in [
        ("SFORCE/4, FUNCTION=1\n", "SFORCE/4 is not in d.adm"),
        (
            "SFORCE/3, FUNCTION=AZ(20,11)\n",
            "SFORCE/3 names MARKER/11, which is not in d.adm",
        ),
        ("BUSHING/1, K=1,1,1\n", "BUSHING/1 is not in d.adm"),
    ] {
        let (code, said) = folder.commands(wrong);
        assert_eq!(code, 1, "{said}");
        assert!(said.contains(message), "{said}");
    }
    let fine = "DEACTIVATE/JOINT, ID=7\nACTIVATE/JOINT, RANGE=5, 9\nSFORCE/3, FUNCTION=AZ(20,10)\nSIMULATE/STATICS\nSTOP\n";
    assert_eq!(folder.commands(fine), (0, String::new()));
}

#[test]
fn a_model_that_is_not_there_is_an_error_and_one_of_another_computer_a_warning() {
    let folder = Folder::with(DECK);
    folder.write("r.acf", "file/model=nowhere\nsimulate/statics\n");
    let (code, said) = folder.said(&["check", "r.acf", "--format", "plain"]);
    assert_eq!(code, 1);
    assert!(
        said.contains("r.acf:1:12: error[cannot-read]: there is no file `nowhere`"),
        "{said}"
    );
    folder.write("r.acf", "file/model=C:\\runs\\nowhere\nsimulate/statics\n");
    let (code, said) = folder.said(&["check", "r.acf", "--format", "plain"]);
    assert_eq!(code, 0);
    assert!(said.contains("warning[cannot-read]"), "{said}");
    folder.write("old.acf", "d\nd\nDEACTIVATE/JOINT, ID=2\n");
    let (code, said) = folder.said(&["check", "old.acf", "--format", "plain"]);
    assert_eq!(code, 1);
    assert!(said.contains("JOINT/2 is not in"), "{said}");
}

#[test]
fn times_of_simulations_go_on() {
    let folder = Folder::with(DECK);
    for (wrong, code, message) in [
        ("SIMULATE/STATICS, END=1\n", 0, "no STEPS or DTOUT"),
        ("SIMULATE/DYNAMICS, DTOUT=1\n", 1, "no END or DURATION"),
        (
            "SIM/DYN, END=2, STEPS=4\nSIM/DYN, END=1, STEPS=4\n",
            1,
            "the simulation ends at time 1, but the time is already 2",
        ),
        (
            "SIM/DYN, DURATION=2, STEPS=4\nSIM/TYPE=DYNAMICS, END=2, STEPS=4\n",
            1,
            "the simulation ends at time 2, but the time is already 2",
        ),
    ] {
        let (found, said) = folder.commands(wrong);
        assert!(found == code && said.contains(message), "{wrong}: {said}");
    }
    // A sensor may end a simulation early, so a second simulation to the same END is allowed.
    folder.write(
        "d.adm",
        &DECK.replace("END\n", "SENSOR/1, FUNCTION=TIME, VALUE=1, RETURN\nEND\n"),
    );
    let (code, said) = folder.commands("SIM/DYN, END=2, STEPS=4\nSIM/DYN, END=2, STEPS=4\n");
    assert_eq!((code, said.as_str()), (0, ""));
    let (code, said) = folder.commands("SIM/DYN, END=2, STEPS=4\nSIM/DYN, END=1, STEPS=4\n");
    assert_eq!(code, 0);
    assert!(said.contains("warning[out-of-range]"), "{said}");
}

#[test]
fn what_adams_rejects_is_an_error_that_says_what_was_meant() {
    let folder = Folder::with(DECK);
    for (old, new, message) in [
        (
            "MARKER/20, PART=2",
            "MARKR/20, PART=2",
            "error[unknown-statement]: MARKR is not a statement",
        ),
        (
            "MARKER/10, PART=1",
            "MARKER/10, PART=1, QPP=1,2,3",
            "error[unknown-argument]: MARKER has no argument QPP",
        ),
        (
            "KGRAV",
            "GGRAV",
            "error[unknown-argument]: ACCGRAV has no argument GGRAV",
        ),
        (
            "PART/1, GROUND",
            "PART/1, GROUND\nGGRAV=3",
            "error[unknown-statement]: GGRAV is not a statement\n",
        ),
        (
            "MARKER/10, PART=1",
            "MARKER/10, PART=1\nQP=1, 2, 3",
            "error[unknown-statement]: QP is an argument of the MARKER above",
        ),
        (
            "JOINT/1, REVOLUTE, I=20, J=10",
            "JOINT/1\nREVOLUTE, I=20, J=10",
            "REVOLUTE is an argument of the JOINT above",
        ),
    ] {
        let (code, said) = folder.deck(&DECK.replacen(old, new, 1));
        assert_eq!(code, 1, "{said}");
        assert!(said.contains(message), "{new}: {said}");
    }
    let (code, said) = folder.commands("SIMULAT/STATICS\nDEACTIVTE/JOINT, ID=1\n");
    assert_eq!(code, 1);
    assert!(
        said.contains("SIMULAT") || said.contains("DEACTIVTE is not a command"),
        "{said}"
    );
    assert!(said.contains("DEACTIVTE is not a command"), "{said}");
}

#[test]
fn unsafe_fixes_write_what_alone_was_meant() {
    let folder = Folder::with(DECK);
    let broken = DECK
        .replace("MARKER/20, PART=2", "MARKR/20, PRAT=2\nQP=0, 0, 0")
        .replace("KGRAV", "GGRAV");
    folder.write("x.adm", &broken);
    assert_eq!(folder.said(&["fix", "x.adm", "--write"]).0, 0);
    assert_eq!(folder.read("x.adm"), broken, "nothing of it is safe");
    assert_eq!(folder.said(&["fix", "x.adm", "--write", "--unsafe"]).0, 0);
    // GGRAV is equally close to three arguments, so it stays unfixed.
    let mended = DECK
        .replace("MARKER/20, PART=2", "MARKER/20, PART=2\n, QP=0, 0, 0")
        .replace("KGRAV", "GGRAV");
    assert_eq!(folder.read("x.adm"), mended);
    folder.write("r.acf", "file/model=d\nDEACTIVTE/JOINT, ID=1\n");
    assert_eq!(folder.said(&["fix", "r.acf", "--write", "--unsafe"]).0, 0);
    assert_eq!(
        folder.read("r.acf"),
        "file/model=d\nDEACTIVATE/JOINT, ID=1\n"
    );
}

#[test]
fn codes_profiles_and_comments_say_what_is_shown() {
    let folder = Folder::with(DECK);
    let deck = DECK.replace(
        "END\n",
        "SFORCE/8, I=20, J=10, ROTATIONAL, FUNCTION=USER(1)\nGRAPHICS/1, EXTERNAL, RM=20, FILE=a.xmt\n\
         GRAPHICS/2, EXTERNAL, RM=20, FILE=b.xmt\nSPLINE/1, X=1,2,3,4, Y=1,2,3,4\n\tSPLINE/2,\tX=1,2,3,4, Y=1,2,3,4\nEND\n",
    );
    let count = |words: &[&str], code: &str| {
        let mut all = vec!["check", "x.adm", "--format", "plain"];
        all.extend(words);
        let (_, said) = folder.said(&all);
        said.lines()
            .filter(|line| line.contains(&format!("[{code}]")))
            .count()
    };
    folder.write("x.adm", &deck);
    assert_eq!(count(&[], "user-subroutine"), 1);
    // All missing graphics files are reported in a single note.
    assert_eq!(count(&[], "cannot-read"), 1);
    assert_eq!(count(&[], "unreferenced"), 0, "a subroutine may read them");
    assert_eq!(count(&["--for", "adams"], "user-subroutine"), 0);
    assert_eq!(count(&["--for", "adams"], "cannot-read"), 0);
    assert_eq!(count(&["--for", "admire"], "user-subroutine"), 1);
    assert_eq!(count(&["--for", "admire"], "cannot-read"), 0);
    assert!(count(&[], "tab") > 0);
    assert_eq!(count(&["--ignore", "tab"], "tab"), 0);
    assert_eq!(count(&["--select", "tab"], "user-subroutine"), 0);
    assert!(count(&["--select", "tab"], "tab") > 0);
    assert_eq!(count(&["--quiet"], "user-subroutine"), 0);
    assert_eq!(folder.said(&["check", "x.adm"]).0, 0);
    assert_eq!(folder.said(&["check", "x.adm", "--strict"]).0, 1);
    let (code, said) = folder.said(&["check", "x.adm", "--ignore", "tabs"]);
    assert!(code == 2 && said.contains("did you mean tab?"), "{said}");
    let silent = deck.replace(
        "FUNCTION=USER(1)",
        "FUNCTION=USER(1) ! admire: ignore[user-subroutine]",
    );
    folder.write("x.adm", &format!("{silent}! admire: ignore-file[tab]\n"));
    assert_eq!((count(&[], "user-subroutine"), count(&[], "tab")), (0, 0));
}

#[test]
fn a_table_sets_what_a_folder_shows() {
    let folder = Folder::with(DECK);
    let tabbed = DECK.replace("MARKER/20, PART=2", "MARKER/20,\tPART=2");
    folder.write("models/a/x.adm", &tabbed);
    folder.write("models/old/y.adm", "t\nMARKR/1\nEND\n");
    let check = |words: &[&str]| {
        let mut all = vec!["check", "models", "--format", "plain"];
        all.extend(words);
        folder.said(&all)
    };
    let (code, said) = check(&[]);
    assert!(
        code == 1 && said.contains("[tab]") && said.contains("MARKR"),
        "{said}"
    );
    folder.write(
        "models/admire.toml",
        "[check]\nignore = [\"tab\"]\nexclude = [\"old/**\"]\n",
    );
    assert_eq!(check(&[]), (0, String::new()));
    let (_, said) = check(&["--select", "tab"]);
    assert!(
        said.contains("[tab]"),
        "the command line comes first: {said}"
    );
    folder.write("models/admire.toml", "[check]\nignore = [\"tabs\"]\n");
    let (code, said) = check(&[]);
    assert_eq!(code, 1);
    assert!(
        said.contains("admire.toml:2:11: error[unknown-key]: `tabs` is not a message code"),
        "{said}"
    );
    folder.write("models/admire.toml", "[check]\nignored = []\n");
    let (code, said) = check(&[]);
    assert_eq!(code, 1);
    assert!(said.contains("admire.toml:2:1: error"), "{said}");
}

#[test]
fn folders_and_patterns_name_files_and_other_programs_read_the_answer() {
    let folder = Folder::with(DECK);
    folder.write("runs/a.adm", &DECK.replace("MARKER/20", "MARKR/20"));
    folder.write("runs/deep/b.ADM", DECK);
    folder.write(
        "runs/deep/c.acf",
        "file/model=b\nDEACTIVATE/JOINT, ID=4711\n",
    );
    folder.write("runs/readme.txt", "nothing");
    let (code, said) = folder.said(&["check", "runs/*.adm", "--format", "github"]);
    assert_eq!(code, 1);
    let line = "::error file=runs/a.adm,line=6,endLine=6,col=1,endColumn=6,title=unknown-statement::MARKR is not a statement%0Adid you mean MARKER?";
    assert!(said.lines().any(|said| said == line), "{said}");
    let (code, said) = folder.said(&["check", "runs", "--format", "sarif"]);
    assert_eq!(code, 1);
    let log: serde_json::Value = serde_json::from_str(&said).expect("one JSON document");
    let results = log["runs"][0]["results"].as_array().expect("results");
    let rules = log["runs"][0]["tool"]["driver"]["rules"]
        .as_array()
        .expect("rules");
    for result in results {
        let at = result["ruleIndex"].as_u64().expect("an index") as usize;
        assert_eq!(rules[at]["id"], result["ruleId"]);
    }
    let of_commands = results
        .iter()
        .find(|result| {
            result["message"]["text"]
                .as_str()
                .is_some_and(|text| text.contains("JOINT/4711"))
        })
        .expect("the command file is checked");
    let place = &of_commands["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "runs/deep/c.acf");
    assert_eq!(place["region"]["startLine"], 2);
    let (code, said) = folder.said(&["check", "runs/*.dat"]);
    assert_eq!(code, 1);
    assert!(said.contains("no file matches the pattern"), "{said}");
}

/// Checks that real command files, which ran in ADAMS, raise no error or warning. The exception names two variables that only the deck of
/// another run contains.
#[test]
fn real_command_files_are_fine() {
    let Some(folder) = shared("real-decks") else {
        return;
    };
    let files = files_below(&folder, "acf");
    assert!(files.len() >= 9);
    for file in files {
        let name = file.to_str().expect("a name");
        let (code, said) = said(
            &folder,
            &["check", name, "--for", "adams", "--format", "plain"],
        );
        let bad: Vec<&str> = said
            .lines()
            .filter(|line| line.contains(" error[") || line.contains(" warning["))
            // These warnings concern model paths from another computer; the model was found in the folder of the command file.
            .filter(|line| !line.contains("[foreign-path]"))
            .collect();
        if file.ends_with("adamspy-drill/test.acf") {
            let of_another_run = |line: &&str| line.contains("VARIABLE/1102");
            assert!(bad.len() == 2 && bad.iter().all(of_another_run), "{bad:?}");
            continue;
        }
        assert_eq!((code, bad.as_slice()), (0, &[][..]), "{name}");
    }
}

/// Checks that `admire check` on a folder also checks its study, so that a misspelt key is reported before the first fit.
#[test]
fn a_study_is_checked_with_its_folder() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let folder = tempfile::tempdir().expect("a folder");
    for entry in std::fs::read_dir(shipped).expect("shipped") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name");
        std::fs::copy(&path, folder.path().join(name)).expect("a copy");
    }
    let check = || said(folder.path(), &["check", ".", "--format", "plain"]);
    assert_eq!(check().0, 0, "{}", check().1);
    let study = folder.path().join("study.toml");
    let text = std::fs::read_to_string(&study).expect("readable");
    std::fs::write(&study, text.replace("\nsigma = ", "\nsigmma = ")).expect("written");
    let (code, said) = check();
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("sigmma"), "{said}");
}
