//! `hardpoint-error`: a joint's or spring's connection point is not where the deck puts it.
//!
//! For a bushing the same is an assembly offset.

use crate::model::MarkerIx;

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX, number};

/// Millimetres a hardpoint may well be off.
const SD: f64 = 3.0;

/// Each marker of a joint, primitive or spring once: three displacements in the axes of its part; those of a spring also along its line.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    let model = survey.model;
    let joints = model
        .joints
        .iter()
        .map(|joint| (&joint.header, joint.i, joint.j));
    let primitives = model.primitives.iter().map(|p| (&p.header, p.i, p.j));
    let springs = model.springdampers.iter().map(|s| (&s.header, s.i, s.j));
    let mut seen = Vec::new();
    for (header, i, j) in joints.chain(primitives).chain(springs) {
        if !header.active {
            continue;
        }
        for marker in [i, j] {
            if seen.contains(&marker) {
                continue;
            }
            seen.push(marker);
            let id = model.markers[marker.0].header.id;
            let numbers = (0..3).map(|k| {
                let slot = number("MARKER", id, "QP", Some(k + 1));
                let sd = SD * survey.millimetre();
                Number::linear(SIX[k], sd, Column::Always(vec![(slot, 1.0)]))
            });
            out.push(Hypothesis::plain(
                Cause::HardpointError,
                format!("MARKER/{id}"),
                "",
                numbers.collect(),
            ));
        }
    }
    for spring in model.springdampers.iter().filter(|s| s.header.active) {
        along_the_line(survey, (spring.i, spring.j), out);
    }
}

/// The ends of a spring along its line at design, which is what a wrong preload looks like.
fn along_the_line(survey: &Survey<'_>, (i, j): (MarkerIx, MarkerIx), out: &mut Vec<Hypothesis>) {
    let model = survey.model;
    let place = |marker: MarkerIx| {
        let of = &model.markers[marker.0];
        model.parts[of.part.0].pose.point(&of.qp)
    };
    let line = place(i) - place(j);
    if line.norm() < 1e-6 * survey.millimetre() {
        return;
    }
    for marker in [i, j] {
        let of = &model.markers[marker.0];
        let id = of.header.id;
        let along = model.parts[of.part.0].pose.R.transpose() * line.normalize();
        let pairs = (0..3).map(|k| (number("MARKER", id, "QP", Some(k + 1)), along[k]));
        let sd = SD * survey.millimetre();
        out.push(Hypothesis::plain(
            Cause::HardpointError,
            format!("MARKER/{id}"),
            "along the line",
            vec![Number::linear("along", sd, Column::Always(pairs.collect()))],
        ));
    }
}
