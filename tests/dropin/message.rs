//! Content of the message file besides the solution, compared with real message files where available.

use crate::common::shared;
use crate::run::{Results, SLIDER, folder, generic_model, mdi, text};

/// Returns the framed warnings of a message file that contain one of the phrases.
fn frames<'t>(messages: &'t str, phrases: &[&str]) -> Vec<&'t str> {
    let frames = messages.split("---- START: WARNING ----\n").skip(1);
    let text = frames.filter_map(|rest| rest.split("\n---- END: WARNING ----").next());
    text.filter(|text| phrases.iter().any(|phrase| text.contains(phrase)))
        .map(str::trim_end)
        .collect()
}

#[test]
fn joints_that_do_not_meet_are_told_as_adams_tells_them() {
    let Some(real) = shared("real-decks") else {
        return;
    };
    let real = real.join("adamspy-feed");
    let stem = "FRS5_doe_8_LAUL_analysis";
    let read = |extension: &str| {
        let bytes = std::fs::read(real.join(format!("{stem}.{extension}"))).unwrap();
        String::from_utf8_lossy(&bytes).replace("\r\n", "\n")
    };
    let (deck, expected) = (read("adm"), read("msg"));
    let acf = format!("file/model={stem}\nstop\n");
    let folder = folder(&[(&format!("{stem}.adm"), &deck), ("run.acf", &acf)]);
    mdi(folder.path(), &["ru-s", "run"]);
    let ours = text(folder.path(), &format!("{stem}.msg"));
    let points = ["are not initially coincident"];
    let real = frames(&expected, &points);
    assert_eq!(real.len(), 5);
    assert_eq!(frames(&ours, &points), real);
    // ADAMS also reports five planes, which are missed by less than our threshold; every plane that we report is also reported by ADAMS.
    let planes = ["is not in the", "is not on the"];
    let real = frames(&expected, &planes);
    assert!(
        frames(&ours, &planes)
            .iter()
            .all(|ours| real.contains(ours))
    );
    // The warnings come before the title, as in ADAMS.
    let title = ours.find("Model Title").unwrap();
    assert!(ours.rfind("are not initially coincident").unwrap() < title);
}

#[test]
fn what_many_objects_share_is_told_once() {
    let Some(real) = shared("real-decks") else {
        return;
    };
    let stem = "FRS5_doe_8_LAUL_analysis";
    let read = |extension: &str| {
        let path = real
            .join("adamspy-feed")
            .join(format!("{stem}.{extension}"));
        let bytes = std::fs::read(path).unwrap();
        String::from_utf8_lossy(&bytes).replace("\r\n", "\n")
    };
    let (deck, acf) = (read("adm"), read("acf"));
    let folder = folder(&[(&format!("{stem}.adm"), &deck), ("run.acf", &acf)]);
    assert_eq!(mdi(folder.path(), &["ru-s", "run"]).code, 1);
    let ours = text(folder.path(), &format!("{stem}.msg"));
    assert_eq!(ours.matches(".xmt_txt` does not exist").count(), 1);
    // Several hundred CONTACTs share one message in the first simulation; later simulations are only refused.
    let frames: Vec<&str> = ours.split("---- START: ERROR ----\n").skip(1).collect();
    let contacts = frames
        .iter()
        .filter(|frame| frame.contains(": CONTACT/") && frame.contains("contact detection"));
    let contacts: Vec<_> = contacts.collect();
    assert_eq!(contacts.len(), 1, "{contacts:#?}");
    // The message points to the statement of the first CONTACT.
    let place = contacts[0].split(": CONTACT/").next().unwrap();
    let line = place.split(':').nth(1).unwrap().parse::<usize>().unwrap();
    let stated = deck.lines().nth(line - 1).unwrap();
    assert!(stated.starts_with("CONTACT/"), "{place}: {stated}");
    assert!(contacts[0].contains("; the same applies to "));
    assert!(contacts[0].contains("\n  object: model."));
    let refused = ours.matches("this simulation is not executed").count();
    assert_eq!(refused, deck_simulations(&acf));
    assert!(ours.lines().count() < 400, "{}", ours.lines().count());
}

/// Returns the number of SIMULATE commands in a command file.
fn deck_simulations(acf: &str) -> usize {
    let is_one = |line: &&str| line.trim_start().to_ascii_lowercase().starts_with("sim");
    acf.lines().filter(is_one).count()
}

