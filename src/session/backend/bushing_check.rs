//! Check of the bushing forces in a results file: they must follow from the BUSHING law at the poses in the same file.

use std::fmt;

use super::SweepRequest;
use admire_results::Catalogue;
use admire_solver::mechanics::{Mat3, Pose, Vec3};
use admire_solver::system::{ElementIx, Parameters, Scratch, Slot, State, System};
use admire_syntax::Address;

/// Axes in which a results file gives the forces of bushings. No public source documents these axes, so they are found by comparing
/// numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ForceFrame {
    /// Axes of ground.
    Ground,
    /// Axes of the J marker.
    J,
}

impl fmt::Display for ForceFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ground => "ground axes",
            Self::J => "the axes of the J marker",
        })
    }
}

/// Relative tolerance between the forces and angles in the file and the recomputed ones.
const AGREES: f64 = 1e-5;

/// Angle in rad beyond which angles are not compared: near half a turn, a rotation may be described by an angle of either sign.
const FAR: f64 = 1.5;

/// Recomputes the deflection, force and torque of every bushing from the poses in each output step, and compares them with the file.
pub(super) struct BushingCheck {
    system: System,
    parameters: Parameters,
    state: State,
    scratch: Scratch,
    bushings: Vec<Reported>,
    /// Parameter slots that the load cases change, each with its value in every case.
    per_case: Vec<(Slot, Vec<f64>)>,
    /// Rounding error of numbers in the file: half a unit of the last decimal, or 0 if the file has full precision.
    digit: f64,
    /// Number of radians in one unit of the file's angles.
    angle: f64,
    /// Axes of the bushing forces, once they are known.
    pub frame: Option<ForceFrame>,
}

/// Columns in which a results file reports one bushing.
struct Reported {
    id: u32,
    element: ElementIx,
    stiffest: f64,
    /// Column ids of FX, FY, FZ, TX, TY and TZ.
    wrench: [usize; 6],
    /// Column ids of ANGX, ANGY and ANGZ, if the file has them.
    angles: Option<[usize; 3]>,
}

impl BushingCheck {
    /// Prepares the check for all bushings that the file reports. `angle` is the number of radians in one unit of the file's angles.
    pub(crate) fn new(request: &SweepRequest<'_>, catalogue: &Catalogue, angle: f64) -> Self {
        // Diagnostics about elements that the built-in solver cannot solve do not matter for this check.
        let system = System::compile(request.model).value;
        let mut parameters = system.parameters();
        for (address, value) in request.theta {
            if let Some(slot) = system.catalogue().slot(address) {
                parameters.set(slot, *value);
            }
        }
        let programme = request.programme;
        let per_case = programme
            .loads
            .iter()
            .enumerate()
            .filter_map(|(column, load)| {
                let slot = system.catalogue().slot(&load.target)?;
                Some((
                    slot,
                    programme.cases.iter().map(|c| c.values[column]).collect(),
                ))
            })
            .collect();
        let bushings = request
            .model
            .bushings
            .iter()
            .filter_map(|bushing| {
                let id = bushing.header.id;
                let entity = catalogue.entity_of("Bushing", i64::from(id))?;
                let columns = |names: &[&str]| -> Option<Vec<usize>> {
                    names
                        .iter()
                        .map(|n| Some(entity.component(n)?.id))
                        .collect()
                };
                let of_this = |address: &&(Address, f64)| {
                    address.0.kind == "BUSHING" && address.0.id == Some(id)
                };
                let changed = request.theta.iter().filter(of_this).map(|(_, value)| value);
                let all = bushing.k.iter().chain(&bushing.kt).chain(changed);
                Some(Reported {
                    id,
                    element: system.element("BUSHING", id)?,
                    stiffest: all.fold(0.0, |most: f64, k| most.max(*k)),
                    wrench: columns(&["FX", "FY", "FZ", "TX", "TY", "TZ"])?
                        .try_into()
                        .ok()?,
                    angles: columns(&["ANGX", "ANGY", "ANGZ"]).and_then(|c| c.try_into().ok()),
                })
            })
            .collect();
        let places = request.model.results.decimal_places;
        let digit = if places < 17 {
            0.5 * 10f64.powi(-(places as i32))
        } else {
            0.0
        };
        Self {
            state: system.state(),
            scratch: Scratch::new(&system),
            system,
            parameters,
            bushings,
            per_case,
            digit,
            angle,
            frame: None,
        }
    }

    /// Checks one output step of the file, which belongs to load case `case`. `values` are the values of the step, and `poses` the poses
    /// read from them.
    ///
    /// # Errors
    /// Returns an error that names the bushing whose force or angles disagree with its law.
    pub(crate) fn step(
        &mut self,
        case: usize,
        values: &[f64],
        poses: &[Pose],
    ) -> Result<(), String> {
        if self.bushings.is_empty() {
            return Ok(());
        }
        for (slot, by_case) in &self.per_case {
            self.parameters.set(*slot, by_case[case]);
        }
        self.state.poses.clone_from_slice(poses);
        // Functions that only ADAMS can evaluate have no value here, but all markers are placed.
        let mut here = self
            .system
            .at(&self.parameters, &self.state, &mut self.scratch);
        let _ = here.evaluate();
        for reported in &self.bushings {
            let id = reported.id;
            let reading = here
                .read_element(reported.element)
                .map_err(|error| error.to_string())?;
            let read =
                |columns: &[usize]| Vec3::from_iterator(columns.iter().map(|c| values[c - 1]));
            if let Some(columns) = &reported.angles {
                let (found, law) = (read(columns) * self.angle, reading.motion.angles);
                let near = |k: usize| {
                    law[k].abs() > FAR
                        || (found[k] - law[k]).abs() <= AGREES * (1.0 + law[k].abs()) + self.digit
                };
                if !(0..3).all(near) {
                    return Err(format!(
                        "the angles of BUSHING/{id} are {:?} rad in the results, but {:?} rad by the poses of its parts",
                        found.as_slice(),
                        law.as_slice()
                    ));
                }
            }
            let slack = reported.stiffest * self.digit;
            let near = |a: Vec3, b: Vec3| (a - b).norm() <= AGREES * (1.0 + b.norm()) + slack;
            let (force, torque) = (read(&reported.wrench[..3]), read(&reported.wrench[3..]));
            let w = reading.wrench_j;
            let (f, t) = (Vec3::new(w[0], w[1], w[2]), Vec3::new(w[3], w[4], w[5]));
            let R_j = here.marker(reading.j).R;
            let fits = |R: &Mat3| near(force, R * f) && near(torque, R * t);
            let known = self.frame;
            let allowed: Vec<ForceFrame> = [
                (ForceFrame::Ground, fits(&R_j)),
                (ForceFrame::J, fits(&Mat3::identity())),
            ]
            .into_iter()
            .filter(|(frame, fits)| *fits && known.is_none_or(|known| known == *frame))
            .map(|(frame, _)| frame)
            .collect();
            match (allowed.as_slice(), known) {
                ([], None) => {
                    return Err(format!(
                        "the force of BUSHING/{id} fits its deflection neither in ground axes nor in those of its J marker"
                    ));
                }
                ([], Some(known)) => {
                    return Err(format!(
                        "the force of BUSHING/{id} does not fit its deflection in {known}, although the forces of the bushings before it do"
                    ));
                }
                ([only], _) => self.frame = Some(*only),
                _ => {}
            }
        }
        Ok(())
    }
}
