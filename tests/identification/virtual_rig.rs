//! The virtual rig: its readings are those of the solver, and every cause of the study format can be planted.

use std::path::Path;

use admire_rig::effect::{EffectSpec, causes, outside_causes};
use admire_rig::{LoadTable, RigOptions, RigRun, Scatter, Tolerances, virtual_rig};

use crate::setup::replace;

/// Copies the shipped McPherson, with its reference deck as the reality, a wheel and two sensors.
fn folder() -> tempfile::TempDir {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&shipped).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let reference = folder.path().join("reference.adm");
    std::fs::rename(reference, folder.path().join("model.adm")).unwrap();
    replace(
        folder.path(),
        "study.toml",
        "[reference]\ndeck = \"reference.adm\"\n",
        "",
    );
    let toml = std::fs::read_to_string(folder.path().join("study.toml")).unwrap();
    let more = "[wheel]\nmarker = \"MARKER/20\"\naxis = \"y\"\n[readings]\nfile = \"readings.csv\"\n[readings.channels]\n\
                height = { function = \"DZ(11,1)\", sigma = 1.0 }\ntravel = { function = \"DM(18,17)\", sigma = 0.1, relative_to = \"3\" }\n";
    std::fs::write(folder.path().join("study.toml"), toml + more).unwrap();
    folder
}

fn rig(effects: &[&str], sigma: f64, seed: u64) -> RigRun {
    let folder = folder();
    let effects = effects
        .iter()
        .map(|text| EffectSpec::parse(text).unwrap())
        .collect();
    let options = RigOptions {
        seed,
        sigma: Some(sigma),
        effects,
        ..RigOptions::default()
    };
    virtual_rig(folder.path(), &options).unwrap_or_else(|why| panic!("{why:#?}"))
}

fn file(run: &RigRun, name: &str) -> String {
    let found = run.files.iter().find(|(path, _)| path == Path::new(name));
    String::from_utf8(found.unwrap_or_else(|| panic!("{name}")).1.clone()).unwrap()
}

/// Returns the numbers of a CSV file from the given column on.
fn numbers(text: &str, first: usize) -> Vec<f64> {
    let rows = text.lines().skip(1);
    rows.flat_map(|row| {
        row.split(',')
            .skip(first)
            .map(|x| x.parse().unwrap())
            .collect::<Vec<f64>>()
    })
    .collect()
}

fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn an_honest_rig_reads_the_reference_marks() {
    let run = rig(&[], 0.0, 1);
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/pseudo-mcpherson");
    let expected = std::fs::read_to_string(shipped.join("marks_noise_free.csv")).unwrap();
    let (ours, theirs) = (
        numbers(&file(&run, "marks_measured.csv"), 3),
        numbers(&expected, 3),
    );
    assert!(ours.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 2e-6));
    // The readings are relative to case 3, which therefore reads zero.
    let readings = file(&run, "readings.csv");
    assert!(readings.starts_with("case,height,travel\n"));
    assert_eq!(numbers(&readings, 1)[5], 0.0);
    // Camber and steer at 4500 N differ between +4000 N and -4000 N lateral, and are in degrees.
    let wheel = numbers(&file(&run, "wheel.csv"), 1);
    assert!(
        (wheel[5 * 5 + 3] - wheel[8 * 5 + 3]).abs() > 0.05,
        "{wheel:?}"
    );
    assert!(run.truth.is_empty());
}

#[test]
fn noise_has_its_size_and_its_seed() {
    let exact = numbers(&file(&rig(&[], 0.0, 1), "marks_measured.csv"), 3);
    let (a, b) = (rig(&[], 0.05, 7), rig(&[], 0.05, 7));
    assert_eq!(a.files, b.files);
    let noisy = numbers(&file(&a, "marks_measured.csv"), 3);
    // 780 coordinates: the rms is known to 2.5 percent.
    assert!((rms_difference(&noisy, &exact) / 0.05 - 1.0).abs() < 0.1);
    assert_ne!(
        file(&rig(&[], 0.05, 8), "marks_measured.csv"),
        file(&a, "marks_measured.csv")
    );
    assert!(file(&a, "study.toml").contains("sigma = 0.05"));
    // A planted effect does not change the noise of the readings.
    let shifted = numbers(
        &file(
            &rig(&["frame-drift@case 2:x=1"], 0.05, 7),
            "marks_measured.csv",
        ),
        3,
    );
    let moved: Vec<f64> = shifted.iter().zip(&noisy).map(|(a, b)| a - b).collect();
    assert!(
        moved
            .iter()
            .all(|d| d.abs() < 1e-8 || (d - 1.0).abs() < 1e-8)
    );
}

