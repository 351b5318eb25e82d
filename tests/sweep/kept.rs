use admire_sweep::SweepPlan;

use super::{Bench, NUMBERS, admire, said, shown};

/// Returns the plan of the corpus with K&C tests instead of the command file.
fn with_tests(text: String) -> String {
    let until = text.find("[[keep]]").expect("a keep");
    text[..until]
        .replace("commands = \"lateral.acf\"", "kc = \"kc.toml\"")
        .replace("cases = 1000", "cases = 3")
        + "[[keep]]\ncharacteristic = \"toe_angle.left\"\n\n[[keep]]\ncharacteristic = \"toe_angle.left\"\ntest = \"bounce\"\n"
}

#[test]
fn characteristics_are_those_of_the_command_kc_on_the_same_deck() {
    let bench = Bench::new(with_tests);
    let ran = bench.sweep("out", &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    let plan = SweepPlan::read(&bench.path("sweep.toml"))
        .value
        .expect("a plan");
    let rows = bench.rows("out", NUMBERS);
    let deck = plan.deck_with(&plan.numbers(2)).expect("a deck");
    let (path, out) = (bench.path("case.adm"), bench.path("kc"));
    std::fs::write(&path, deck.bytes()).expect("written");
    let config = bench.path("kc.toml");
    let ran = admire(&[
        "kc",
        shown(&path),
        "--config",
        shown(&config),
        "--out",
        shown(&out),
    ]);
    assert!(ran.status.success(), "{}", said(&ran));
    let json = std::fs::read_to_string(out.join("kc.json")).expect("kc.json");
    let all: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let numbers = numbers_in(&all);
    for value in &rows[2].0.outputs {
        let same = numbers
            .iter()
            .any(|number| number.to_bits() == value.to_bits());
        assert!(value.abs() > 0.0 && same, "{value} is not in kc.json");
    }
    assert_ne!(rows[2].0.outputs, rows[1].0.outputs);
}

fn numbers_in(value: &serde_json::Value) -> Vec<f64> {
    match value {
        serde_json::Value::Number(number) => number.as_f64().into_iter().collect(),
        serde_json::Value::Array(all) => all.iter().flat_map(numbers_in).collect(),
        serde_json::Value::Object(all) => all.values().flat_map(numbers_in).collect(),
        _ => Vec::new(),
    }
}

/// A mass on a spring along z.
const SPRING: &str = "a mass on a spring
UNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=METER,TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1
PART/2,MASS=2,CM=2,IP=1,1,1
MARKER/2,PART=2
JOINT/1,TRANSLATIONAL,I=2,J=1
SPRINGDAMPER/1,TRANSLATIONAL,I=2,J=3,K=800,C=4,LENGTH=1
MARKER/3,PART=1,QP=0,0,-1
ACCGRAV/KGRAV=-9.81
RESULTS/XRF
END
";

#[test]
fn eigenvalues_and_every_combination_follow_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("model.adm"), SPRING).expect("written");
    std::fs::write(
        path("run.acf"),
        "\nfile/model=model\nSIMULATE/STATIC\nLINEAR/EIGENSOL\nSTOP\n",
    )
    .expect("written");
    let plan = "deck = \"model.adm\"\ncommands = \"run.acf\"\n[sampling]\nplan = \"full-factorial\"\n\
        [[vary]]\nname = \"k\"\naddress = \"SPRINGDAMPER/1.K\"\nuniform = [400, 1200]\nlevels = 3\n\
        [[vary]]\nname = \"m\"\naddress = \"PART/2.MASS\"\nvalues = [1, 2, 4]\n\
        [[keep]]\nmode = 1\n[[keep]]\ncolumn = \"PART_2_XFORM.Z\"\n";
    std::fs::write(path("sweep.toml"), plan).expect("written");
    let (file, out) = (path("sweep.toml"), path("out"));
    let ran = admire(&["sweep", shown(&file), "--out", shown(&out)]);
    assert!(ran.status.success(), "{}", said(&ran));
    let bench = Bench { folder };
    let rows = bench.rows("out", 2);
    let grid: Vec<(f64, f64)> = [400.0, 800.0, 1200.0]
        .iter()
        .flat_map(|k| [1.0, 2.0, 4.0].map(|m| (*k, m)))
        .collect();
    assert_eq!(rows.len(), grid.len());
    for ((row, numbers), (k, m)) in rows.iter().zip(grid) {
        assert_eq!(numbers[..], [k, m]);
        let [frequency, damping, z] = row.outputs[..] else {
            panic!("three columns");
        };
        let omega = f64::sqrt(k / m);
        assert!(
            (frequency / (omega / std::f64::consts::TAU) - 1.0).abs() < 1e-6,
            "{frequency}"
        );
        assert!(
            (damping / (4.0 / (2.0 * m * omega)) - 1.0).abs() < 1e-6,
            "{damping}"
        );
        assert!((z + m * 9.81 / k).abs() < 1e-6, "{z}");
    }
}

#[test]
fn a_program_gives_what_the_built_in_solver_gives() {
    let bench = Bench::cases(4);
    assert!(bench.sweep("own", &[]).status.success());
    let mdi = env!("CARGO_BIN_EXE_mdi").replace('\\', "/");
    let text = std::fs::read_to_string(bench.path("sweep.toml")).expect("the plan");
    let solver = format!(
        "\n[solver]\ncommand = [\"{mdi}\", \"-c\", \"ru-s\", \"i\", \"{{acf}}\", \"exit\"]\n"
    );
    std::fs::write(bench.path("sweep.toml"), text + &solver).expect("written");
    let ran = bench.sweep("program", &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    let (own, program) = (bench.rows("own", NUMBERS), bench.rows("program", NUMBERS));
    assert!(
        own.iter()
            .map(super::bits)
            .eq(program.iter().map(super::bits))
    );
}

#[test]
fn a_table_of_cases_is_run_row_by_row() {
    let bench = Bench::new(|text| {
        let (from, until) = (
            text.find("[sampling]").expect("a plan"),
            text.find("[[keep]]").expect("a keep"),
        );
        let keeps = &text[until..];
        format!(
            "{}[sampling]\nplan = \"table\"\nfile = \"cases.csv\"\n\n{keeps}",
            &text[..from]
        )
    });
    std::fs::write(
        bench.path("cases.csv"),
        "BUSHING/1.K.1, MARKER/2.QP.3\n9000, 205\n10000, 205\n10000, 206.5\n",
    )
    .expect("written");
    let ran = bench.sweep("out", &[]);
    assert!(ran.status.success(), "{}", said(&ran));
    let rows = bench.rows("out", 2);
    let numbers: Vec<&[f64]> = rows.iter().map(|(_, numbers)| &numbers[..]).collect();
    assert_eq!(
        numbers,
        [[9000.0, 205.0], [10000.0, 205.0], [10000.0, 206.5]]
    );
    let plan = SweepPlan::read(&bench.path("sweep.toml"))
        .value
        .expect("a plan");
    // The second row is the unchanged deck.
    assert_eq!(
        plan.deck_with(&plan.numbers(1)).expect("a deck").bytes(),
        plan.deck.bytes()
    );
    std::fs::write(bench.path("cases.csv"), "BUSHING/1.K.1\n9000\nmany\n").expect("written");
    let refused = bench.sweep("other", &[]);
    assert!(
        said(&refused).contains("line 3: `many` is not a number"),
        "{}",
        said(&refused)
    );
}
