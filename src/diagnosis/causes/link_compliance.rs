//! `link-compliance`: a part deforms along the line through its two joints.
//!
//! The part is split at one of its ends by a bushing that yields only along the line. Each end is a separate candidate; the positions of the
//! marks distinguish the two.

use admire_solver::mechanics::{Mat3, Vec3, psi_theta_phi};
use admire_syntax::Address;

use super::super::candidate_effect::{
    CandidateEffect, Change, EffectParameter, Parametrisation, Sensitivity, Term,
};
use super::super::cause::Cause;
use super::super::operating_points::OperatingPoints;
use crate::settings::{RIGID_STIFFNESS_N_PER_MM, SPLIT_STIFFNESS_N_PER_MM};

/// End of a movable part with exactly two attachments.
pub(super) struct LinkEnd {
    /// Id of the part.
    pub part: u32,
    /// Name of the end: `first end` or `second end`.
    pub form: &'static str,
    /// Id of the marker of the part at this end.
    pub marker: u32,
    /// Position of the end in the axes of the part.
    place: Vec3,
    /// Unit vector along the line, pointing away from the other end, in the axes of the part.
    outward: Vec3,
    /// The vector `outward` in the axes in which the marker's QP is given.
    written: Vec3,
    /// Axial force in each case, positive in tension.
    pub tension: Vec<f64>,
}

/// Returns both ends of every movable part with exactly two attachments.
pub(super) fn link_ends(survey: &OperatingPoints<'_>) -> Vec<LinkEnd> {
    let mut out = Vec::new();
    for (part, body) in survey.model.parts.iter().enumerate() {
        let part = admire_solver::model::PartIx(part);
        let ends = survey.attachments(part);
        if Some(part) == survey.model.ground() || ends.len() != 2 {
            continue;
        }
        let place = |end: usize| survey.model.markers[ends[end].marker.0].qp;
        let line = place(1) - place(0);
        if line.norm() < 1e-6 {
            continue;
        }
        for (end, form) in ["first end", "second end"].into_iter().enumerate() {
            let outward: Vec3 = line.normalize() * if end == 1 { 1.0 } else { -1.0 };
            let tension = (0..survey.cases())
                .map(|case| {
                    let pose = survey.pose(case, part);
                    ends[end].force[case].dot(&(pose.R * outward))
                })
                .collect();
            out.push(LinkEnd {
                part: body.header.id,
                form,
                marker: survey.marker_id(ends[end].marker),
                place: place(end),
                outward,
                written: survey.model.markers[ends[end].marker.0].as_written(&outward),
                tension,
            });
        }
    }
    out
}

impl LinkEnd {
    /// Returns the changes of the marker's QP coordinates in each case, if the end moves outward by `by(tension)`.
    pub(super) fn moved(&self, by: impl Fn(f64) -> f64) -> Vec<(Address, Vec<f64>)> {
        let column = |k: usize| {
            let shift = self.tension.iter().map(|n| by(*n) * self.written[k]);
            let slot = Address::of_argument("MARKER", self.marker, "QP", Some(k + 1));
            (slot, shift.collect())
        };
        (0..3).map(column).collect()
    }

    /// Splits the end off into a new part. A bushing with its z axis along the line connects the new part to the old part; it has the
    /// stiffness `stiffness` along the line and is rigid across it. Returns the ids of the bushing and of its two markers, and the changes
    /// of the deck.
    pub(super) fn split(
        &self,
        survey: &OperatingPoints<'_>,
        stiffness: f64,
    ) -> (u32, [u32; 2], Vec<Change>) {
        let axis = self.outward;
        let x = if axis.x.abs() < 0.8 {
            Vec3::x()
        } else {
            Vec3::y()
        };
        let y = axis.cross(&x).normalize();
        let R = Mat3::from_columns(&[y.cross(&axis), y, axis]);
        let rigid = RIGID_STIFFNESS_N_PER_MM * survey.newton() / survey.millimetre();
        let stiffnesses = [rigid, rigid, stiffness];
        survey.split(
            self.part,
            self.marker,
            self.place,
            psi_theta_phi(&R),
            stiffnesses,
        )
    }
}

/// Adds candidates for the compliance of every movable part with exactly two attachments, one at each end.
pub(super) fn hypotheses(survey: &OperatingPoints<'_>, out: &mut Vec<CandidateEffect>) {
    let per_length = survey.newton() / survey.millimetre();
    for end in link_ends(survey) {
        let (bushing, _, changes) = end.split(survey, SPLIT_STIFFNESS_N_PER_MM * per_length);
        out.push(CandidateEffect {
            cause: Cause::LinkCompliance,
            address: format!("PART/{}", end.part),
            members: Vec::new(),
            side: "",
            form: end.form,
            numbers: vec![EffectParameter {
                column: Sensitivity::PerCase(end.moved(|n| n)),
                ..EffectParameter::new(
                    "compliance",
                    survey.priors().link_compliance_mm_per_n / per_length,
                    Parametrisation::Compliance(vec![Address::of_argument(
                        "BUSHING",
                        bushing,
                        "K",
                        Some(3),
                    )]),
                )
            }],
            ln_prior: 0.0,
            one_sided: true,
            changes,
            memory: None,
            term: Term::Main,
            joint_with: None,
        });
    }
}