#[test]
fn redundant_constraints_are_told_where_adams_tells_them() {
    let Some([ours, real]) = generic_model() else {
        return;
    };
    let order = |messages: &str| {
        let marks = [
            "  Begin Simulation",
            "****** Performing Dynamic Simulation",
            "  Time T=0.000000000E+00.",
            "identified redundant constraints in the model:",
            "   -  deactivating constraint equation  ",
            "kinematically determinate.",
            "   The system is modelled with INDEX-",
        ];
        let mut rest = messages;
        for mark in marks {
            let at = rest.find(mark).unwrap_or_else(|| panic!("{mark}: {rest}"));
            rest = &rest[at..];
        }
        let equations = messages.split("deactivating constraint equation").skip(1);
        let equations = equations.filter_map(|rest| rest.lines().next());
        equations
            .map(|line| line.trim().to_string())
            .collect::<Vec<_>>()
    };
    // The same constraints as in ADAMS, reported at the same place.
    assert_eq!(order(&ours), order(&real));
}

#[test]
fn commands_print_what_they_are_asked_to() {
    let commands = "\nfile/model=slider\nSFORCE/1, FUNCTION=5\nSPRINGDAMPER/1, LIST\nSPRINGDAMPER/1, K=20\n\
        SIMULATE/STATIC\nSPRINGDAMPER/1, LIST\nSFORCE/1, LIST\nEQUILIBRIUM/LIST\nINFO/DISPLACEMENT, FORCE, I=21, J=11\n\
        INFO/VELOCITY, I=21\nINFO/DISPLACEMENT, I=77\nINFO/I=21\nSTOP\n";
    let folder = folder(&[("slider.adm", SLIDER), ("run.acf", commands)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let messages = text(folder.path(), "slider.msg");
    let after = |command: &str, which: usize| {
        let mark = format!(" command: {command}\n");
        let rest = messages.split(mark.as_str()).nth(which + 1);
        let rest = rest.unwrap_or_else(|| panic!("{command}: {messages}"));
        rest.split(" command: ").next().unwrap().to_string()
    };
    let values = |text: &str| -> Vec<(String, String)> {
        text.lines()
            .filter_map(|line| line.split_once(" = "))
            .map(|(name, value)| (name.trim().to_string(), value.trim().to_string()))
            .collect()
    };
    let value = |text: &str, name: &str| {
        let found = values(text).into_iter().find(|(known, _)| known == name);
        found.unwrap_or_else(|| panic!("{name}: {text}")).1
    };
    let first = after("SPRINGDAMPER/1, LIST", 0);
    assert!(
        first.contains("SPRINGDAMPER/1   model.SPRINGDAMPER_1"),
        "{first}"
    );
    assert_eq!(value(&first, "K"), "10");
    assert_eq!(value(&first, "I"), "21");
    // A value given by the command, and values given nowhere.
    let second = after("SPRINGDAMPER/1, LIST", 1);
    assert_eq!(value(&second, "K"), "20");
    assert_eq!(value(&second, "LENGTH"), "100");
    assert_eq!(value(&second, "C"), "0");
    assert_eq!(value(&after("SFORCE/1, LIST", 0), "FUNCTION"), "5");
    assert_eq!(value(&after("EQUILIBRIUM/LIST", 0), "ERROR"), "1E-10");
    // z = 5 / 20, measured from a marker 100 below; the spring pulls with 20 z.
    let info = after("INFO/DISPLACEMENT, FORCE, I=21, J=11", 0);
    assert_eq!(value(&info, "Z"), "1.002500E+02");
    assert_eq!(value(&info, "FZ"), "-5.000000E+00");
    assert_eq!(value(&info, "MAG"), "1.002500E+02");
    assert_eq!(
        value(&after("INFO/VELOCITY, I=21", 0), "VM"),
        "0.000000E+00"
    );
    assert!(after("INFO/DISPLACEMENT, I=77", 0).contains("MARKER/77 is not in the model"));
    assert!(after("INFO/I=21", 0).contains("names no quantity"));
}

/// Checks that torques on a POINT_MASS, which accepts only translational forces (`state_point_mass`), are reported at their statements.
#[test]
fn a_torque_that_nothing_feels_is_told() {
    let deck = "ball\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/10, PART=1\n\
                POINT_MASS/2, MASS=2, CM=20\nMARKER/20, POINT_MASS=2\n\
                BUSHING/1, I=20, J=10, K=100,100,100, KT=1E5,1E5,1E5\nBUSHING/2, I=20, J=10, K=100,100,100\n\
                ACCGRAV/KGRAV=-9806.65\nRESULTS/XRF\nEND\n";
    let acf = "\nfile/model=ball\nsimulate/static\nstop\n";
    let folder = folder(&[("ball.adm", deck), ("run.acf", acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(
        ran.stdout.matches("the torque has no effect").count(),
        1,
        "{}",
        ran.stdout
    );
    assert!(
        ran.stdout
            .contains("BUSHING/1 exerts a torque on POINT_MASS/2"),
        "{}",
        ran.stdout
    );
    let results = Results::read_all(folder.path(), "ball.res");
    let z = results.column("POINT_MASS_2_XFORM", "Z");
    let low = z.iter().fold(0.0_f64, |low, z| low.min(*z));
    assert!((low + 2.0 * 9.80665 / 200.0).abs() < 1e-9, "{low}");
}