#[test]
fn every_cause_can_be_planted() {
    let exact = rig(&[], 0.0, 1);
    let (marks, wheel) = (
        file(&exact, "marks_measured.csv"),
        file(&exact, "wheel.csv"),
    );
    let specs = [
        "progressive-stiffness@BUSHING/2.K.1:cubic=300",
        "progressive-stiffness@BUSHING/2.K.1:law=exponential,rate=1.0",
        "dry-friction@BUSHING/2.K.1:force=200,stiffness=4000",
        "dry-friction@BUSHING/2.K.1:force=200,stiffness=4000,law=dahl",
        "dry-friction@BUSHING/1.K.3:force=123.4567891234,stiffness=22001.23456789,law=dahl",
        "dry-friction@JOINT/3:force=100,stiffness=500",
        "link-compliance@PART/6:stiffness=8000",
        "link-compliance@PART/6:stiffness=8000,ends=both",
        "link-compliance@PART/6:stiffness=8000,rated=4000",
        "free-play@BUSHING/2.K.2:gap=0.2",
        "free-play@PART/6:gap=0.3",
        "free-play@PART/6:gap=0.3,force=300",
        "body-compliance@JOINT/5:stiffness=5000",
        "body-compliance@BUSHING/3:stiffness=5000",
        "body-compliance@JOINT/5:stiffness=5000,x=0.5,z=2,rated=3000",
        "assembly-offset@BUSHING/1:x=0.3,az_deg=0.2",
        "hardpoint-error@MARKER/7:y=1.0",
        "bushing-orientation@BUSHING/2:az_deg=20",
        "bushing-coupling@BUSHING/2:xy=400",
        "bushing-coupling@BUSHING/2:xy=400,reach=0.5",
        "element-parameter@SPRINGDAMPER/1.FORCE:factor=1.05",
        "element-parameter@BUSHING/3.K.1:value=2000",
        "stop-contact@JOINT/3:clearance=-5,stiffness=200",
        "stop-contact@SPRINGDAMPER/1:clearance=10,stiffness=50,law=quadratic",
        "load-gain@SFORCE/3:gain=1.05",
        "load-gain@lateral:gain=1.05",
        "load-gain@lateral:gain=1.05,law=growing",
        "load-crosstalk@SFORCE/2<-SFORCE/3:fraction=0.03",
        "load-crosstalk@SFORCE/2<-SFORCE/3:fraction=0.03,law=growing",
        "load-point-error@MARKER/19:x=5",
        "load-point-error@MARKER/19:x=5,law=growing",
        "frame-drift@case 7:x=0.2,az_deg=0.01",
        "frame-drift@case 7:x=0.2,creep=1",
        "mark-outlier@case 7 KNUCKLE 3:x=0.5",
        "mark-place@KNUCKLE 3:x=0.5",
        "mark-place@KNUCKLE 3:y=0.5,from=8",
    ];
    for text in specs {
        let run = rig(&[text], 0.0, 1);
        let change = rms_difference(
            &numbers(&file(&run, "marks_measured.csv"), 3),
            &numbers(&marks, 3),
        );
        let turned = rms_difference(&numbers(&file(&run, "wheel.csv"), 1), &numbers(&wheel, 1));
        println!("{text}: marks {change:.4} mm rms, wheel {turned:.4}");
        assert!(change > 0.005, "{text} moves the marks by {change}");
        assert!(change < 20.0, "{text} moves the marks by {change}");
        assert_eq!(run.truth, format!("{text}\n"));
        for (path, bytes) in &run.files {
            let cause = text.split('@').next().unwrap();
            assert!(
                !String::from_utf8_lossy(bytes).contains(cause),
                "{path:?} tells"
            );
        }
    }
    let run = rig(&["channel-fault@height:gain=1.1,offset=2"], 0.0, 1);
    let (faulty, good) = (
        numbers(&file(&run, "readings.csv"), 1),
        numbers(&file(&exact, "readings.csv"), 1),
    );
    assert!((faulty[0] - (1.1 * good[0] + 2.0)).abs() < 1e-6 * good[0].abs());
    assert_eq!(faulty[1], good[1]);
}

