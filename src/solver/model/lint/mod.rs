//! Lint rules that need positions and directions: faults of the model in its design position.
//!
//! The rules use the model in its design position only; no solution is needed. Faults that are visible in the statements alone are reported
//! by `syntax::lint`.

mod bushing_angle;
mod implausible_units;
mod joint_aligned;
mod lost_torque;

pub use joint_aligned::MarkerGap;
pub use joint_aligned::apart;

use super::{Header, MarkerIx, Model};
use crate::mechanics::Pose;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

/// Runs the rules over a model and its dataset. The diagnostics are in the order of their positions in the file.
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

/// Returns warnings about torques that have no effect because they act on a POINT_MASS.
pub fn lost_torques(dataset: &Dataset, model: &Model) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    lost_torque::check(&Design { dataset, model }, &mut found);
    found
}

/// Returns a warning if the values of a deck are implausible in its stated UNITS. This function is meant for commands that do not run the
/// full check. The severity is always a warning.
pub fn implausible_units(dataset: &Dataset, model: &Model) -> Option<Diagnostic> {
    let mut found = Vec::new();
    implausible_units::check(&Design { dataset, model }, &mut found);
    let mut warning = found.pop()?;
    warning.severity = Severity::Warning;
    Some(warning)
}

/// Model at its design position, with its dataset.
struct Design<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
}

impl Design<'_> {
    /// Returns the pose of a marker in ground. Returns `None` for floating markers and for markers on bodies that only real ADAMS places.
    fn pose(&self, marker: MarkerIx) -> Option<Pose> {
        self.model.marker_pose(marker)
    }

    /// Returns the poses of a pair of markers I and J.
    fn pair(&self, i: MarkerIx, j: MarkerIx) -> Option<(Pose, Pose)> {
        Some((self.pose(i)?, self.pose(j)?))
    }

    /// Returns the kind, id and View name of an object for messages, for example `JOINT/3 (knuckle_ball)`.
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
