//! Tests of the toolkit's commands as a user runs them: refusals, messages, and text that must stay unchanged.

use std::path::Path;
use std::process::{Command, Output};

use crate::common::skipped;

pub(super) const DECK: &str = "a title\r\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\r\nPART/1, GROUND\r\n\
MARKER/10, PART=1, REULER = 90D, 0, 0\r\n!                   adams_view_name='arm'\r\nPART/2\r\n, MASS = 1.5, CM = 20\r\n\
, IP = 1.0E+04, 2.0E+04,\r\n! between\r\n, 3.0E+04\r\nMARKER/20, PART=2\r\nJOINT/1, REVOLUTE, I=20, J=10\r\n\
SFORCE/1, I=20, J=10, ROTATIONAL, FUNCTION=2*AZ(20,10)\r\nREQUEST/1, RESULTS_NAME=tip, CNAMES=\"\", \"dx\", \"dy\"\r\n\
, F2=DX(20,10)\\F3=DY(20,10)\r\nEND\r\n";

pub(super) struct Folder(tempfile::TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder.write("a.adm", DECK.as_bytes());
        folder
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(super) fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path().join(name), bytes).expect("written");
    }

    pub(super) fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(self.path())
            .args(arguments)
            .output()
            .expect("admire runs")
    }

    /// Runs `admire` and returns the exit code, standard output and standard error.
    pub(super) fn said(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.run(arguments);
        (
            output.status.code().expect("an exit code"),
            String::from_utf8_lossy(&output.stdout).into_owned(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    }
}

#[test]
fn get_prints_values_and_refuses_places_that_are_not_there() {
    let folder = Folder::new();
    for (address, value) in [
        ("TITLE", "a title"),
        ("PART/2.CM", "20"),
        ("arm.IP", "10000.0, 20000.0, 30000.0"),
        ("arm.IP.3", "30000.0"),
        ("arm.QG", "0.0, 0.0, 0.0"),
        ("SFORCE/1.FUNCTION.1", "2.0"),
        ("REQUEST/1.CNAMES.3", "dy"),
        ("UNITS.LENGTH", "MILLIMETER"),
        ("JOINT/1.REVOLUTE", "true"),
        // An argument that is not written has its default value, even if its statement is missing.
        ("EQUILIBRIUM.ERROR", "0.0001"),
    ] {
        let (code, out, err) = folder.said(&["get", "a.adm", address]);
        assert_eq!(
            (code, out.as_str()),
            (0, format!("{value}\n").as_str()),
            "{address}: {err}"
        );
    }
    // If one address is wrong, no value is printed, and the error message lists all wrong addresses.
    let (code, out, err) = folder.said(&["get", "a.adm", "arm.IP.9", "arm.MASS", "leg", "PART/3"]);
    assert_eq!((code, out.as_str()), (1, ""));
    for said in ["arm.IP.9", "`leg`", "`PART/3`"] {
        let shown = said.replace("arm", "PART/2");
        assert!(err.contains(said) || err.contains(&shown), "{said}: {err}");
    }
}

#[test]
fn a_refused_value_is_shown_in_the_text_as_it_would_be() {
    let folder = Folder::new();
    let (code, out, err) = folder.said(&["set", "a.adm", "PART/2.MASS=1.5D3"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains(", MASS = 1.5D3, CM = 20"), "{err}");
    assert!(err.contains("write a power of ten with E"), "{err}");
    let (code, _, err) = folder.said(&["set", "a.adm", "SFORCE/1.FUNCTION=2*AZ(20"]);
    assert_eq!(code, 1);
    assert!(err.contains("1 │ 2*AZ(20"), "{err}");
    let (code, _, err) = folder.said(&["set", "a.adm", "PART/2.QG=1 2 3"]);
    assert_eq!(code, 1);
    assert!(err.contains("separate the values with commas"), "{err}");
    let (code, _, err) = folder.said(&["set", "a.adm", "PART/2.QG=1,2"]);
    assert_eq!(code, 1);
    assert!(err.contains("QG = 1,2"), "{err}");
}

#[test]
fn a_value_is_never_more_than_a_value() {
    let folder = Folder::new();
    for assignment in [
        "PART/2.MASS=5, CM=10",
        "SFORCE/1.FUNCTION=1\\, ROUTINE=a::b",
        "PART/2.MASS=5 ! CM",
        "PART/2.MASS=5\nPART/3",
        "REQUEST/1.RESULTS_NAME=\"x\"; PART/3",
        "TITLE=two\nlines",
    ] {
        let (code, out, _) = folder.said(&["set", "a.adm", assignment]);
        assert_eq!((code, out.as_str()), (1, ""), "{assignment}");
    }
}

#[test]
fn flags_titles_and_degrees_are_set() {
    let folder = Folder::new();
    let (code, out, _) = folder.said(&[
        "set",
        "a.adm",
        "TITLE=another",
        "JOINT/1.REVOLUTE=false",
        "JOINT/1.FIXED=true",
        "MARKER/10.REULER.3=45D",
        "arm.IP.3=31000",
    ]);
    assert_eq!(code, 0);
    let wanted = DECK
        .replace("a title", "another")
        .replace(
            "JOINT/1, REVOLUTE, I=20, J=10",
            "JOINT/1, I=20, J=10, FIXED",
        )
        .replace("90D, 0, 0", "90D, 0, 45D")
        .replace("3.0E+04", "3.1E+04");
    assert_eq!(out, wanted);
    // A Latin-1 deck is written in Latin-1.
    folder.write("latin.adm", &[b"caf\xe9\n", DECK.as_bytes()].concat());
    let output = folder.run(&["set", "latin.adm", "TITLE=th\u{e9}"]);
    assert!(output.stdout.starts_with(b"th\xe9\n"));
}

#[test]
fn set_refuses_what_add_refuses() {
    let folder = Folder::new();
    for (assignment, code) in [
        ("PART/2.CM=99", "undefined-id"),
        ("PART/2.MASS=-1", "out-of-range"),
    ] {
        let (exit, out, err) = folder.said(&["set", "a.adm", assignment]);
        assert_eq!((exit, out.as_str()), (1, ""), "{assignment}");
        assert!(err.contains(code) && err.contains("--force"), "{err}");
        let (exit, out, err) = folder.said(&["set", "a.adm", assignment, "--force"]);
        assert_eq!(exit, 0, "{assignment}");
        let value = assignment.split('=').next_back().expect("a value");
        assert!(out.contains(&format!("= {value}")), "{out}");
        assert!(err.contains(code), "{err}");
    }
}

#[test]
fn a_number_is_written_as_typed_and_an_angle_reads_back_to_the_last_bit() {
    let folder = Folder::new();
    for (assignment, written) in [
        ("PART/2.MASS=-3", "MASS = -3,"),
        ("PART/2.MASS=2.50", "MASS = 2.50,"),
        ("SFORCE/1.FUNCTION=-3", "FUNCTION=-3\r"),
        ("SFORCE/1.FUNCTION.1=-3", "FUNCTION=(-3)*AZ"),
        ("SFORCE/1.FUNCTION.1=+3", "FUNCTION=3*AZ"),
        ("PART/2.QG.1=-3", "QG = -3, 0"),
        ("MARKER/10.REULER.2=-30D", "REULER = 90D, -30D, 0"),
        // A value equal to the present one causes no edit.
        ("PART/2.MASS=1.50", "MASS = 1.5,"),
        ("arm.IP.1=10000", "IP = 1.0E+04,"),
    ] {
        let (code, out, err) = folder.said(&["set", "a.adm", assignment, "--force"]);
        assert_eq!(code, 0, "{err}");
        assert!(out.contains(written), "{assignment}: {out}");
    }
    // The angle is written in degrees only if the degrees convert back to exactly the given radians. For some values no double does.
    let mut suffixes = 0;
    for k in 1..=40 {
        let value = f64::from(k) * 0.0731;
        let assignment = format!("MARKER/10.REULER.1={value:?}");
        let (code, out, _) = folder.said(&["set", "a.adm", &assignment]);
        assert_eq!(code, 0);
        folder.write("new.adm", out.as_bytes());
        let (_, out, _) = folder.said(&["get", "new.adm", "MARKER/10.REULER.1"]);
        assert_eq!(out.trim().parse::<f64>().expect("a number"), value);
        let text = std::fs::read_to_string(folder.path().join("new.adm")).expect("text");
        suffixes += usize::from(text.contains("D, 0, 0"));
    }
    assert!((1..40).contains(&suffixes), "{suffixes} kept their suffix");
}

#[test]
fn a_field_is_turned_from_its_length_and_a_picture_carries_no_load() {
    let folder = Folder::new();
    let deck = |angle: &str, turn: &str| {
        DECK.replace("REULER = 90D, 0, 0", &format!("REULER = 0, {turn}, 0"))
            .replace(
                "END",
                &format!(
                    "FIELD/1, I=20, J=10, LENGTH=0,0,0,{angle},0,0\r\n\
                 GRAPHICS/1, CYLINDER, CM=10, RADIUS=0, LENGTH=5\r\nEND"
                ),
            )
    };
    // I is rotated by -30 degrees about the x axis of J, which equals the relaxed orientation given by LENGTH.
    folder.write("relaxed.adm", deck("-30D", "30D").as_bytes());
    let (code, out, _) = folder.said(&["check", "relaxed.adm"]);
    assert!(!out.contains("FIELD/1 is turned"), "{out}");
    // Faults in graphics are never errors.
    assert!(out.contains("RADIUS of GRAPHICS/1") && code == 0, "{out}");
    folder.write("turned.adm", deck("0", "30D").as_bytes());
    let (_, out, _) = folder.said(&["check", "turned.adm"]);
    assert!(
        out.contains("I of FIELD/1 is rotated by -30.0") && out.contains("orientation of J"),
        "{out}"
    );
    folder.write("wrong.adm", deck("30D", "30D").as_bytes());
    let (_, out, _) = folder.said(&["check", "wrong.adm"]);
    assert!(
        out.contains("-60.0") && out.contains("from the angles of LENGTH"),
        "{out}"
    );
}

#[test]
fn standard_input_is_never_replaced() {
    let folder = Folder::new();
    for arguments in [
        &["set", "-", "--in-place"][..],
        &["import", "-", "a.adm", "--in-place"],
    ] {
        let (code, _, _) = folder.said(arguments);
        assert_ne!(code, 0, "{arguments:?}");
    }
    assert!(!folder.path().join("-").exists());
}

/// Checks that a command fails if its output cannot be written, for example on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_is_lost_is_no_success() {
    let folder = Folder::new();
    for arguments in [
        &["set", "a.adm"][..],
        &["export", "a.adm"],
        &["get", "a.adm", "TITLE"],
        &["check", "a.adm"],
        &["summary", "a.adm"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
        let Ok(full) = full else {
            skipped("there is no /dev/full here");
            return;
        };
        let status = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(arguments)
            .stdout(full)
            .stderr(std::process::Stdio::null())
            .status()
            .expect("admire runs");
        // `check` prints nothing for a clean deck, so it loses nothing and succeeds.
        let silent = arguments[0] == "check";
        assert_eq!(status.code(), Some(i32::from(!silent)), "{arguments:?}");
    }
    let (code, out, _) = folder.said(&["set", "a.adm", "-o", "/dev/stdout"]);
    assert_eq!((code, out.as_str()), (0, DECK));
}

#[test]
fn no_tolerance_lets_everything_pass() {
    let folder = Folder::new();
    folder.write("b.adm", DECK.replace("1.5", "1.6").as_bytes());
    for wrong in ["nan", "inf", "-1"] {
        let (code, out, _) = folder.said(&["diff", "a.adm", "b.adm", "--rel", wrong]);
        assert_eq!((code, out.as_str()), (2, ""), "{wrong}");
        let (code, _, _) = folder.said(&["compare", "a.res", "b.res", "--abs", wrong]);
        assert_eq!(code, 2, "{wrong}");
    }
    assert_eq!(
        folder.said(&["diff", "a.adm", "b.adm", "--rel", "0.1"]).0,
        0
    );
}

#[test]
fn json_brings_back_what_it_says_or_nothing() {
    let folder = Folder::new();
    let exported = folder.said(&["export", "a.adm"]).1;
    let json: serde_json::Value = serde_json::from_str(&exported).expect("JSON");
    let import = |json: &serde_json::Value| {
        folder.write("a.json", json.to_string().as_bytes());
        folder.said(&["import", "a.adm", "a.json"])
    };
    assert_eq!(import(&json).1, DECK);
    let at = |kind: &str| -> usize {
        let all = json["statements"].as_array().expect("a list");
        all.iter()
            .position(|one| one["kind"] == kind)
            .expect("there")
    };
    let with = |edit: &dyn Fn(&mut serde_json::Value)| {
        let mut changed = json.clone();
        edit(&mut changed["statements"]);
        import(&changed)
    };
    let (part, joint, request) = (at("PART") + 1, at("JOINT"), at("REQUEST"));
    let part = if json["statements"][part]["id"] == 2 {
        part
    } else {
        part + 1
    };
    // Names can be changed, removed and added, and their comment lines follow.
    let (_, out, _) = with(&|all| all[part]["name"] = "leg".into());
    assert_eq!(out, DECK.replace("'arm'", "'leg'"));
    let (_, out, _) = with(&|all| {
        all[part].as_object_mut().expect("an object").remove("name");
    });
    assert_eq!(
        out,
        DECK.replace("!                   adams_view_name='arm'\r\n", "")
    );
    let (_, out, _) = with(&|all| all[joint]["name"] = "hinge".into());
    assert!(
        out.contains("adams_view_name='hinge'\r\nJOINT/1, REVOLUTE"),
        "{out}"
    );
    // A list of quoted strings stays a list of quoted strings.
    let (_, out, _) =
        with(&|all| all[request]["arguments"]["CNAMES"] = serde_json::json!(["", "u", "v", "w"]));
    assert!(
        out.contains("CNAMES=\"\", \"u\", \"v\", \"w\"\r\n"),
        "{out}"
    );
    // Invalid changes are refused, and nothing is written.
    let refusals: [&dyn Fn(&mut serde_json::Value); 8] = [
        &|all| all[joint]["kind"] = "JIONT".into(),
        &|all| all[joint]["id"] = serde_json::json!(4_294_967_297_u64),
        &|all| all[joint]["arguments"]["K"] = 1.into(),
        &|all| all[0]["arguments"]["LENGTH"] = serde_json::json!(["METRE"]),
        &|all| all[part]["arguments"]["MASS"] = "5, CM=10".into(),
        &|all| all[part]["arguments"]["QG"] = serde_json::json!([1, 2]),
        &|all| all[part]["name"] = "it's".into(),
        &|all| {
            let new =
                serde_json::json!({"kind": "MARKER", "id": 77, "arguments": {"QP": [1, 2, 3]}});
            all.as_array_mut().expect("a list").push(new);
        },
    ];
    for (k, refusal) in refusals.iter().enumerate() {
        let (code, out, err) = with(refusal);
        assert_eq!((code, out.as_str()), (1, ""), "{k}");
        assert!(!err.is_empty(), "{k}");
    }
}

#[test]
fn what_stands_twice_goes_through_json_unchanged() {
    let folder = Folder::new();
    let deck =
        "t\nOUTPUT/REQSAVE\nOUTPUT/GRSAVE\nMARKER/1, PART=1\nMARKER/1, PART=2, QP=1,2,3\nEND\n";
    folder.write("b.adm", deck.as_bytes());
    let exported = folder.said(&["export", "b.adm"]).1;
    folder.write("b.json", exported.as_bytes());
    assert_eq!(folder.said(&["import", "b.adm", "b.json"]).1, deck);
}

#[test]
fn thousands_of_complaints_are_placed_in_time_that_grows_with_their_number() {
    let folder = Folder::new();
    // The deck has 180,000 lines (3 MB) with a diagnostic on nearly every line. Counting lines from the start for each diagnostic took
    // minutes.
    let deck = format!("t\n{}END\n", "MARKER/1, PART=1\n".repeat(180_000));
    folder.write("twice.adm", deck.as_bytes());
    let (code, out, _) = folder.said(&["check", "twice.adm", "--format", "plain"]);
    assert_eq!(code, 1);
    assert!(out.contains("twice.adm:9000:8: error[duplicate-id]"));
}

#[test]
fn user_calls_differ_by_their_numbers_only() {
    let folder = Folder::new();
    folder.write("u.adm", b"t\nREQUEST/1, FUNCTION=USER(1,2.0,3)\nEND\n");
    folder.write(
        "v.adm",
        b"t\nREQUEST/1\n, FUNCTION = user( 1, 2.0E+00,\n, 3.0000001 )\nEND\n",
    );
    assert_eq!(
        folder.said(&["diff", "u.adm", "v.adm", "--rel", "1e-6"]).0,
        0
    );
    let (code, out, _) = folder.said(&["diff", "u.adm", "v.adm"]);
    assert_eq!(code, 1);
    assert!(
        out.contains("USER(1,2.0,3) -> user( 1, 2.0E+00, 3.0000001 )"),
        "{out}"
    );
}

#[test]
fn property_files_without_what_they_are_for_are_told_of() {
    let folder = Folder::new();
    let head = "[MDI_HEADER]\n FILE_TYPE = 'spr'\n FILE_VERSION = 4.0\n";
    let units = "[UNITS]\n LENGTH = 'mm'\n ANGLE = 'degrees'\n FORCE = 'newton'\n MASS = 'kg'\n TIME = 'second'\n";
    let curve = "[CURVE]\n{ disp force }\n-1.0 -900\n0.0 zero\n1.0 900\n";
    for (text, code, said) in [
        (format!("{head}{units}{curve}"), 1, "bad-number"),
        (
            format!("{head}{curve}").replace("zero", "0"),
            0,
            "no [UNITS]",
        ),
        (format!("{head}{units}"), 0, "no block CURVE"),
    ] {
        folder.write("a.spr", text.as_bytes());
        let (found, out, _) = folder.said(&["check", "a.spr", "--format", "plain"]);
        assert_eq!(found, code, "{out}");
        assert!(out.contains(said), "{out}");
    }
}

#[test]
fn a_fault_in_a_results_file_is_shown_where_it_is() {
    let folder = Folder::new();
    let file = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Results xmlns=\"http://www.mscsoftware.com/:xrf10\">\n\
        <Analysis name=\"a\" executionDate=\"x\" Solver=\"s\" script=\"-unknown-\">\n\
        <Units angle=\"rad\" length=\"mm\" mass=\"kg\" time=\"sec\" />\n<StepMap name=\"map_001\">\n<Entity name=\"time\">\n\
        <Component name=\"TIME\" unitsValue=\"sec\" id=\"1\" />\n</Entity>\n</StepMap>\n<Data name=\"dynamic_001\" id=\"1\">\n\
        <Step type=\"dynamic\">\nabc\n</Step>\n</Data>\n</Analysis>\n</Results>\n";
    folder.write("a.res", file.as_bytes());
    let (code, _, err) = folder.said(&["results", "a.res", "--get", "time*", "--format", "plain"]);
    assert_eq!(code, 1);
    assert!(err.starts_with("a.res:12:"), "{err}");
    folder.write("b.res", file.replace("abc", "0.5").as_bytes());
    let (code, out, err) = folder.said(&["compare", "b.res", "b.res"]);
    assert_eq!(
        (code, out.as_str()),
        (
            0,
            "1 step, 1 column compared: all values within the tolerance\n"
        ),
        "{err}"
    );
}

#[test]
fn a_body_goes_from_json_only_with_the_markers_that_stand_on_it_unnamed() {
    let folder = Folder::new();
    let deck = "t\nPART/1, GROUND\nPART/2, MASS=1, CM=20\nMARKER/20\nEND\n";
    folder.write("b.adm", deck.as_bytes());
    let exported: serde_json::Value =
        serde_json::from_str(&folder.said(&["export", "b.adm"]).1).expect("JSON");
    let without = |gone: &[usize]| {
        let mut json = exported.clone();
        let all = json["statements"].as_array_mut().expect("a list");
        for at in gone {
            all.remove(*at);
        }
        folder.write("b.json", json.to_string().as_bytes());
        folder.said(&["import", "b.adm", "b.json"])
    };
    let (code, out, err) = without(&[1]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(
        err.contains("MARKER/20 names no body and belongs to PART/2 by its position"),
        "{err}"
    );
    let (_, out, err) = without(&[2, 1]);
    assert_eq!(out, "t\nPART/1, GROUND\nEND\n", "{err}");
}

#[test]
fn commands_are_linted_each_by_itself_and_with_their_deck() {
    let folder = Folder::new();
    let text = "\nfile/model=a\nbushing/1, k=1,2\nmarker/20, reuler=90,0,0\nsimulate/static, end=1, steps=2.5\nsimulate/static, end=1, steps=0\n\
                sfor/1, func=2*az(20,10)\nstop\n";
    folder.write("a.acf", text.as_bytes());
    let (code, out, _) = folder.said(&["check", "a.acf", "--format", "plain"]);
    assert_eq!(code, 1);
    let places: Vec<&str> = out
        .lines()
        .filter_map(|line| line.split("]:").next())
        .collect();
    assert_eq!(
        places,
        [
            "a.acf:3:9: error[undefined-id",
            "a.acf:3:14: error[wrong-count",
            "a.acf:4:19: warning[wrong-dimension",
            "a.acf:5:31: error[wrong-type",
            "a.acf:6:22: error[out-of-range",
            "a.acf:6:31: error[out-of-range",
        ]
    );
}

#[test]
fn what_is_misspelt_is_suggested() {
    let folder = Folder::new();
    for (arguments, said) in [
        (&["explain", "bushng"][..], "`BUSHING`"),
        (&["explain", "wrong-dim"], "`wrong-dimension`"),
        (&["explain", ""], "lists all words"),
        (&["get", "a.adm", "amr.MASS"], "did you mean ARM?"),
        (&["get", "a.adm", "PART/2.MAS5"], "did you mean MASS?"),
    ] {
        let (code, out, err) = folder.said(arguments);
        assert_eq!(code, 1, "{arguments:?}");
        assert!((out + &err).contains(said), "{arguments:?}: {err}");
    }
    // A word of 10 MB is rejected quickly: it is not compared letter by letter with every known word.
    let kind = "A".repeat(10_000_000);
    let json = serde_json::json!({ "statements": [{ "kind": kind }] });
    folder.write("a.json", json.to_string().as_bytes());
    assert_eq!(folder.said(&["import", "a.adm", "a.json"]).0, 1);
}

/// Checks that control characters in the names and titles of an untrusted deck are escaped in terminal output.
#[test]
fn nothing_a_deck_holds_commands_the_terminal() {
    let folder = Folder::new();
    let hostile = "\u{1b}]0;owned\u{7}\u{9b}31m\u{202e}";
    let deck = DECK
        .replace("a title", &format!("a title{hostile}"))
        .replace("'arm'", &format!("'arm{hostile}'"))
        .replace("CM = 20", &format!("CM = 99, {hostile}=3"));
    folder.write("hostile.adm", deck.as_bytes());
    folder.write(
        "solved.adm",
        DECK.replace("a title", &format!("a title{hostile}"))
            .replace("'arm'", &format!("'arm{hostile}'"))
            .replace(
                "SFORCE/1",
                &format!("!  adams_view_name='f{hostile}'\r\nSFORCE/1"),
            )
            .as_bytes(),
    );
    for arguments in [
        &["check", "hostile.adm"][..],
        &["check", "hostile.adm", "--format", "plain"],
        &["check", "hostile.adm", "--format", "json"],
        &["summary", "hostile.adm"],
        &["summary", "hostile.adm", "--format", "json"],
        &["solve", "hostile.adm"],
        &["solve", "solved.adm", "--free-body", "PART/2"],
        &["solve", "solved.adm", "--format", "json"],
        &["diff", "a.adm", "hostile.adm"],
        &["get", "hostile.adm", "TITLE", "PART/2"],
        &["get", "hostile.adm", &format!("x{hostile}")],
        &["renumber", "solved.adm", "MARKER=100"],
        &["graph", "solved.adm", "--dot"],
        &["graph", "solved.adm"],
        &["extract", "solved.adm", "PART/2"],
    ] {
        let (_, out, err) = folder.said(arguments);
        let all = format!("{out}{err}");
        assert!(!all.is_empty());
        let obeyed = all
            .chars()
            .find(|c| (c.is_control() && !"\r\n\t".contains(*c)) || *c == '\u{202e}');
        assert_eq!(obeyed, None, "{arguments:?}: {all:?}");
    }
    let (_, out, _) = folder.said(&["get", "hostile.adm", "TITLE"]);
    assert_eq!(out, "a title\\u001b]0;owned\\u0007\\u009b31m\\u202e\n");
    let (_, out, _) = folder.said(&["get", "hostile.adm", "TITLE", "--format", "json"]);
    let value: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(value["TITLE"], format!("a title{hostile}"));
    // Output of a deck contains the original bytes, without escapes.
    let output = folder.run(&["set", "hostile.adm"]);
    assert_eq!(output.stdout, deck.as_bytes());
}

#[cfg(target_os = "linux")]
#[test]
fn what_is_no_file_is_not_replaced_and_what_is_too_large_is_not_read() {
    let folder = Folder::new();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo")
        .arg(&pipe)
        .status()
        .expect("mkfifo runs");
    assert!(made.success());
    // Opening a named pipe would block until a writer appears.
    let (code, out, err) = folder.said(&["set", "pipe", "PART/2.MASS=2", "--in-place"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains("is not a regular file"), "{err}");
    let large = std::fs::File::create(folder.path().join("large.req")).expect("created");
    std::io::Write::write_all(&mut &large, b" A.R3 ").expect("written");
    large.set_len(1 << 30).expect("a sparse file");
    let (code, _, err) = folder.said(&["results", "large.req"]);
    assert_eq!(code, 1);
    assert!(err.contains("more than the limit of 536870912"), "{err}");
}
