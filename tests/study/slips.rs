//! Frequent slips, planted one at a time: they are refused before any fit, with the reason and the remedy. Correct studies pass.

use std::path::Path;

use super::run::{admire, change, copied};

/// Returns the output of `admire check` for a study, in one line.
fn told(folder: &Path) -> (String, i32) {
    let said = admire(folder, &["check", "study"]);
    let text: Vec<&str> = said.err.split_whitespace().collect();
    (text.join(" "), said.code)
}

/// Multiplies columns of the loads by a factor.
fn scaled(study: &Path, names: &[&str], factor: f64) {
    let table = study.join("load_cases.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let line = |(at, line): (usize, &str)| {
        let cells = line.split(',').zip(&header).map(|(cell, name)| {
            if at > 0 && names.contains(name) {
                (factor * cell.parse::<f64>().unwrap()).to_string()
            } else {
                cell.to_string()
            }
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let lines: Vec<String> = text.lines().enumerate().map(line).collect();
    std::fs::write(&table, lines.join("\n") + "\n").unwrap();
}

const POUND: f64 = 4.448_221_615;

#[test]
fn loads_in_another_unit_are_refused_with_it() {
    let all = ["vertical", "lateral", "longitudinal"];
    for (names, factor, wanted) in [
        (
            &all[..],
            1.0 / POUND,
            "all force columns multiplied by 4.448, as if stated in pound_force",
        ),
        (
            &["lateral"],
            1.0 / POUND,
            "`lateral` multiplied by 4.448, as if stated in pound_force",
        ),
        (
            &["vertical"],
            1e-3,
            "`vertical` multiplied by 1000, as if stated in knewton",
        ),
    ] {
        let (folder, study) = copied("pseudo-mcpherson");
        scaled(&study, names, factor);
        let (said, code) = told(folder.path());
        assert!(code == 1 && said.contains(wanted), "{names:?}: {said}");
        let fit = ["identify", "study", "--out", "out"];
        let refused = admire(folder.path(), &fit);
        assert!(
            refused.code == 1 && refused.err.contains("--force"),
            "{}",
            refused.err
        );
        assert!(!folder.path().join("out").exists());
    }
}

#[test]
fn numbers_of_the_deck_in_another_unit_are_refused_with_it() {
    for (from, to, wanted) in [
        (
            ", K = 60.0",
            ", K = 60000.0",
            "SPRINGDAMPER/1.K = 60000 multiplied by 0.001, as if stated in newton/meter",
        ),
        (
            ", K = 60.0",
            ", K = 6.0",
            "SPRINGDAMPER/1.K = 6 multiplied by",
        ),
        (
            "K = 3500.0, 3500.0, 1500.0",
            "K = 3.5, 3.5, 1.5",
            "BUSHING/3.K multiplied by 1000",
        ),
    ] {
        let (folder, study) = copied("pseudo-mcpherson");
        change(&study.join("model.adm"), from, to);
        let (said, code) = told(folder.path());
        assert!(code == 1 && said.contains(wanted), "{to}: {said}");
    }
}

/// Checks bushings whose two sides are displaced or rotated relative to each other. One exchange, one sign or one mirror image corrects them.
/// The deck's own warnings precede the refusal.
#[test]
fn markers_that_lie_apart_are_refused_with_what_brings_them_together() {
    for (from, to, wanted) in [
        (
            "QP = -330.0, -400.0, 215.0",
            "QP = -400.0, -330.0, 215.0",
            "if x and y of MARKER/4 are exchanged",
        ),
        (
            "QP = 60.0, -370.0, 205.0",
            "QP = 60.0, 370.0, 205.0",
            "if y of MARKER/2 has the opposite sign",
        ),
        (
            "REULER = -94.26789330029D, 94.0D, 7.0D",
            "REULER = 94.26789330029D, -94.0D, -7.0D",
            "if the axes of MARKER/2 are mirrored",
        ),
    ] {
        let (folder, study) = copied("pseudo-mcpherson");
        change(&study.join("model.adm"), from, to);
        let (said, code) = told(folder.path());
        assert!(code == 1 && said.contains(wanted), "{to}: {said}");
    }
    let (folder, study) = copied("pseudo-mcpherson");
    // The top mount is tilted, of which the lint of the deck warns.
    change(
        &study.join("model.adm"),
        "REULER = 163.810793743D, 10.16697863183D, -164.0519817344D",
        "REULER = -163.810793743D, -10.16697863183D, 164.0519817344D",
    );
    let refused = admire(folder.path(), &["diagnose", "study", "--out", "out"]);
    let warning = refused.err.find("bushing-angle");
    let reason = refused.err.find("implausible-study");
    assert!(
        refused.code == 1 && warning.is_some() && warning < reason,
        "{}",
        refused.err
    );
}

/// Returns the local coordinates of a marker of the knuckle after a sign change of one ground coordinate. The frame of the knuckle has REULER =
/// 10, 5, 0 degrees and is at (5, -690, 310).
fn on_the_other_side(local: &[f64], axis: usize) -> String {
    let place = [5.0, -690.0, 310.0];
    let (a, b) = (10f64.to_radians(), 5f64.to_radians());
    let turn = [
        [a.cos(), -a.sin() * b.cos(), a.sin() * b.sin()],
        [a.sin(), a.cos() * b.cos(), -a.cos() * b.sin()],
        [0.0, b.sin(), b.cos()],
    ];
    let mut ground: Vec<f64> = (0..3)
        .map(|i| place[i] + (0..3).map(|j| turn[i][j] * local[j]).sum::<f64>())
        .collect();
    ground[axis] = -ground[axis];
    let back = |j: usize| {
        (0..3)
            .map(|i| turn[i][j] * (ground[i] - place[i]))
            .sum::<f64>()
    };
    let text: Vec<String> = (0..3).map(|j| format!("{:.9}", back(j))).collect();
    text.join(", ")
}

#[test]
fn a_contact_point_on_the_other_side_is_refused() {
    let (folder, study) = copied("pseudo-mcpherson");
    let deck = study.join("model.adm");
    let text = std::fs::read_to_string(&deck).unwrap();
    let at = text.find("MARKER/19").unwrap();
    let qp = text[at..].find("QP = ").unwrap() + at + 5;
    let end = qp + text[qp..].find('\n').unwrap();
    let numbers = text[qp..end].split(',').map(|x| x.trim().parse().unwrap());
    let other = on_the_other_side(&numbers.collect::<Vec<f64>>(), 1);
    std::fs::write(&deck, format!("{}{other}{}", &text[..qp], &text[end..])).unwrap();
    let (said, code) = told(folder.path());
    let wanted = "MARKER/19 on the other side (opposite sign of y in ground axes)";
    assert!(code == 1 && said.contains(wanted), "{said}");
}

#[test]
fn marks_that_are_a_mirror_image_are_refused() {
    for (mirror, wanted) in [
        (0, "changing the sign of column `y` corrects this"),
        (1, "exchanging columns `x` and `y` corrects this"),
    ] {
        let (folder, study) = copied("pseudo-mcpherson");
        let marks = study.join("marks_measured.csv");
        let text = std::fs::read_to_string(&marks).unwrap();
        let line = |(at, line): (usize, &str)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
            match mirror {
                _ if at == 0 => {}
                0 => cells[4] = (-cells[4].parse::<f64>().unwrap()).to_string(),
                _ => cells.swap(3, 4),
            }
            cells.join(",")
        };
        let lines: Vec<String> = text.lines().enumerate().map(line).collect();
        std::fs::write(&marks, lines.join("\n") + "\n").unwrap();
        let (said, code) = told(folder.path());
        assert!(code == 1 && said.contains(wanted), "{said}");
        assert!(!said.contains("marks.sigma states"), "{said}");
    }
}

/// Checks the sign of a channel in a study with stiffnesses to identify. Its direction is also compared in a study without any.
#[test]
fn a_channel_with_the_other_sign_is_seen_whether_or_not_stiffnesses_are_sought() {
    let (folder, study) = copied("kc-curves");
    let toml = study.join("study.toml");
    change(&toml, "caster = { sigma", "caster = { sign = \"-\", sigma");
    let (said, code) = told(folder.path());
    assert!(
        code == 1 && said.contains("`caster` with the opposite sign"),
        "{said}"
    );
    change(
        &toml,
        "bushings = [\"BUSHING/1\", \"BUSHING/2\"]",
        "bushings = []",
    );
    let (said, _) = told(folder.path());
    assert!(said.contains("caster moves against the model"), "{said}");
}

/// Checks that studies with start values wrong by a factor of seven, and with correct rubber and points, are not refused.
#[test]
fn sound_studies_are_not_refused() {
    for name in [
        "pseudo-mcpherson",
        "kc-experiment",
        "kc-curves",
        "multilink",
    ] {
        let (folder, _study) = copied(name);
        let (said, code) = told(folder.path());
        assert!(code == 0 && !said.contains(" slip "), "{name}: {said}");
    }
}

/// Checks that ambiguous tables are refused with their position, and that tables of spreadsheets are read.
#[test]
fn tables_that_can_be_read_in_two_ways_are_refused() {
    let (folder, study) = copied("pseudo-mcpherson");
    let table = study.join("load_cases.csv");
    let shipped = std::fs::read_to_string(&table).unwrap();
    let fit = |format: &str| {
        admire(
            folder.path(),
            &[
                "--format", format, "identify", "study", "--method", "direct", "--out", "out",
            ],
        )
    };
    // Points that separate thousands, together with decimal commas.
    let grouped = shipped
        .replace(',', ";")
        .replace("1500;0;0", "1.500;0,0;0,0");
    std::fs::write(&table, grouped).unwrap();
    let said = fit("plain");
    assert!(
        said.code == 1 && said.err.contains("load_cases.csv:2:3"),
        "{}",
        said.err
    );
    assert!(said.err.contains("`1.500` is ambiguous"), "{}", said.err);
    // Two columns with the same name.
    let line = |(at, line): (usize, &str)| {
        let more = if at == 0 {
            "vertical".to_string()
        } else {
            format!("{at}")
        };
        format!("{line},{more}")
    };
    let twice: Vec<String> = shipped.lines().enumerate().map(line).collect();
    std::fs::write(&table, twice.join("\n") + "\n").unwrap();
    let said = fit("plain");
    assert!(
        said.code == 1 && said.err.contains("two columns are called `vertical`"),
        "{}",
        said.err
    );
    // UTF-16, as spreadsheets write it.
    let mut bytes = vec![0xff, 0xfe];
    bytes.extend(shipped.encode_utf16().flat_map(u16::to_le_bytes));
    std::fs::write(&table, bytes).unwrap();
    let said = fit("plain");
    assert_eq!(said.code, 0, "{}", said.err);
}