/// Checks laws that differ from the assumed ones: in a limit they agree with the assumed law, and elsewhere they differ.
#[test]
fn other_laws_meet_the_assumed_ones_in_a_limit() {
    let marks = |spec: &str| numbers(&file(&rig(&[spec], 0.0, 1), "marks_measured.csv"), 3);
    let pairs = [
        (
            "link-compliance@PART/6:stiffness=8000",
            [",rated=1e9", ",rated=1000"],
        ),
        (
            "body-compliance@JOINT/5:stiffness=5000",
            [",x=1,y=1,z=1,rated=1e9", ",y=0.5"],
        ),
        (
            "bushing-coupling@BUSHING/2:xy=400",
            [",reach=1e6", ",reach=0.5"],
        ),
        ("frame-drift@case 7:x=0.2", [",creep=0", ",creep=1"]),
    ];
    for (assumed, [limit, other]) in pairs {
        let plain = marks(assumed);
        let apart = |more: &str| rms_difference(&plain, &marks(&format!("{assumed}{more}")));
        assert!(apart(limit) < 1e-6, "{assumed}{limit}: {}", apart(limit));
        assert!(apart(other) > 1e-3, "{assumed}{other}: {}", apart(other));
    }
    // An error that grows with a load has its full size at the largest load, and vanishes without load. Cases 6 and 9 have 4000 N of lateral
    // force in opposite directions, cases 1 to 5 have none.
    let nothing = numbers(&file(&rig(&[], 0.0, 1), "marks_measured.csv"), 3);
    let per_case = nothing.len() / 13;
    for assumed in [
        "load-gain@lateral:gain=1.05",
        "load-crosstalk@SFORCE/3<-lateral:fraction=0.05",
    ] {
        let (whole, grown) = (marks(assumed), marks(&format!("{assumed},law=growing")));
        let apart = |a: &[f64], b: &[f64], case: usize| {
            let of = (case - 1) * per_case..case * per_case;
            rms_difference(&a[of.clone()], &b[of])
        };
        for case in [6, 9] {
            assert!(
                apart(&whole, &grown, case) < 1e-6,
                "{assumed} in case {case}"
            );
            assert!(apart(&nothing, &grown, case) > 1e-3);
        }
        assert!(apart(&nothing, &grown, 1) < 1e-6, "{assumed} in case 1");
    }
    // Half of the shift of the contact point moves the wheel about half as far.
    let (whole, half) = (
        marks("load-point-error@MARKER/19:x=2"),
        marks("load-point-error@MARKER/19:x=1"),
    );
    let grown = marks("load-point-error@MARKER/19:x=2,law=growing");
    let between = |k: usize| {
        let (low, high) = (half[k].min(whole[k]) - 1e-4, half[k].max(whole[k]) + 1e-4);
        (low..=high).contains(&grown[k])
    };
    assert!((0..grown.len()).all(between));
    assert!(rms_difference(&grown, &half) > 1e-3 && rms_difference(&grown, &whole) > 1e-3);
}

