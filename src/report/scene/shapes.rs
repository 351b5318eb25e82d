use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_syntax::{Dataset, Statement};

/// Shape of a GRAPHICS statement, as lines in the frame of one part.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Shape {
    /// Index of the part in the model.
    pub part: usize,
    /// Polylines of the shape.
    pub lines: Vec<Vec<Vec3>>,
}

/// Number of sides of a drawn circle.
const SIDES: usize = 24;
/// Maximum number of shapes drawn for a deck; further shapes are omitted.
const MOST: usize = 1500;

/// Returns the shapes that can be drawn from the deck alone: OUTLINE, CIRCLE, ARC, CYLINDER, FRUSTUM, BOX and ELLIPSOID.
pub(super) fn shapes(dataset: &Dataset, model: &Model) -> Vec<Shape> {
    dataset
        .statements()
        .iter()
        .filter(|statement| statement.kind() == Some("GRAPHICS"))
        .filter_map(|statement| shape(statement, model))
        .filter(|shape| {
            let mut points = shape.lines.iter().flatten();
            points.all(|p| p.iter().all(|x| x.is_finite()))
        })
        .take(MOST)
        .collect()
}

fn shape(statement: &Statement, model: &Model) -> Option<Shape> {
    let marker = |id: f64| {
        let marker = &model.markers[model.marker(id as u32)?.0];
        let frame = Pose {
            p: marker.qp,
            R: marker.R,
        };
        (!marker.floating).then_some((marker.part.0, frame))
    };
    if statement.has("OUTLINE") {
        let ends: Vec<(usize, Pose)> = statement
            .numbers("OUTLINE")
            .iter()
            .filter_map(|id| marker(id.value))
            .collect();
        let part = ends.first()?.0;
        // An outline over several parts would change shape as the parts move. Only its points on the first part are drawn.
        let line = ends.iter().filter(|end| end.0 == part).map(|end| end.1.p);
        let lines = vec![line.collect()];
        return Some(Shape { part, lines });
    }
    let size = |name: &str| statement.first(name);
    if statement.has("BOX") {
        let (part, frame) = marker(size("CORNER")?)?;
        let extent = Vec3::new(size("X")?, size("Y")?, size("Z")?);
        let corner = |k: usize| {
            let share = Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
            frame.point(&extent.component_mul(&share))
        };
        let edges = (0..8_usize).flat_map(|k| [1, 2, 4].map(|bit| (k, k | bit)));
        let lines = edges
            .filter(|(from, to)| from != to)
            .map(|(from, to)| vec![corner(from), corner(to)]);
        return Some(Shape {
            part,
            lines: lines.collect(),
        });
    }
    let (part, frame) = marker(size("CM")?)?;
    // `radii` are the radii along x and y of the marker; `height` is the position along its z axis.
    let ring = |radii: [f64; 2], height: f64, extent: f64| -> Vec<Vec3> {
        (0..=SIDES)
            .map(|k| {
                let (sin, cos) = libm::sincos(extent * k as f64 / SIDES as f64);
                frame.point(&Vec3::new(radii[0] * cos, radii[1] * sin, height))
            })
            .collect()
    };
    let full = std::f64::consts::TAU;
    let lines = if statement.has("CIRCLE") {
        vec![ring([size("RADIUS")?; 2], 0.0, full)]
    } else if statement.has("ARC") {
        vec![ring(
            [size("RADIUS")?; 2],
            0.0,
            size("RANGLE").unwrap_or(full),
        )]
    } else if statement.has("CYLINDER") || statement.has("FRUSTUM") {
        let bottom = size("BOTTOM").or(size("RADIUS"))?;
        let top = size("TOP").or(size("RADIUS"))?;
        let length = size("LENGTH")?;
        let rings = [ring([bottom; 2], 0.0, full), ring([top; 2], length, full)];
        let sides = (0..4).map(|k| k * SIDES / 4);
        let sides: Vec<Vec<Vec3>> = sides.map(|k| vec![rings[0][k], rings[1][k]]).collect();
        rings.into_iter().chain(sides).collect()
    } else if statement.has("ELLIPSOID") {
        // The scales are diameters, because ADAMS scales a sphere of unit diameter.
        let half = [size("XSCALE")?, size("YSCALE")?, size("ZSCALE")?].map(|scale| scale / 2.0);
        let around = |a: usize, b: usize| -> Vec<Vec3> {
            (0..=SIDES)
                .map(|k| {
                    let (sin, cos) = libm::sincos(full * k as f64 / SIDES as f64);
                    let mut p = Vec3::zeros();
                    p[a] = half[a] * cos;
                    p[b] = half[b] * sin;
                    frame.point(&p)
                })
                .collect()
        };
        vec![around(0, 1), around(1, 2), around(2, 0)]
    } else {
        return None;
    };
    Some(Shape { part, lines })
}
