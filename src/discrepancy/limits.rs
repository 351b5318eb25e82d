//! How far off a hardpoint has to be before it is named: what the readings cannot see is said.

use super::diagnosis::DetectionLimit;
use super::fit::Fitted;
use super::scan::first_member;
use super::subject::Subject;
use crate::tolerance::Group;

/// Millimetres a point may well be off, as the hypothesis has it.
const SD: f64 = 3.0;
/// Limits beyond so many millimetres are none.
const FAR: f64 = 50.0;

/// For each point and axis the error at which the cause is as probable as not, the others being off by the size of their group: with
/// `F` the information of the readings on the error, `V0 = 1/F + tau^2` and `V1 = V0 + v^2`,
/// `d^2 (1/V0 - 1/V1) = ln(V1/V0) - 2 ln(prior odds)`.
pub fn detection_limits(subject: &Subject<'_>, fitted: &Fitted) -> Vec<DetectionLimit> {
    let Some(tau) = fitted.sizes.of(Group::Hardpoints) else {
        return Vec::new();
    };
    let millimetre = subject.millimetre();
    let slab = SD * millimetre;
    let first = first_member(fitted);
    let points = &subject.layer.points;
    // Each point in all directions and along each one alone.
    let odds = super::causes::PRESENT / (4 * points.len()) as f64;
    let mut out = Vec::new();
    for point in points {
        let name = |marker: &crate::model::MarkerIx| {
            format!(
                "MARKER/{}",
                subject.problem.model.markers[marker.0].header.id
            )
        };
        let members: Vec<String> = point.markers.iter().map(name).collect();
        let limit = |member: usize| {
            let at = first + member;
            // What stands out has a prior of its own; its information is the same.
            let prior = fitted.priors[at].prior_sd(&fitted.sizes).powi(2);
            let information = 1.0 / fitted.posterior.covariance[(at, at)] - 1.0 / prior;
            if information <= 1e-6 / prior {
                return None;
            }
            let before = 1.0 / information + tau * tau;
            let after = before + slab * slab;
            let needed = libm::log(after / before) - 2.0 * libm::log(odds);
            let d = (needed / (1.0 / before - 1.0 / after)).sqrt() / millimetre;
            (d < FAR).then_some(d)
        };
        let axes = subject.layer.at(Group::Hardpoints, &members[0]);
        let mm: Vec<Option<f64>> = axes.map(limit).collect();
        if let [x, y, z] = mm[..] {
            out.push(DetectionLimit {
                address: members[0].clone(),
                members,
                mm: [x, y, z],
            });
        }
    }
    out
}