#[test]
fn friction_depends_on_the_order_of_the_loads() {
    // Case 3 reaches 4500 N from below; if the rig applies case 5 first, from above. Only the travel of the strut follows the vertical load
    // monotonically. A bushing of the arms reverses near the design position.
    let spec = "dry-friction@JOINT/3:force=100,stiffness=500";
    let at_case_3 = |reorder: bool, effects: &[&str]| {
        let folder = folder();
        if reorder {
            replace(folder.path(), "load_cases.csv", "3,4500,0,0\n", "");
            replace(
                folder.path(),
                "load_cases.csv",
                "5,7500,0,0\n",
                "5,7500,0,0\n3,4500,0,0\n",
            );
        }
        let effects = effects
            .iter()
            .map(|text| EffectSpec::parse(text).unwrap())
            .collect();
        let options = RigOptions {
            seed: 1,
            sigma: Some(0.0),
            effects,
            ..RigOptions::default()
        };
        let run = virtual_rig(folder.path(), &options).unwrap();
        let text = file(&run, "marks_measured.csv");
        let rows: Vec<&str> = text.lines().filter(|row| row.starts_with("3,")).collect();
        numbers(&format!("header\n{}", rows.join("\n")), 3)
    };
    assert!(rms_difference(&at_case_3(false, &[]), &at_case_3(true, &[])) < 1e-8);
    let loop_width = rms_difference(&at_case_3(false, &[spec]), &at_case_3(true, &[spec]));
    // From one friction limit to the other, the strut carries 200 N more, against a wheel rate of about 40 N/mm.
    println!("loop {loop_width:.4}");
    assert!((1.0..8.0).contains(&loop_width), "{loop_width}");
    // If the same loads are applied again, nothing moves.
    assert!(rms_difference(&at_case_3(true, &[spec]), &at_case_3(true, &[spec])) < 1e-9);
}

#[test]
fn the_state_before_the_first_case_is_what_the_effect_says() {
    // The friction builds up over 33 mm of travel, so its initial state matters in the first case. Once the slider has moved through in one
    // direction, as at 7500 N, the initial state has no effect.
    let marks = |start: f64| {
        let spec = format!("dry-friction@JOINT/3:force=100,stiffness=3,start={start}");
        let text = file(&rig(&[&spec], 0.0, 1), "marks_measured.csv");
        let of_case = |case: &str| {
            let rows: Vec<&str> = text.lines().filter(|row| row.starts_with(case)).collect();
            numbers(&format!("header\n{}", rows.join("\n")), 3)
        };
        (of_case("1,"), of_case("5,"))
    };
    let (rest, pushed, pulled) = (marks(0.0), marks(1.0), marks(-1.0));
    let differs = |a: &[f64], b: &[f64]| rms_difference(a, b);
    assert!(differs(&pushed.0, &pulled.0) > 0.1);
    assert!(differs(&rest.1, &pushed.1) < 1e-6 && differs(&rest.1, &pulled.1) < 1e-6);
}

#[test]
fn what_is_outside_the_catalogue_can_be_planted_too() {
    let exact = numbers(&file(&rig(&[], 0.0, 1), "marks_measured.csv"), 3);
    for text in [
        "creep@BUSHING/2.K.1:rate=0.05",
        "part-flexibility@PART/4:marker=12,stiffness=2e8",
        "part-flexibility@PART/4:marker=12,stiffness=1e7,mode=twist",
        "asymmetric-friction@BUSHING/2.K.1:force=300,back=50,stiffness=4000",
        "thermal-drift@rig:growth=2e-4",
        "marks-exchanged@KNUCKLE<->ROD:from=9,mark=2",
    ] {
        let run = rig(&[text], 0.0, 1);
        let marks = numbers(&file(&run, "marks_measured.csv"), 3);
        let change = rms_difference(&marks, &exact);
        println!("{text}: {change:.4} mm rms");
        assert!(change > 0.005, "{text} moves the marks by {change}");
        let cause = text.split('@').next().unwrap();
        assert!(outside_causes().any(|known| known == cause));
        assert!(causes().all(|known| known != cause));
    }
    assert_eq!((causes().count(), outside_causes().count()), (18, 6));
}

