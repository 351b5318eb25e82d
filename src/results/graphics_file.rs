use std::io::{self, Write};

use admire_syntax::units::Units;

use super::fortran::{exponential, line_of, title_line, unit_code};
use super::{StepKind, Timestamp};

/// Label of the first frame of a graphics file, which shows the model as it was read. It is written in place of a time.
pub(super) const INPUT: f64 = -9.999_99e5;

/// Label of a frame that shows a static solution; it is written in place of a time.
pub(super) const STATIC: f64 = -5.555_55e5;

/// A marker in a graphics file.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct GraphicsMarker {
    /// Id of the marker.
    pub id: i64,
    /// Id of the part that carries the marker.
    pub part: i64,
    /// Position of the marker relative to the frame of the part, in units of the model.
    pub position: [f64; 3],
    /// Angles PSI, THETA, PHI of the marker relative to the frame of the part, in radians.
    pub angles: [f64; 3],
}

/// A joint in a graphics file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct GraphicsJoint {
    /// Id of the joint.
    pub id: i64,
    /// Ids of the joint's I and J markers.
    pub markers: [i64; 2],
}

/// A drawn shape that changes during the run. Shapes that are fixed to their parts (CYLINDER, ELLIPSOID, ...) are not in the file but in
/// the dataset.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum GraphicsShape {
    /// The arrow of a force. Each frame contains the force and torque.
    Force {
        /// Id of the GRAPHICS statement.
        id: i64,
        /// Id of the marker at which the arrow begins.
        marker: i64,
    },
    /// A spring-damper between two markers.
    Spring {
        /// Id of the GRAPHICS statement.
        id: i64,
        /// Ids of the I and J markers of the spring-damper.
        markers: [i64; 2],
        /// Values of the arguments SEG and COILS of the GRAPHICS statement.
        counts: [i64; 2],
        /// Values of the arguments DA, DB, DC, LA, LB, LC and LD of the GRAPHICS statement.
        sizes: [f64; 7],
    },
}

impl GraphicsShape {
    const fn is_force(&self) -> bool {
        matches!(self, Self::Force { .. })
    }
}

/// Content of the head of a graphics file.
#[derive(Clone, Debug, Default)]
pub struct GraphicsHead {
    /// Title of the model.
    pub title: String,
    /// Units of the model.
    pub units: Units,
    /// Id of the ground part.
    pub ground: i64,
    /// Ids of the parts except ground, in the order in which frames list their poses.
    pub parts: Vec<i64>,
    /// Markers, in the order of the dataset.
    pub markers: Vec<GraphicsMarker>,
    /// Joints of the model. A joint is not written if one of its markers is missing from `markers`.
    pub joints: Vec<GraphicsJoint>,
    /// Drawn shapes: force arrows, in the order in which frames list the forces, and springs.
    pub shapes: Vec<GraphicsShape>,
    /// X, Y, Z, PSI, THETA, PHI (radians) of each part, in the model as it was read.
    pub input: Vec<[f64; 6]>,
}

/// Writer of a graphics file `.gra` (format A.G8, guide/formats.md 6.4).
///
/// Each frame contains the poses of the parts and the forces. A frame is flushed as soon as it is written.
#[derive(Debug)]
pub struct GraphicsWriter<W: Write> {
    output: W,
    parts: usize,
    forces: usize,
}

impl<W: Write> GraphicsWriter<W> {
    /// Writes the head of the file and the first frame, which shows the model as it was read.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written, or if `head` does not contain exactly one input pose for each part.
    pub fn create(output: W, when: Timestamp, head: &GraphicsHead) -> io::Result<Self> {
        let mut text = Vec::new();
        head.write(when, &mut text)?;
        let mut writer = Self {
            output,
            parts: head.parts.len(),
            forces: head.shapes.iter().filter(|shape| shape.is_force()).count(),
        };
        let forces = vec![[0.0; 6]; writer.forces];
        writer.put(text, INPUT, &head.input, &forces)?;
        Ok(writer)
    }

    /// Writes one frame: X, Y, Z, PSI, THETA, PHI (radians) of each part, then force and torque of each force in ground axes.
    ///
    /// Parts and forces have the same order as in the head. A step of kind `Static` is written with a fixed label in place of its time.
    ///
    /// # Errors
    /// Returns `InvalidInput` if the number of poses or forces differs from the head. Returns another error if the output cannot be
    /// written.
    pub fn frame(
        &mut self,
        kind: StepKind,
        time: f64,
        poses: &[[f64; 6]],
        forces: &[[f64; 6]],
    ) -> io::Result<()> {
        let label = if kind == StepKind::Static {
            STATIC
        } else {
            time
        };
        self.put(Vec::new(), label, poses, forces)
    }

