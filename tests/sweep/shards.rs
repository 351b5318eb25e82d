use std::path::Path;

use admire_sweep::{SweepPlan, TableReader};

use super::{Bench, NUMBERS, admire, bits, said, shown};

#[test]
fn any_sharding_gives_the_bits_of_single_runs() {
    let bench = Bench::cases(90);
    assert!(bench.sweep("whole", &["--jobs", "3"]).status.success());
    let whole = bench.rows("whole", NUMBERS);
    assert_eq!(whole.len(), 90);
    for (of, order) in [(2, vec![2, 1]), (7, vec![4, 1, 7, 2, 6, 3, 5])] {
        let out = format!("parts-{of}");
        for number in order {
            let shard = format!("{number}/{of}");
            let ran = bench.sweep(&out, &["--shard", &shard, "--jobs", "1"]);
            assert!(ran.status.success(), "{}", said(&ran));
        }
        let folder = bench.path(&out);
        assert!(admire(&["merge", shown(&folder)]).status.success());
        let parts = bench.rows(&out, NUMBERS);
        assert!(
            parts.iter().map(bits).eq(whole.iter().map(bits)),
            "{of} shards"
        );
    }
    // Single runs of the same decks, by way of files.
    let plan = SweepPlan::read(&bench.path("sweep.toml"))
        .value
        .expect("a plan");
    for case in [0, 41, 89] {
        let folder = bench.path(&format!("case-{case}"));
        std::fs::create_dir(&folder).expect("a folder");
        let deck = plan.deck_with(&plan.numbers(case)).expect("a deck");
        std::fs::write(folder.join("model.adm"), deck.bytes()).expect("written");
        std::fs::copy(bench.path("lateral.acf"), folder.join("lateral.acf")).expect("a copy");
        let columns = single_run(&folder);
        let row = &whole[case as usize].0;
        let [height, psi, shift] = row.outputs[..] else {
            panic!("three columns");
        };
        let [(z, _, y0), (_, psi_last, y1)] = columns[..] else {
            panic!("two steps");
        };
        assert_eq!(
            (height.to_bits(), psi.to_bits()),
            (z.to_bits(), psi_last.to_bits())
        );
        assert_eq!(shift.to_bits(), (y0.max(y1) - y0.min(y1)).to_bits());
    }
}

/// Returns Z, PSI and Y of the knuckle in both steps, from the results file that `mdi` writes.
fn single_run(folder: &Path) -> Vec<(f64, f64, f64)> {
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_mdi"))
        .args(["-c", "ru-standard", "i", "lateral.acf", "exit"])
        .current_dir(folder)
        .output()
        .expect("mdi starts");
    assert!(ran.status.success());
    let results = folder.join("model.res");
    let words = [
        "results",
        shown(&results),
        "--plain",
        "--steps",
        "2-",
        "--get",
    ];
    let mut words = words.to_vec();
    words.extend(["KNUCKLE_XFORM.Z", "KNUCKLE_XFORM.PSI", "KNUCKLE_XFORM.Y"]);
    let text = String::from_utf8(admire(&words).stdout).expect("text");
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().expect("heads").split(',').collect();
    let at = |name: &str| {
        heads
            .iter()
            .position(|head| head.ends_with(name))
            .expect("a column")
    };
    let (z, psi, y) = (at(".Z"), at(".PSI"), at(".Y"));
    lines
        .map(|line| {
            let cells: Vec<f64> = line
                .split(',')
                .map(|c| c.parse().expect("a number"))
                .collect();
            (cells[z], cells[psi], cells[y])
        })
        .collect()
}

#[test]
fn another_variation_leaves_the_numbers_of_the_others() {
    let bench = Bench::cases(20);
    let plan = SweepPlan::read(&bench.path("sweep.toml"))
        .value
        .expect("a plan");
    let more = Bench::new(|text| {
        let text = text.replace("cases = 1000", "cases = 20");
        text + "\n[[vary]]\naddress = \"MARKER/4.QP.1\"\nuniform = [-331.0, -329.0]\n"
    });
    let with_more = SweepPlan::read(&more.path("sweep.toml"))
        .value
        .expect("a plan");
    for case in 0..20 {
        assert_eq!(plan.numbers(case)[..], with_more.numbers(case)[..NUMBERS]);
    }
}

