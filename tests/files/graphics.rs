//! Tests of ADAMS graphics files.

use admire_results::{
    GraphicsFile, GraphicsHead, GraphicsJoint, GraphicsMarker, GraphicsShape, GraphicsWriter,
    StepKind, Timestamp,
};
use admire_syntax::text::Source;

use super::results::units;
use crate::common::shared;

/// Checks that a real graphics file with joints, springs and six force arrows is reproduced byte for byte. The frames come from the reader,
/// the head from known line numbers of the file.
#[test]
fn a_real_graphics_file_with_forces_is_read_and_comes_out_again() {
    let Some(path) = shared("real-car-files/handspring.gra") else {
        return;
    };
    let text = std::fs::read_to_string(path).unwrap();
    let read = GraphicsFile::parse(&Source::new("handspring.gra", text.as_bytes()));
    // The file has Windows line ends.
    let text = text.replace("\r\n", "\n");
    assert_eq!(read.diagnostics, []);
    let file = read.value;
    assert_eq!(file.parts, [2, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(file.forces, [70, 71, 72, 73, 81, 82]);
    // The co-simulation has 28 steps. Its initial state appears twice: after the initial conditions and with the first step.
    assert_eq!(file.times.len(), 30);
    assert_eq!((file.times[1], file.times[29]), (0.0, 0.14));
    assert_eq!(file.poses[29][0][1], 0.14326);
    assert_eq!(file.loads[29][2][..3], [2.12619e-11, -6.00207, 1.56255e-5]);
    // The two forces of the pair are equal and opposite.
    assert_eq!(file.loads[29][3][1], 6.00207);

    let lines: Vec<Vec<f64>> = text
        .lines()
        .map(|line| {
            line.split_whitespace()
                .filter_map(|n| n.parse().ok())
                .collect()
        })
        .collect();
    let whole = |line: &[f64]| line.iter().map(|n| *n as i64).collect::<Vec<i64>>();
    let six = |line: &[f64]| -> [f64; 6] { std::array::from_fn(|at| line[at]) };
    let markers: Vec<GraphicsMarker> = (0..61)
        .map(|at| {
            let (first, second) = (&lines[21 + 2 * at], &lines[22 + 2 * at]);
            GraphicsMarker {
                id: first[0] as i64,
                part: first[1] as i64,
                position: [first[2], first[3], first[4]],
                angles: [second[0], second[1], second[2]],
            }
        })
        .collect();
    let id = |place: i64| markers[place as usize - 1].id;
    let joints = lines[13..21]
        .iter()
        .map(|line| whole(line))
        .map(|n| GraphicsJoint {
            id: n[0],
            markers: [id(n[1]), id(n[2])],
        });
    let forces = (0..6).map(|at| GraphicsShape::Force {
        id: lines[143 + 2 * at][0] as i64,
        marker: id(lines[144 + 2 * at][0] as i64),
    });
    let springs = (0..4).map(|at| {
        let line = &lines[155 + 3 * at..];
        let n = whole(&line[1]);
        let sizes: Vec<f64> = line[1][4..].iter().chain(&line[2]).copied().collect();
        GraphicsShape::Spring {
            id: line[0][0] as i64,
            markers: [id(n[0]), id(n[1])],
            counts: [n[2], n[3]],
            sizes: std::array::from_fn(|at| sizes[at]),
        }
    });
    let head = GraphicsHead {
        title: "ADAMS/View model name: MODEL_f".to_string(),
        units: units("NEWTON", "KILOGRAM", "METER"),
        ground: 1,
        parts: file.parts.clone(),
        joints: joints.collect(),
        shapes: forces.chain(springs).collect(),
        markers: markers.clone(),
        input: lines[168..177].iter().map(|line| six(line)).collect(),
    };
    // The date is 2016-08-10 19:39:59.
    let when = Timestamp::from_unix(1_470_857_999);
    let mut writer = GraphicsWriter::create(Vec::new(), when, &head).unwrap();
    for frame in 0..file.times.len() {
        let time = file.times[frame];
        let (poses, loads) = (&file.poses[frame], &file.loads[frame]);
        writer.frame(StepKind::Dynamic, time, poses, loads).unwrap();
    }
    let written = String::from_utf8(writer.finish()).unwrap();
    let differs = written.lines().zip(text.lines()).find(|(a, b)| a != b);
    assert_eq!(differs, None);
    assert_eq!(written.len(), text.len());
}
