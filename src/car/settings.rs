//! Limits for matching and writing files of Adams/Car.

/// Largest distance in millimetres at which a hardpoint and a marker of the deck count as the same point. Adams/Car writes both with ten digits.
pub const HARDPOINT_MATCH_MM: f64 = 0.01;

/// Smallest change of a coordinate in millimetres that is written into a subsystem file. Smaller changes are round-off of rotations.
pub(crate) const SMALLEST_MOVE_MM: f64 = 1e-7;

/// Smallest relative change of a factor or preload that is written into a subsystem file, and the largest relative difference between the two
/// sides of a pair that share one entry.
pub(crate) const SMALLEST_CHANGE_RATIO: f64 = 1e-9;

/// Number of points of a learned curve in a bushing property file. Akima's spline through so many points repeats a cubic law to about 1e-6 of
/// its largest force.
pub(crate) const LEARNED_CURVE_POINTS: usize = 101;

/// Number of points of a linear curve in a bushing property file. The Akima spline of ADAMS needs five.
pub(crate) const LINEAR_CURVE_POINTS: usize = 5;

/// Number of significant digits of a number that is written into a file of Adams/Car.
pub(crate) const WRITTEN_DIGITS: usize = 12;

/// Largest number of characters of a name in an address. The rest of a longer name is cut off.
pub(crate) const ADDRESS_NAME_CHARACTERS: usize = 120;

/// Largest number of characters of the bushing's name in the name of a new property file.
pub(crate) const LEARNED_NAME_CHARACTERS: usize = 60;