    fn put(
        &mut self,
        mut text: Vec<u8>,
        label: f64,
        poses: &[[f64; 6]],
        forces: &[[f64; 6]],
    ) -> io::Result<()> {
        if (poses.len(), forces.len()) != (self.parts, self.forces) {
            let message = format!(
                "the frame has {} poses for {} parts and {} loads for {} forces",
                poses.len(),
                self.parts,
                forces.len(),
                self.forces
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        text.extend_from_slice(line_of(&[label]).as_bytes());
        for six in poses.iter().chain(forces) {
            text.extend_from_slice(line_of(six).as_bytes());
        }
        self.output.write_all(&text)?;
        self.output.flush()
    }

    /// Returns the output, which is complete after each frame.
    pub fn finish(self) -> W {
        self.output
    }
}

/// Code of a force arrow. Codes are positions (from 1) in the list ARC, BOX, CIRCLE, CYLINDER, FORCE, FRUSTUM, OUTLINE, SPDP.
const FORCE: i64 = 5;
const SPRING: i64 = 8;

impl GraphicsHead {
    fn write(&self, when: Timestamp, text: &mut Vec<u8>) -> io::Result<()> {
        // References are 1-based positions: markers refer to positions in the list of parts, joints and shapes to positions in the list of
        // markers.
        let part = |id: i64| {
            let mut all = std::iter::once(&self.ground).chain(&self.parts);
            all.position(|other| *other == id).map(|at| at + 1)
        };
        let places: std::collections::BTreeMap<i64, usize> = self
            .markers
            .iter()
            .enumerate()
            .map(|(at, m)| (m.id, at + 1))
            .collect();
        let marker = |id: &i64| places.get(id).copied();
        let both = |[i, j]: [i64; 2]| Some((marker(&i)?, marker(&j)?));
        let joints: Vec<(i64, usize, usize)> = self
            .joints
            .iter()
            .filter_map(|joint| both(joint.markers).map(|(i, j)| (joint.id, i, j)))
            .collect();
        let forces = self.shapes.iter().filter(|shape| shape.is_force()).count();
        writeln!(
            text,
            " A.G8    {:<19}  {} {}",
            when.date_time(),
            unit_code(&self.units),
            exponential(1.0 / self.units.length.si, 21, 15)
        )?;
        text.extend_from_slice(title_line(&self.title).as_bytes());
        let counts = [
            self.parts.len() + 1,
            self.markers.len(),
            self.shapes.len(),
            0,
            joints.len(),
            0,
            0,
            0,
            forces,
        ];
        text.push(b' ');
        for count in counts {
            // A count is written in at least five columns; a blank separates longer counts.
            let gap = if count > 9999 { " " } else { "" };
            write!(text, "{gap}{count:>5}")?;
        }
        text.push(b'\n');
        for id in std::iter::once(&self.ground).chain(&self.parts) {
            writeln!(text, " {id:>10}{:>10}", 1)?;
        }
        for (id, i, j) in joints {
            writeln!(text, " {id:>10}{i:>10}{j:>10}")?;
        }
        for marker in &self.markers {
            write!(
                text,
                " {:>10}{:>10}",
                marker.id,
                part(marker.part).unwrap_or(1)
            )?;
            for x in marker.position {
                text.extend_from_slice(exponential(x, 13, 5).as_bytes());
            }
            writeln!(text, "{:>8}", 0)?;
            text.extend_from_slice(line_of(&marker.angles).as_bytes());
        }
        // Shapes are written in the order of their codes, so force arrows precede springs.
        let (forces, others): (Vec<_>, Vec<_>) = self.shapes.iter().partition(|s| s.is_force());
        for shape in forces.into_iter().chain(others) {
            match shape {
                GraphicsShape::Force { id, marker: on } => {
                    writeln!(text, " {id:>10}{FORCE:>10}{:>10}", 2)?;
                    writeln!(text, " {:>10}{:>10}", marker(&on).unwrap_or(0), 0)?;
                }
                GraphicsShape::Spring {
                    id,
                    markers,
                    counts: [segments, coils],
                    sizes,
                } => {
                    let (i, j) = both(markers).unwrap_or((0, 0));
                    writeln!(text, " {id:>10}{SPRING:>10}{:>10}", 11)?;
                    write!(text, "{i:>6}{j:>6}{segments:>6}{coils:>6}")?;
                    for (at, size) in sizes.iter().enumerate() {
                        let end = if at == 2 || at == 6 { "\n" } else { "" };
                        write!(text, "{}{end}", exponential(*size, 13, 5))?;
                    }
                }
            }
        }
        Ok(())
    }
}
