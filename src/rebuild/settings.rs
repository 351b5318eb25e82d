//! Limits and default values of a rebuild. Lengths and forces are relative to the size of the mechanism and to its largest force, so that the units
//! of a file do not matter.

/// Largest deviation of a relative motion from the motion of a joint, as a fraction of the mechanism's size. Solvers close joints far better.
pub(crate) const CLOSURE_RELATIVE: f64 = 2e-8;
/// Largest rotation in radians that counts as zero. Angles in results files have a round-off of a few units in 1e-16.
pub(crate) const NO_ROTATION_RAD: f64 = 1e-7;
/// Largest deviation from the motion of a joint, as a fraction of the relative motion. Without this limit, any small motion would be accepted as the
/// motion of a joint.
pub(crate) const CLOSURE_OF_MOTION: f64 = 1e-4;
/// Largest force that counts as zero, as a fraction of the largest force: round-off of an equilibrium.
pub(crate) const NO_FORCE_RELATIVE: f64 = 1e-10;
/// Largest residual of a balance of forces, and largest variation of a constant force, as fractions of the largest force.
pub(crate) const BALANCE_RELATIVE: f64 = 1e-7;
/// Largest number of signed sums of forces that the search for balances keeps.
pub(crate) const MOST_SUMS: usize = 2_000_000;
/// Largest number of states that the search for connections uses. The numerical values are fitted to all states.
pub(crate) const SEARCH_STATES: usize = 32;
/// Largest final lever of the residual moments of all parts, as a fraction of the mechanism's size.
pub(crate) const LEVER_RELATIVE: f64 = 1e-6;
/// Singular values below this fraction of the largest one count as undetermined by the results.
pub(crate) const DETERMINED_RELATIVE: f64 = 1e-10;
/// Largest number of sets of forces that the search keeps for one part.
pub(crate) const MOST_CANDIDATES: usize = 60;
/// Largest number of choices of I parts that the search tries for one set of forces.
pub(crate) const MOST_PARTNERS: usize = 400;
/// Largest number of assignments of balances to parts that the search tries.
pub(crate) const MOST_ASSIGNMENTS: usize = 200_000;
/// Largest deviation of a force from a linear law, as a fraction of the range of the force.
pub(crate) const LINEAR_RELATIVE: f64 = 1e-6;
/// Acceleration of gravity in m/s^2: standard gravity, as in Adams/Car. Results files do not contain it.
pub(crate) const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Smallest mass in kg of a part in the deck. A part without a weight in the results gets this mass.
pub(crate) const LEAST_MASS_KG: f64 = 1e-6;
/// Default moment of inertia in kg m^2 of a part, because equilibria do not determine it.
pub(crate) const DEFAULT_INERTIA_KG_M2: f64 = 0.01;
/// Stiffness in N/mm of a bushing that no state deflects along any axis.
pub(crate) const DEFAULT_STIFFNESS_N_PER_MM: f64 = 1e4;
/// Stiffness in N m/rad of a bushing that no state turns about any axis.
pub(crate) const DEFAULT_TORSION_NM_PER_RAD: f64 = 500.0;
/// Distance of the marks of a study from the origin of their part, as a fraction of the mechanism's size.
pub(crate) const MARK_DISTANCE_RELATIVE: f64 = 0.1;
/// Largest distance in mm between a part and its position in the results at which the state counts as reproduced.
pub(crate) const REPEATED_MM: f64 = 1e-3;
/// Penalty of an element that acts on ground, in the score that compares assignments of forces to parts. The unit of all penalties is one matching
/// name of Adams/Car.
pub(crate) const GROUND_PENALTY: f64 = 1.0;
/// Additional penalty of an element that is not a joint and whose I part is ground. A force on a single part is written with that part as its I part.
pub(crate) const GROUND_I_PENALTY: f64 = 0.2;
/// Penalty of an element that acts on no part.
pub(crate) const NOWHERE_PENALTY: f64 = 30.0;
/// Penalty of a group of parts on which no force acts.
pub(crate) const BARE_PENALTY: f64 = 4.0;
/// Largest number of placements of joints with constant forces that are tried.
pub(crate) const MOST_PLACEMENTS: usize = 300_000;
/// Penalty of a joint that is not placed, and of a negative mass.
pub(crate) const UNPLACED_PENALTY: f64 = 20.0;
/// Factor on the residual force of a coupled law whose coupled axes are not x and y.
pub(crate) const UNUSUAL_PAIR_FACTOR: f64 = 10.0;
/// Number of intervals of the spline that separates a preload from an odd curve.
pub(crate) const PRELOAD_SPLINE_INTERVALS: usize = 24;