#[test]
fn creep_and_drift_go_on_when_the_loads_do_not() {
    // Cases 3 and 14 have the same loads, so only a drift over time distinguishes them.
    let folder = folder();
    let path = folder.path().join("load_cases.csv");
    let loads = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, loads + "14,4500,0,0\n").unwrap();
    let apart = |effect: &str| {
        let effects = vec![EffectSpec::parse(effect).unwrap()];
        let options = RigOptions {
            sigma: Some(0.0),
            effects,
            ..RigOptions::default()
        };
        let text = file(
            &virtual_rig(folder.path(), &options).unwrap(),
            "marks_measured.csv",
        );
        let of_case = |case: &str| {
            let rows: Vec<&str> = text.lines().filter(|row| row.starts_with(case)).collect();
            numbers(&format!("header\n{}", rows.join("\n")), 3)
        };
        rms_difference(&of_case("3,"), &of_case("14,"))
    };
    assert!(apart("progressive-stiffness@BUSHING/2.K.1:cubic=300") < 1e-6);
    assert!(apart("creep@BUSHING/2.K.1:rate=0.05") > 0.01);
    // Drift of 11 of 13 steps of 2e-4, at about 600 mm from the origin.
    let drift = apart("thermal-drift@rig:growth=2e-4");
    assert!((0.02..0.12).contains(&drift), "{drift}");
}

#[test]
fn tolerances_have_their_sizes_and_the_folder_tells_only_what_a_data_sheet_would() {
    let folder = folder();
    let options = RigOptions {
        seed: 3,
        sigma_on_parts: Some(0.02),
        tolerances: Tolerances::parse("hardpoints=0.1,load_gain=0.003").unwrap(),
        programme: Some(LoadTable::Table2),
        ..RigOptions::default()
    };
    let run = virtual_rig(folder.path(), &options).unwrap();
    assert!(file(&run, "study.toml").contains("sigma_on_parts = 0.02"));
    assert_eq!(file(&run, "load_cases.csv").lines().count(), 18);
    assert!(file(&run, "load_cases.csv").contains("2,5980,0,0\n"));
    let deck = std::fs::read_to_string(folder.path().join("model.adm")).unwrap();
    assert_eq!(file(&run, "model.adm"), deck);
    // The first session has an error of 0.02 mm in 60 coordinates; its rms is known to 9 percent.
    let listed = numbers(&file(&run, "marks_on_parts.csv"), 2);
    let true_list = std::fs::read_to_string(folder.path().join("marks_on_parts.csv")).unwrap();
    let off = rms_difference(&listed, &numbers(&true_list, 2));
    assert!((off / 0.02 - 1.0).abs() < 0.3, "{off}");
    // Errors of hardpoints and gains move the marks by more than the noise, but by less than a wrong deck would.
    let exact = |list: &str| {
        let options = RigOptions {
            seed: 3,
            sigma: Some(0.0),
            tolerances: Tolerances::parse(list).unwrap(),
            ..RigOptions::default()
        };
        numbers(
            &file(
                &virtual_rig(folder.path(), &options).unwrap(),
                "marks_measured.csv",
            ),
            3,
        )
    };
    let plain = exact("");
    let lists = "hardpoints=0.1 parts=0.1 assembly_offset=0.1 bushing_axis_deg=2 preload=0.003 load_gain=0.003 load_direction_deg=0.2 \
                 marks_on_parts=0.05 pose=0.05 pose_deg=0.03 alignment=0.05 alignment_deg=0.005 mount=0.05 mount_deg=0.005 frame=0.05 frame_deg=0.005";
    for list in lists.split(' ') {
        let moved = rms_difference(&exact(list), &plain);
        assert!((0.005..1.0).contains(&moved), "{list}: {moved}");
    }
    // There are 195 numbers (13 cases, 5 parts, 3 coordinates), so the rms is known to 5 percent. The marks move rigidly with their parts.
    let posed = exact("pose=0.05");
    let moved = rms_difference(&posed, &plain);
    assert!((moved / 0.05 - 1.0).abs() < 0.25, "{moved}");
    for k in 0..3 {
        assert!((posed[k] - plain[k] - (posed[k + 3] - plain[k + 3])).abs() < 1e-8);
    }
    // The frame moves all marks of a case together.
    let framed = exact("frame=0.05");
    let of_a_case = plain.len() / 13;
    for k in 0..of_a_case {
        let shift = |at: usize| framed[at] - plain[at];
        assert!((shift(k) - shift(k % 3)).abs() < 1e-8);
        assert!((shift(k) - shift(of_a_case + k)).abs() > 1e-6);
    }
    // There are sixty mark coordinates on the parts, the same in every case.
    let on_parts = rms_difference(&exact("marks_on_parts=0.05"), &plain);
    assert!((on_parts / 0.05 - 1.0).abs() < 0.4, "{on_parts}");
}

