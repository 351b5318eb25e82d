//! Lint that needs places and directions: what is wrong with the model at its design position.
//!
//! Knows how the model lies before anything moves, not how it is solved. What statements alone show is in `syntax::lint`.

mod bushing_angle;
mod implausible_units;
mod joint_aligned;
mod lost_torque;

pub use joint_aligned::Apart;
pub use joint_aligned::apart;

use super::{Header, MarkerIx, Model};
use crate::mechanics::Pose;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

/// Runs the rules over a model and the dataset it was made from. Complaints are in the order of their places in the file.
pub fn check(dataset: &Dataset, model: &Model) -> Vec<Diagnostic> {
    let design = Design { dataset, model };
    let mut found = Vec::new();
    bushing_angle::check(&design, &mut found);
    joint_aligned::check(&design, &mut found);
    lost_torque::check(&design, &mut found);
    implausible_units::check(&design, &mut found);
    found.sort_by_key(|diagnostic| diagnostic.labels.first().map(|label| label.span.start()));
    found
}

/// Torques that nothing feels.
pub fn lost_torques(dataset: &Dataset, model: &Model) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    lost_torque::check(&Design { dataset, model }, &mut found);
    found
}

/// What says that the numbers of a deck are in other units than its UNITS, if anything does: for commands that do not check, a
/// warning in any case.
pub fn implausible_units(dataset: &Dataset, model: &Model) -> Option<Diagnostic> {
    let mut found = Vec::new();
    implausible_units::check(&Design { dataset, model }, &mut found);
    let mut warning = found.pop()?;
    warning.severity = Severity::Warning;
    Some(warning)
}

/// The model at its design position.
struct Design<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
}

impl Design<'_> {
    /// Where a marker is in ground; `None` for floating ones and for bodies only real ADAMS places.
    fn pose(&self, marker: MarkerIx) -> Option<Pose> {
        self.model.marker_pose(marker)
    }

    /// A pair of markers, I and J.
    fn pair(&self, i: MarkerIx, j: MarkerIx) -> Option<(Pose, Pose)> {
        Some((self.pose(i)?, self.pose(j)?))
    }

    /// How an object is called, with its kind: `JOINT/3 (knuckle_ball)`.
    fn title(&self, kind: &str, header: &Header) -> String {
        let statement = &self.dataset.statements()[header.origin];
        match statement.view_name {
            Some(_) => format!("{kind}/{} ({})", header.id, header.name),
            None => format!("{kind}/{}", header.id),
        }
    }

    fn warning(&self, code: Code, header: &Header, message: String) -> Diagnostic {
        let statement = &self.dataset.statements()[header.origin];
        let span = match statement.id {
            Some((_, id)) => statement.keyword.join(id),
            None => statement.keyword,
        };
        Diagnostic::warning(code, message).label(self.dataset.source().name(), span, "")
    }
}
