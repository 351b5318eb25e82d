use std::io::{self, Write};

use admire_syntax::units::Units;

use super::fortran::{exponential, line_of, title_line, unit_code};
use super::{StepKind, Timestamp};

/// Behind the head; the frame that follows it has no label: the model as it was read.
pub(super) const INPUT: f64 = -9.999_99e5;

/// The label of a frame that is a static solution, in place of a time.
pub(super) const STATIC: f64 = -5.555_55e5;

/// A marker in a graphics file.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct GraphicsMarker {
    /// Id of the marker.
    pub id: i64,
    /// Id of its part.
    pub part: i64,
    /// Position on the part.
    pub position: [f64; 3],
    /// PSI, THETA, PHI on the part, radians.
    pub angles: [f64; 3],
}

/// A joint in a graphics file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct GraphicsJoint {
    /// Id of the joint.
    pub id: i64,
    /// Ids of its I and J markers.
    pub markers: [i64; 2],
}

/// A drawing that moves by itself, in a graphics file. Shapes that are rigid on their parts (CYLINDER, ELLIPSOID, ...) are in the dataset
/// alone.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum GraphicsShape {
    /// The arrow of a force, whose size every frame has.
    Force {
        /// Id of the GRAPHICS statement.
        id: i64,
        /// Id of the marker it begins at.
        marker: i64,
    },
    /// A spring and damper.
    Spring {
        /// Id of the GRAPHICS statement.
        id: i64,
        /// Ids of its I and J markers.
        markers: [i64; 2],
        /// SEG and COILS.
        counts: [i64; 2],
        /// DA, DB, DC, LA, LB, LC, LD.
        sizes: [f64; 7],
    },
}

impl GraphicsShape {
    const fn is_force(&self) -> bool {
        matches!(self, Self::Force { .. })
    }
}

/// What the head of a graphics file says.
#[derive(Clone, Debug, Default)]
pub struct GraphicsHead {
    /// Title of the model.
    pub title: String,
    /// Units of the model.
    pub units: Units,
    /// Id of the ground.
    pub ground: i64,
    /// Ids of the parts in the order of the frames, without ground.
    pub parts: Vec<i64>,
    /// Markers in the order of the dataset.
    pub markers: Vec<GraphicsMarker>,
    /// Joints; those whose markers are not in the list are left out.
    pub joints: Vec<GraphicsJoint>,
    /// Forces in the order of the frames, and springs.
    pub shapes: Vec<GraphicsShape>,
    /// X, Y, Z, PSI, THETA, PHI (radians) of each part as the model was read.
    pub input: Vec<[f64; 6]>,
}

/// Writes a `.gra` file (format A.G8, guide/formats.md 6.4): frames of part positions and of forces, each flushed.
#[derive(Debug)]
pub struct GraphicsWriter<W: Write> {
    output: W,
    parts: usize,
    forces: usize,
}

impl<W: Write> GraphicsWriter<W> {
    /// Writes the head and the frame of the model as it was read.
    ///
    /// # Errors
    /// When the output cannot be written, or has another number of poses than of parts.
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

    /// Writes one frame: X, Y, Z, PSI, THETA, PHI (radians) of each part, and force and torque of each force in ground axes, in the order
    /// of the head. A lone static solution has a label in place of its time.
    ///
    /// # Errors
    /// `InvalidInput` when there are not as many as parts and forces; otherwise when the output cannot be written.
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
                "{} poses for {} parts, {} loads for {} forces",
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

    /// Gives the output back.
    pub fn finish(self) -> W {
        self.output
    }
}

/// Kinds of drawings, by their place in the alphabet among ARC, BOX, CIRCLE, CYLINDER, FORCE, FRUSTUM, OUTLINE, SPDP.
const FORCE: i64 = 5;
const SPRING: i64 = 8;

impl GraphicsHead {
    fn write(&self, when: Timestamp, text: &mut Vec<u8>) -> io::Result<()> {
        // Markers name their part, joints and drawings their markers, by place in the list, from 1.
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
            // Five columns, or more: two numbers never become one.
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
        // Forces first: the kinds are in the order of their numbers.
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
