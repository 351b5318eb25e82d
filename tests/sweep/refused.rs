use super::{Bench, said, shown};

#[test]
fn what_is_wrong_is_told_with_its_place_before_anything_runs() {
    let wrong = [
        (
            "\"BUSHING/1.K.3\"",
            "\"BUSHING/9.K.3\"",
            "BUSHING/9 is not in this dataset",
            "sweep.toml:41",
        ),
        (
            "\"BUSHING/1.K.3\"",
            "\"BUSHING/1.K.1\"",
            "also varied by `bushing_A_radial`",
            "sweep.toml:41",
        ),
        (
            "\"MARKER/2.QP.3\"",
            "\"MARKER/2.PART\"",
            "must be a whole number",
            "sweep.toml:35",
        ),
        (
            "[-1.0, 1.0]",
            "[1.0, 1.0]",
            "needs two finite bounds",
            "sweep.toml:37",
        ),
        (
            "sd = 0.05",
            "sd = 0.0",
            "`sd` must be above zero",
            "sweep.toml:15",
        ),
        (
            "[9000.0, 10000.0, 11000.0]",
            "[]",
            "`values` must be a list of one or more",
            "sweep.toml:42",
        ),
        (
            "[1, 2, 1]",
            "[1, 2]",
            "every value needs a weight of zero or more",
            "sweep.toml:43",
        ),
        (
            "coefficient = 0.7",
            "coefficient = -1.0",
            "positive definite",
            "sweep.toml:23",
        ),
        (
            "KNUCKLE_XFORM.PSI",
            "KNUCKLE_XFORM.PSY",
            "no column of the results matches",
            "sweep.toml:50",
        ),
        (
            "\"latin-hypercube\"",
            "\"sobol-indices\"",
            "does not support correlations",
            "sweep.toml:23",
        ),
        (
            "\"range\"",
            "\"sum\"",
            "`at` must be last, first",
            "sweep.toml:56",
        ),
        (
            "model.adm",
            "absent.adm",
            "absent.adm` cannot be read",
            "sweep.toml:3",
        ),
        (
            "seed = 1",
            "sead = 1",
            "unknown field `sead`",
            "sweep.toml:5",
        ),
        (
            "name = \"strut_mount\"",
            "name = \"status\"",
            "cannot be called `status`, which is a column of every results table",
            "sweep.toml",
        ),
    ];
    for (before, after, why, place) in wrong {
        let bench = Bench::new(|text| {
            assert!(text.contains(before), "{before}");
            text.replace(before, after)
        });
        let refused = bench.sweep("out", &["--format", "plain"]);
        assert_eq!(
            refused.status.code(),
            Some(1),
            "{after}: {}",
            said(&refused)
        );
        assert!(said(&refused).contains(why), "{after}: {}", said(&refused));
        assert!(
            said(&refused).contains(place),
            "{after}: {}",
            said(&refused)
        );
        assert!(!bench.path("out").exists(), "{after}");
    }
}