#[test]
fn merging_refuses_what_is_missing_and_what_is_of_another_sweep() {
    let bench = Bench::cases(12);
    assert!(bench.sweep("a", &["--shard", "2/3"]).status.success());
    let folder = bench.path("a");
    let refused = admire(&["merge", shown(&folder)]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        said(&refused).contains("unfinished shards: 1/3, 3/3"),
        "{}",
        said(&refused)
    );
    // A shard of a sweep with another seed.
    let other = Bench::new(|text| {
        text.replace("cases = 1000", "cases = 12")
            .replace("seed = 1", "seed = 2")
    });
    assert!(bench.sweep("a", &["--shard", "3/3"]).status.success());
    assert!(other.sweep("a", &["--shard", "1/3"]).status.success());
    let part = "shards/0001-of-0003.parquet";
    std::fs::copy(other.path("a").join(part), folder.join(part)).expect("a copy");
    let refused = admire(&["merge", shown(&folder)]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        said(&refused).contains("0001-of-0003.parquet`: the checksum"),
        "{}",
        said(&refused)
    );
    std::fs::remove_file(folder.join(part)).expect("removed");
    // A shard of another version.
    let manifest = std::fs::read_to_string(folder.join("sweep.json")).expect("the manifest");
    assert!(bench.sweep("a", &["--shard", "1/3"]).status.success());
    let version = TableReader::open(&folder.join(part)).expect("a part");
    let version = version.fact("admire.version").expect("a version");
    std::fs::write(
        folder.join("sweep.json"),
        manifest.replace(version, "0.0.1"),
    )
    .expect("written");
    let refused = admire(&["merge", shown(&folder)]);
    assert!(
        said(&refused).contains("the version of admire"),
        "{}",
        said(&refused)
    );
    std::fs::write(folder.join("sweep.json"), manifest).expect("written");
    assert!(admire(&["merge", shown(&folder)]).status.success());
    assert_eq!(bench.rows("a", NUMBERS).len(), 12);
}

/// Checks that flipped bits of a finished shard are detected by `merge` and when the sweep continues, and that the affected rows are named.
/// Without the file, its cases are run again with the same result.
#[test]
fn a_part_with_flipped_bits_is_not_taken() {
    let bench = Bench::cases(12);
    for number in 1..=3 {
        let ran = bench.sweep("out", &["--shard", &format!("{number}/3")]);
        assert!(ran.status.success(), "{}", said(&ran));
    }
    let out = bench.path("out");
    let parts: Vec<_> = std::fs::read_dir(out.join("shards"))
        .expect("parts")
        .map(|entry| entry.expect("a part").path())
        .collect();
    assert_eq!(parts.len(), 3);
    let part = parts.iter().min().expect("a part");
    let whole = std::fs::read(part).expect("bytes");
    // Nine positions throughout the file, three bits each.
    for k in 0..9 {
        let mut bytes = whole.clone();
        for bit in 0..3 {
            let at = (whole.len() * (3 * k + bit) / 27).min(whole.len() - 1);
            bytes[at] ^= 1 << ((k + bit) % 8);
        }
        std::fs::write(part, &bytes).expect("written");
        let merged = admire(&["merge", shown(&out)]);
        assert_eq!(merged.status.code(), Some(1), "{k}: {}", said(&merged));
        assert!(!out.join("results.parquet").exists(), "{k}");
        let resumed = bench.sweep("out", &["--shard", "1/3"]);
        assert_eq!(resumed.status.code(), Some(1), "{k}: {}", said(&resumed));
    }
    let mut bytes = whole.clone();
    bytes[whole.len() / 9] ^= 1;
    std::fs::write(part, &bytes).expect("written");
    let merged = said(&admire(&["merge", shown(&out), "--format", "plain"]));
    assert!(
        merged.contains("row group 1 (rows 1 to 4) has changed"),
        "{merged}"
    );
    assert!(
        merged.contains("`--shard 1/3` runs its cases again"),
        "{merged}"
    );
    std::fs::remove_file(part).expect("removed");
    assert!(bench.sweep("out", &["--shard", "1/3"]).status.success());
    assert!(admire(&["merge", shown(&out)]).status.success());
    assert!(bench.sweep("alone", &[]).status.success());
    let (parts, alone) = (bench.rows("out", NUMBERS), bench.rows("alone", NUMBERS));
    assert!(parts.iter().map(bits).eq(alone.iter().map(bits)));
    // The merged result has its own checksum.
    let results = out.join("results.parquet");
    let mut bytes = std::fs::read(&results).expect("bytes");
    let middle = bytes.len() / 3;
    bytes[middle] ^= 16;
    std::fs::write(&results, bytes).expect("written");
    assert_eq!(admire(&["merge", shown(&out)]).status.code(), Some(1));
}
