use super::scene::Role;

/// Drawing style of a series.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SeriesStyle {
    /// A line through the points.
    Line,
    /// A dashed line.
    Dashed,
    /// Points only.
    Points,
    /// A line with its points.
    LinePoints,
}

/// Series of a chart: a curve or a point cloud.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name of the series in the legend.
    pub name: String,
    /// Points as pairs of x and y. Points that are not finite are omitted.
    pub points: Vec<(f64, f64)>,
    /// Drawing style of the series.
    pub mark: SeriesStyle,
    /// Role that determines the colour; `None` for a colour by position in the chart.
    pub role: Option<Role>,
}

impl Series {
    /// Creates a series without a role.
    pub fn new(name: &str, mark: SeriesStyle, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.to_string(),
            points,
            mark,
            role: None,
        }
    }

    /// Creates the series of the identified model with which an extended model is compared. The line is dashed to distinguish the two models.
    pub fn before(points: Vec<(f64, f64)>) -> Self {
        Self {
            mark: SeriesStyle::Dashed,
            ..Self::of(Role::Identified, points)
        }
    }

    /// Creates the series of a role, which determines name, style and colour.
    pub fn of(role: Role, points: Vec<(f64, f64)>) -> Self {
        let mark = match role {
            Role::Measured => SeriesStyle::Points,
            Role::Given => SeriesStyle::Dashed,
            Role::Model | Role::Identified | Role::Extended => SeriesStyle::Line,
        };
        Self {
            role: Some(role),
            ..Self::new(role.name(), mark, points)
        }
    }
}