#[test]
fn a_folder_that_is_not_the_sweeps_own_is_refused() {
    let bench = Bench::cases(10);
    let out = bench.path("out");
    std::fs::create_dir(&out).expect("a folder");
    std::fs::write(out.join("notes.txt"), "mine").expect("written");
    let refused = bench.sweep("out", &[]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(said(&refused).contains("notes.txt"), "{}", said(&refused));
    assert_eq!(std::fs::read_dir(&out).expect("a folder").count(), 1);
    std::fs::remove_file(out.join("notes.txt")).expect("removed");
    assert!(bench.sweep("out", &[]).status.success());
    // The inputs differ, because the deck was changed.
    let deck = std::fs::read_to_string(bench.path("model.adm")).expect("a deck");
    std::fs::write(
        bench.path("model.adm"),
        deck.replace("3500.0, 3500.0", "3600.0, 3500.0"),
    )
    .expect("written");
    let refused = bench.sweep("out", &[]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        said(&refused).contains("model.adm changed since"),
        "{}",
        said(&refused)
    );
    // Another number of shards.
    let again = Bench::cases(10);
    assert!(again.sweep("out", &["--shard", "1/4"]).status.success());
    let refused = again.sweep("out", &["--shard", "1/5"]);
    assert!(
        said(&refused).contains("4 shards, not 5"),
        "{}",
        said(&refused)
    );
    // A folder without write access.
    #[cfg(target_os = "linux")]
    {
        let refused = again.sweep("/proc/self/new", &[]);
        assert_eq!(refused.status.code(), Some(1));
        let said = said(&refused);
        assert!(
            said.contains("nothing can be written into `/proc/self`"),
            "{said}"
        );
    }
    // A file at the path of the folder.
    std::fs::write(again.path("file"), "").expect("written");
    let refused = again.sweep("file", &[]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        said(&refused).contains(shown(&again.path("file"))),
        "{}",
        said(&refused)
    );
}

#[test]
fn a_case_that_fails_says_why_and_stops_no_other() {
    // A bushing ten metres away from its position; the iteration does not converge.
    let bench = Bench::new(|text| {
        text.replace("cases = 1000", "cases = 40")
            .replace("\"BUSHING/1.K.3\"", "\"MARKER/4.QP.1\"")
            .replace("[9000.0, 10000.0, 11000.0]", "[-330.0, -331.0, 1e4]")
    });
    let ran = bench.sweep("out", &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    let rows = bench.rows("out", super::NUMBERS);
    let failed: Vec<_> = rows
        .iter()
        .filter(|(_, numbers)| numbers[4] > 0.0)
        .collect();
    // A quarter of a Latin hypercube.
    assert_eq!(failed.len(), 10);
    for (row, _) in &failed {
        assert_eq!(row.status.word(), "no-answer");
        assert!(row.reason.contains("no equilibrium"), "{}", row.reason);
        assert!(row.outputs.iter().all(|value| value.is_nan()));
    }
    let summary = std::fs::read_to_string(bench.path("out/summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(
        summary["statuses"],
        serde_json::json!({"no-answer": 10, "ok": 30})
    );
    let fine = rows.iter().filter(|(row, _)| row.status.word() == "ok");
    assert_eq!(fine.clone().count(), 30);
    assert!(
        fine.flat_map(|(row, _)| &row.outputs)
            .all(|value| value.is_finite())
    );
}

/// Checks that every path of SWEEP.toml must be below its folder, as in study.toml: nothing outside is read, shown or written.
#[cfg(unix)]
#[test]
fn paths_of_a_plan_do_not_lead_out_of_its_folder() {
    let outside = tempfile::tempdir().expect("a folder");
    let secret = outside.path().join("secret");
    std::fs::write(&secret, "the secret line\nPART/1\n").expect("written");
    for (before, after) in [
        ("\"model.adm\"", "\"/etc/passwd\""),
        ("\"model.adm\"", "\"SECRET\""),
        ("\"model.adm\"", "\"link\""),
        ("\"model.adm\"", "\"up/secret\""),
        ("\"lateral.acf\"", "\"../lateral.acf\""),
        ("\"lateral.acf\"", "\"link\""),
        ("commands = \"lateral.acf\"", "kc = \"link\""),
        (
            "deck = \"model.adm\"\ncommands = \"lateral.acf\"",
            "study = \"up\"",
        ),
        (
            "seed = 1",
            "seed = 1\nsolver = { command = [\"mdi\", \"{acf}\"], recordings = \"../x\" }",
        ),
        ("seed = 1", "seed = 1\nsolver = { recordings = \"up/new\" }"),
        (
            "seed = 1",
            "seed = 1\nsolver = { recordings = \"dangling\" }",
        ),
    ] {
        let shown_secret = shown(&secret).to_string();
        let bench = Bench::new(|text| {
            assert!(text.contains(before), "{before}");
            text.replacen(before, &after.replace("SECRET", &shown_secret), 1)
        });
        let link = std::os::unix::fs::symlink::<&std::path::Path, _>;
        link(&secret, bench.path("link")).expect("a link");
        link(outside.path(), bench.path("up")).expect("a link");
        link(&outside.path().join("new"), bench.path("dangling")).expect("a link");
        let refused = bench.sweep("out", &["--format", "plain"]);
        let said = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{after}: {said}");
        assert!(
            said.contains("lies outside of the sweep folder"),
            "{after}: {said}"
        );
        assert!(said.contains("sweep.toml:"), "{after}: {said}");
        assert!(
            !said.contains("secret line") && !said.contains("root:"),
            "{said}"
        );
        assert!(!bench.path("out").exists(), "{after}");
    }
    let left = std::fs::read_dir(outside.path()).expect("there").count();
    assert_eq!(left, 1, "nothing was written outside");
}
