//! Measuring frames that are not where they were: set up anew for each case, or going on from case to case.

use std::path::Path;

use admire::discrepancy::Verdict;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::axles::{Judged, copied, judge};

/// An axle of the independent simulator, whose marks are all seen from a frame that is off by a shift (mm) and a turn (rad) about the
/// origin in each case, by itself or on from the case before.
fn seen_from_elsewhere(
    name: &str,
    seed: u64,
    (shift, turn): (f64, f64),
    goes_on: bool,
) -> Option<Judged> {
    let folder = copied(name)?;
    move_frame(
        &folder.path().join(name).join("marks_measured.csv"),
        seed,
        (shift, turn),
        goes_on,
    );
    Some(judge(folder.path(), name))
}

fn move_frame(table: &Path, seed: u64, (shift, turn): (f64, f64), goes_on: bool) {
    let text = std::fs::read_to_string(table).unwrap();
    let mut lines = text.lines();
    let mut out = format!("{}\n", lines.next().unwrap());
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut case = String::new();
    let mut frame = [0.0; 6];
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        if fields[0] != case {
            case = fields[0].to_string();
            for (k, number) in frame.iter_mut().enumerate() {
                let step: f64 = StandardNormal.sample(&mut random);
                let before = if goes_on { *number } else { 0.0 };
                *number = before + step * if k < 3 { shift } else { turn };
            }
        }
        let [x, y, z] = [3, 4, 5].map(|k| fields[k].parse::<f64>().unwrap());
        let [dx, dy, dz, a, b, c] = frame;
        let seen = [
            x + dx + b * z - c * y,
            y + dy + c * x - a * z,
            z + dz + a * y - b * x,
        ];
        out += &fields[..3].join(",");
        for x in seen {
            out += &format!(",{x}");
        }
        out.push('\n');
    }
    std::fs::write(table, out).unwrap();
}

/// Nothing is wrong with the axle but usual tolerances.
#[test]
fn a_frame_set_up_anew_for_each_case_is_no_cause() {
    let found = seen_from_elsewhere("tolerances-2", 1, (0.05, 5e-5), false);
    let Some(judged) = found else {
        return;
    };
    assert_eq!(judged.diagnosis.verdict, Verdict::Consistent);
    assert!(judged.false_names.is_empty(), "{:?}", judged.false_names);
    let size = judged.diagnosis.tolerances["frame-shifts"].sd;
    assert!((0.025..0.1).contains(&size), "{size}");
    assert!(judged.held.0 + 2 >= judged.held.1, "{:?}", judged.held);
}

#[test]
fn a_cause_is_named_beside_a_frame_that_goes_on() {
    let found = seen_from_elsewhere("hardpoint-1", 2, (0.02, 2e-5), true);
    let Some(judged) = found else {
        return;
    };
    assert_eq!(judged.diagnosis.verdict, Verdict::Discrepancy);
    assert!(judged.named.iter().all(|named| *named));
    assert!(judged.false_names.is_empty(), "{:?}", judged.false_names);
}