#[test]
fn effects_that_sit_nowhere_are_refused() {
    let folder = folder();
    for text in [
        "dry-friction@BUSHING/9.K.1:force=1,stiffness=1",
        "dry-friction@BUSHING/2:force=1,stiffness=1",
        "dry-friction@BUSHING/2.K.1:force=1",
        "rust@BUSHING/2:x=1",
        "hardpoint-error@MARKER/7:w=1,x=1",
        "frame-drift@case 99:x=1",
        "mark-outlier@case 7 KNUCKLE 9:x=1",
        "channel-fault@depth:gain=2",
        "body-compliance@JOINT/1:stiffness=100",
    ] {
        let effects = vec![EffectSpec::parse(text).unwrap()];
        let options = RigOptions {
            seed: 1,
            sigma: Some(0.0),
            effects,
            ..RigOptions::default()
        };
        let why = virtual_rig(folder.path(), &options).unwrap_err();
        assert_eq!(why[0].code.as_str(), "bad-effect", "{text}: {why:?}");
    }
}

/// Checks that the recorded truth is complete: the drawn errors, planted again one by one, give the same readings.
#[test]
fn the_truth_of_tolerances_plants_them_again() {
    let folder = folder();
    let options = RigOptions {
        seed: 9,
        sigma: Some(0.0),
        tolerances: Tolerances::parse(
            "hardpoints=0.3,assembly_offset=0.1,bushing_axis_deg=0.2,preload=0.003,load_gain=0.005,load_direction_deg=0.2",
        )
        .unwrap(),
        scatter: Scatter::parse("outliers=3,outlier_size=2").unwrap(),
        ..RigOptions::default()
    };
    let drawn = virtual_rig(folder.path(), &options).unwrap();
    assert_eq!(drawn.truth.matches("mark-outlier@").count(), 3);
    let effects = EffectSpec::parse_list(&drawn.truth).unwrap();
    let again = RigOptions {
        sigma: Some(0.0),
        effects,
        ..RigOptions::default()
    };
    let again = virtual_rig(folder.path(), &again).unwrap();
    let marks = |run: &RigRun| numbers(&file(run, "marks_measured.csv"), 3);
    // Outliers are applied last in both runs, so the readings agree to the digits of the file.
    assert!(rms_difference(&marks(&drawn), &marks(&again)) < 1e-7);
}

/// Checks noise by Student's t with three degrees of freedom: its quantiles are those of the distribution. The folder states the declared noise.
#[test]
fn heavy_tails_and_a_wrong_declaration() {
    let folder = folder();
    let run = |scatter: &str, sigma| {
        let options = RigOptions {
            seed: 4,
            sigma,
            scatter: Scatter::parse(scatter).unwrap(),
            ..RigOptions::default()
        };
        virtual_rig(folder.path(), &options).unwrap()
    };
    let marks = |run: &RigRun| numbers(&file(run, "marks_measured.csv"), 3);
    let plain = marks(&run("", Some(0.0)));
    let noisy = run("tails=3,declared=0.5", Some(0.05));
    assert!(file(&noisy, "study.toml").contains("sigma = 0.025"));
    let mut off: Vec<f64> = marks(&noisy)
        .iter()
        .zip(&plain)
        .map(|(a, b)| (a - b).abs() / 0.05)
        .collect();
    off.sort_by(f64::total_cmp);
    let quantile = |p: f64| off[(p * off.len() as f64) as usize];
    // |t| of three degrees of freedom: median 0.765, 95 percent below 3.18 (normal: 0.674 and 1.96).
    assert!(
        (quantile(0.5) / 0.765 - 1.0).abs() < 0.12,
        "{}",
        quantile(0.5)
    );
    assert!(
        (quantile(0.95) / 3.18 - 1.0).abs() < 0.25,
        "{}",
        quantile(0.95)
    );
}

