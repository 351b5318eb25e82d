//! The toolkit's commands as a user runs them: what they refuse, what they say, what they leave alone.

use std::path::Path;
use std::process::{Command, Output};

const DECK: &str = "a title\r\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\r\nPART/1, GROUND\r\n\
MARKER/10, PART=1, REULER = 90D, 0, 0\r\n!                   adams_view_name='arm'\r\nPART/2\r\n, MASS = 1.5, CM = 20\r\n\
, IP = 1.0E+04, 2.0E+04,\r\n! between\r\n, 3.0E+04\r\nMARKER/20, PART=2\r\nJOINT/1, REVOLUTE, I=20, J=10\r\n\
SFORCE/1, I=20, J=10, ROTATIONAL, FUNCTION=2*AZ(20,10)\r\nREQUEST/1, RESULTS_NAME=tip, CNAMES=\"\", \"dx\", \"dy\"\r\n\
, F2=DX(20,10)\\F3=DY(20,10)\r\nEND\r\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder.write("a.adm", DECK.as_bytes());
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path().join(name), bytes).expect("written");
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(self.path())
            .args(arguments)
            .output()
            .expect("admire runs")
    }

    /// Exit code, standard output, standard error.
    fn said(&self, arguments: &[&str]) -> (i32, String, String) {
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
        // What is not written has its default, whether its statement is there or not.
        ("EQUILIBRIUM.ERROR", "0.0001"),
    ] {
        let (code, out, err) = folder.said(&["get", "a.adm", address]);
        assert_eq!(
            (code, out.as_str()),
            (0, format!("{value}\n").as_str()),
            "{address}: {err}"
        );
    }
    // All of several values or none, and every fault at once.
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
    assert!(err.contains("written with E"), "{err}");
    let (code, _, err) = folder.said(&["set", "a.adm", "SFORCE/1.FUNCTION=2*AZ(20"]);
    assert_eq!(code, 1);
    assert!(err.contains("1 │ 2*AZ(20"), "{err}");
    let (code, _, err) = folder.said(&["set", "a.adm", "PART/2.QG=1 2 3"]);
    assert_eq!(code, 1);
    assert!(err.contains("commas separate values"), "{err}");
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
    // A deck in Latin-1 stays one.
    folder.write("latin.adm", &[b"caf\xe9\n", DECK.as_bytes()].concat());
    let output = folder.run(&["set", "latin.adm", "TITLE=th\u{e9}"]);
    assert!(output.stdout.starts_with(b"th\xe9\n"));
    // What is wrong with the new deck is told, even where the value itself is one.
    let (code, out, err) = folder.said(&["set", "a.adm", "PART/2.CM=99"]);
    assert_eq!(code, 0);
    assert!(
        out.contains("CM = 99") && err.contains("undefined-id"),
        "{err}"
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

/// A full disk must not look like a deck that was written.
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
            println!("skipped: there is no /dev/full here");
            return;
        };
        let status = Command::new(env!("CARGO_BIN_EXE_admire"))
            .current_dir(folder.path())
            .args(arguments)
            .stdout(full)
            .stderr(std::process::Stdio::null())
            .status()
            .expect("admire runs");
        // A deck without complaints prints nothing that could be lost.
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
    // Names change, come and go with their comments.
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
    // A list of quoted texts stays one.
    let (_, out, _) =
        with(&|all| all[request]["arguments"]["CNAMES"] = serde_json::json!(["", "u", "v", "w"]));
    assert!(
        out.contains("CNAMES=\"\", \"u\", \"v\", \"w\"\r\n"),
        "{out}"
    );
    // What cannot be said so is refused, and nothing is written.
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
    // 3 MB in 180,000 lines with as many complaints: counted from the start each time, this took minutes.
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
        (format!("{head}{units}"), 0, "no CURVE"),
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
        (0, "1 step, 1 column compared: all within the tolerance\n"),
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
        err.contains("MARKER/20 is on PART/2 without naming it"),
        "{err}"
    );
    let (_, out, err) = without(&[2, 1]);
    assert_eq!(out, "t\nPART/1, GROUND\nEND\n", "{err}");
}

#[test]
fn commands_are_linted_each_by_itself() {
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
            "a.acf:3:14: error[wrong-count",
            "a.acf:4:19: warning[wrong-dimension",
            "a.acf:5:31: error[wrong-type",
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
        (&["explain", ""], "lists all there is"),
        (&["get", "a.adm", "amr.MASS"], "did you mean ARM?"),
        (&["get", "a.adm", "PART/2.MAS5"], "did you mean MASS?"),
    ] {
        let (code, out, err) = folder.said(arguments);
        assert_eq!(code, 1, "{arguments:?}");
        assert!((out + &err).contains(said), "{arguments:?}: {err}");
    }
    // A word of 10 MB is not compared letter by letter with all words there are.
    let kind = "A".repeat(10_000_000);
    let json = serde_json::json!({ "statements": [{ "kind": kind }] });
    folder.write("a.json", json.to_string().as_bytes());
    assert_eq!(folder.said(&["import", "a.adm", "a.json"]).0, 1);
}

