//! Adding statements to a deck and removing them on the command line.

use super::commands::{DECK, Folder};

#[test]
fn statements_come_and_go_from_the_command_line() {
    let folder = Folder::new();
    let deck = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("there");
    // The new statement has the style of the deck (CR LF, layout of arguments) and follows the last marker.
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
    // Removal leaves no trace.
    assert_eq!(folder.said(&["remove", "b.adm", "tip", "-o", "c.adm"]).0, 0);
    assert_eq!(deck("c.adm"), DECK);
    // A function that another argument follows needs a backslash if arguments have their own lines, but not on a single line.
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
    // Removal of a single argument.
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
        // The body of the new marker would depend on its position.
        (
            &["add", "a.adm", "MARKER/5, QP=1, 2, 3"],
            1,
            "does not name its body",
        ),
        (
            &["add", "a.adm", "PART/2, MASS=1"],
            1,
            "the deck already has PART/2",
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
    // Removed together, the statements leave no dangling reference.
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