/// Checks that a moved hardpoint moves on both parts, as in a deck in which both markers of the joint were edited by hand.
#[test]
fn a_point_moves_on_all_parts_that_meet_there() {
    let folder = folder();
    let marks = |folder: &std::path::Path, effects: &[&str]| {
        let effects = effects.iter().map(|text| EffectSpec::parse(text));
        let options = RigOptions {
            sigma: Some(0.0),
            effects: effects.collect::<Result<_, _>>().unwrap(),
            ..RigOptions::default()
        };
        let run = virtual_rig(folder, &options).unwrap();
        numbers(&file(&run, "marks_measured.csv"), 3)
    };
    let plain = marks(folder.path(), &[]);
    let effect = |form: &str| format!("hardpoint-error@MARKER/15:form={form},x=0.5,z=2");
    let point = marks(folder.path(), &[&effect("point")]);
    let part = marks(folder.path(), &[&effect("part")]);
    // The inner joint of the tie rod has MARKER/16 on ground and MARKER/15 on the tie rod, whose axes are rotated by 90, 3, 0 degrees (body
    // 3-1-3).
    let (s, c) = 3f64.to_radians().sin_cos();
    let (x, z) = (0.5, 2.0);
    let own = [0.0, z * s - x * c, x * s + z * c];
    let deck = std::fs::read_to_string(folder.path().join("model.adm")).unwrap();
    let inner = "MARKER/15\n, PART = 6\n, QP = 0.0, 0.0, 0.0";
    let base = "MARKER/16\n, PART = 1\n, QP = 130.0, -345.0, 232.0";
    assert!(deck.contains(inner) && deck.contains(base));
    let [a, b, c] = own;
    let edited = deck
        .replace(
            inner,
            &format!("MARKER/15\n, PART = 6\n, QP = {a:.12}, {b:.12}, {c:.12}"),
        )
        .replace(base, "MARKER/16\n, PART = 1\n, QP = 130.5, -345.0, 234.0");
    std::fs::write(folder.path().join("model.adm"), edited).unwrap();
    let by_hand = marks(folder.path(), &[]);
    assert!(rms_difference(&point, &by_hand) < 1e-6);
    assert!(rms_difference(&point, &plain) > 0.05);
    assert!(rms_difference(&point, &part) > 0.05);
}

/// Checks a hardpoint at which a strut slides in the carrier: the line of motion moves on both parts, and so does the spring seat there.
#[test]
fn a_point_of_a_sliding_joint_takes_its_line_along() {
    let folder = folder();
    let deck = std::fs::read_to_string(folder.path().join("model.adm")).unwrap();
    let marks = |effects: &[String]| {
        let effects = effects.iter().map(|text| EffectSpec::parse(text));
        let options = RigOptions {
            sigma: Some(0.0),
            effects: effects.collect::<Result<_, _>>().unwrap(),
            ..RigOptions::default()
        };
        let run = virtual_rig(folder.path(), &options).unwrap();
        numbers(&file(&run, "marks_measured.csv"), 3)
    };
    assert!(deck.contains("JOINT/3\n, CYLINDRICAL\n, I = 11\n, J = 12"));
    let point = |id: u32| vec![format!("hardpoint-error@MARKER/{id}:form=point,y=1")];
    // MARKER/12 (strut on the carrier) and MARKER/17 (spring seat) are one hardpoint, which either address denotes.
    assert!(rms_difference(&marks(&point(12)), &marks(&point(17))) < 1e-9);
    let plain = marks(&[]);
    assert!(rms_difference(&marks(&point(12)), &plain) > 0.005);
    // If the point moves on the carrier alone, the rod tilts towards the line of the carrier.
    let alone = vec!["hardpoint-error@MARKER/12:y=0.98".to_string()];
    let (with, without) = (marks(&point(12)), marks(&alone));
    assert!(rms_difference(&with, &without) > 0.05);
}