#[test]
fn statements_come_and_go_from_the_command_line() {
    let folder = Folder::new();
    let deck = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("there");
    // In the style of the deck: CR LF, and its layout of arguments; in front of what follows the last marker.
    let (code, _, said) = folder.said(&[
        "add",
        "a.adm",
        "mark/21, part=2, qp=1, 2, -3",
        "--name",
        "tip",
        "-o",
        "b.adm",
    ]);
    assert_eq!((code, said.as_str()), (0, ""));
    let added = deck("b.adm");
    let at = added.find("JOINT/1").expect("it stays");
    let new = &added[added.find("MARKER/20, PART=2\r\n").expect("it stays") + 19..at];
    assert!(
        new.contains("adams_view_name='tip'\r\nMARKER/21"),
        "{new:?}"
    );
    assert!(!new.replace("\r\n", "").contains('\n'), "{new:?}");
    assert_eq!(added.replace(new, ""), DECK);
    let (code, value, _) = folder.said(&["get", "b.adm", "tip.QP"]);
    assert_eq!((code, value.trim()), (0, "1.0, 2.0, -3.0"));
    // Gone without a trace.
    assert_eq!(folder.said(&["remove", "b.adm", "tip", "-o", "c.adm"]).0, 0);
    assert_eq!(deck("c.adm"), DECK);
    // A function on one line with what follows it: on lines of its own it needs a backslash.
    let force = "SFORCE/2, FUNCTION=3*TIME, I=20, J=10, TRANSLATIONAL";
    folder.write(
        "lines.adm",
        DECK.replace("MASS = 1.5, CM = 20", "MASS = 1.5\r\n, CM = 20")
            .as_bytes(),
    );
    for old in ["a.adm", "lines.adm"] {
        let (code, _, said) = folder.said(&["add", old, force, "-o", "d.adm"]);
        assert_eq!((code, said.as_str()), (0, ""));
        for (address, value) in [("SFORCE/2.FUNCTION", "3*TIME"), ("SFORCE/2.J", "10")] {
            let (_, out, said) = folder.said(&["get", "d.adm", address]);
            assert_eq!(out.trim(), value, "{said}");
        }
        let (_, checked, _) = folder.said(&["check", "d.adm", "--format", "plain"]);
        assert!(!checked.contains("backslash"), "{checked}");
    }
    // An argument alone.
    let (code, out, _) = folder.said(&["remove", "a.adm", "MARKER/10.REULER"]);
    assert_eq!((code, out), (0, DECK.replace(", REULER = 90D, 0, 0", "")));
}

#[test]
fn nothing_is_added_or_removed_that_leaves_a_fault() {
    let folder = Folder::new();
    for (words, code, why) in [
        (
            &["add", "a.adm", "JOINT/2, REVOLUTE, I=20, J=99"][..],
            1,
            "MARKER/99",
        ),
        // Where it would stand would say what it is on.
        (
            &["add", "a.adm", "MARKER/5, QP=1, 2, 3"],
            1,
            "does not say what it is on",
        ),
        (
            &["add", "a.adm", "PART/2, MASS=1"],
            1,
            "stands in the deck already",
        ),
        (
            &["add", "a.adm", "MARKR/5, PART=2"],
            1,
            "did you mean MARKER",
        ),
        (
            &["add", "a.adm", "MARKER/5, PART=2", "--name", "o'clock"],
            2,
            "name",
        ),
        (&["remove", "a.adm", "MARKER/20"], 1, "MARKER/20"),
        (
            &["remove", "a.adm", "PART/2.IP.2"],
            1,
            "one value of a list",
        ),
        (&["remove", "a.adm", "JOINT/1.IC"], 1, "is not written"),
        (&["remove", "a.adm", "JOINT/9"], 1, "JOINT/9"),
    ] {
        let (got, out, said) = folder.said(words);
        assert_eq!((got, out.as_str()), (code, ""), "{words:?}: {said}");
        assert!(said.contains(why), "{words:?}: {said}");
    }
    let forced = folder.said(&["remove", "a.adm", "MARKER/20", "--force"]);
    assert_eq!(
        (forced.0, forced.1),
        (0, DECK.replace("MARKER/20, PART=2\r\n", ""))
    );
    // Together they leave nothing behind.
    let (code, out, said) = folder.said(&[
        "remove",
        "a.adm",
        "JOINT/1",
        "SFORCE/1",
        "REQUEST/1",
        "PART/2.CM",
        "PART/2.MASS",
        "PART/2.IP",
        "MARKER/20",
    ]);
    assert_eq!(code, 0, "{said}");
    assert!(
        !out.contains("20\r\n") && out.contains("PART/2\r\n"),
        "{out}"
    );
}
