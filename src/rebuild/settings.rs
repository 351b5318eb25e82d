//! Numbers that decide what a rebuild accepts. Lengths and forces are relative to the size of the mechanism and to its largest force,
//! so that the units of a file do not matter.

/// Largest part of the mechanism's size by which a relative motion may miss that of a joint. Solvers close joints far better.
pub(crate) const CLOSURE_RELATIVE: f64 = 2e-8;
/// Largest rotation in radians that counts as none. Angles in results files carry round-off of a few units in 1e-16.
pub(crate) const NO_ROTATION_RAD: f64 = 1e-7;
/// Largest part of the relative motion by which a joint may be missed. It keeps a small motion of any kind from passing for a joint's.
pub(crate) const CLOSURE_OF_MOTION: f64 = 1e-4;
/// Largest part of the largest force that is no force: round-off of an equilibrium.
pub(crate) const NO_FORCE_RELATIVE: f64 = 1e-10;
/// Largest part of the largest force that may be left of a balance of forces, or of a force that should be constant.
pub(crate) const BALANCE_RELATIVE: f64 = 1e-7;
/// Largest number of signed sums of forces that the search for balances keeps.
pub(crate) const MOST_SUMS: usize = 2_000_000;
/// Largest number of states that the search for the connections uses; all states enter the numbers.
pub(crate) const SEARCH_STATES: usize = 32;
/// Largest lever, as a part of the mechanism's size, that the moments of all parts may miss in the end.
pub(crate) const LEVER_RELATIVE: f64 = 1e-6;
/// Singular values below this part of the largest are not determined by the results.
pub(crate) const DETERMINED_RELATIVE: f64 = 1e-10;
/// Largest number of sets of forces that the search keeps for one part.
pub(crate) const MOST_CANDIDATES: usize = 60;
/// Largest number of choices of I parts that the search tries for one set of forces.
pub(crate) const MOST_PARTNERS: usize = 400;
/// Largest number of assignments of balances to parts that the search tries.
pub(crate) const MOST_ASSIGNMENTS: usize = 200_000;
/// Largest part of the range of a force by which a linear law may miss it.
pub(crate) const LINEAR_RELATIVE: f64 = 1e-6;
/// Acceleration of gravity in m/s^2 (standard gravity, which Adams/Car uses); results files do not name it.
pub(crate) const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Mass in kg of a part that shows no weight.
pub(crate) const LEAST_MASS_KG: f64 = 1e-6;
/// Moment of inertia in kg m^2 that parts get, because equilibria do not show it.
pub(crate) const DEFAULT_INERTIA_KG_M2: f64 = 0.01;
/// Stiffness in N/mm of a bushing that no state deflects along any axis.
pub(crate) const DEFAULT_STIFFNESS_N_PER_MM: f64 = 1e4;
/// Stiffness in N m/rad of a bushing that no state turns about any axis.
pub(crate) const DEFAULT_TORSION_NM_PER_RAD: f64 = 500.0;
/// Distance of the marks of a study from the origin of their part, as a part of the mechanism's size.
pub(crate) const MARK_DISTANCE_RELATIVE: f64 = 0.1;
/// Largest distance in mm of a part from its place in the results that counts as repeated.
pub(crate) const REPEATED_MM: f64 = 1e-3;
/// Penalty of an element that acts on ground, in the score that compares assignments of forces to parts. Unit of all penalties: a name of
/// Adams/Car that agrees.
pub(crate) const GROUND_PENALTY: f64 = 1.0;
/// Further penalty of an element that is no joint and whose I part is ground: a force on one part is written with that part as its I part.
pub(crate) const GROUND_I_PENALTY: f64 = 0.2;
/// Penalty of an element that acts on no part.
pub(crate) const NOWHERE_PENALTY: f64 = 30.0;
/// Penalty of a group of parts on which no force acts.
pub(crate) const BARE_PENALTY: f64 = 4.0;
/// Largest number of placements of joints with constant forces that are tried.
pub(crate) const MOST_PLACEMENTS: usize = 300_000;
/// Penalty of a joint that is not placed, and of a negative mass.
pub(crate) const UNPLACED_PENALTY: f64 = 20.0;
/// Factor on what a coupled law leaves of the forces, where the coupled axes are not x and y.
pub(crate) const UNUSUAL_PAIR_FACTOR: f64 = 10.0;
/// Number of intervals of the spline that separates a preload from an odd curve.
pub(crate) const PRELOAD_SPLINE_INTERVALS: usize = 24;
