//! Groups of random effects (small errors of axle and rig), and the bounded lognormal priors of their standard deviations.

use crate::priors::{
    ALIGNMENT_MAX_MM, ALIGNMENT_MEDIAN_MM, AXIS_MEDIAN_DEG, DECLARED_NOISE_LN_SD,
    FRAME_SHIFT_MAX_MM, FRAME_SHIFT_MEDIAN_MM, FRAME_SHIFT_NEGLIGIBLE_MM, FRAME_TURN_MAX_RAD,
    FRAME_TURN_MEDIAN_RAD, FRAME_TURN_NEGLIGIBLE_RAD, GUESSED_NOISE_LN_SD, HARDPOINT_MEDIAN_MM,
    IDLE_LOAD_RATIO, KNOWN_STIFFNESS_MAX, KNOWN_STIFFNESS_MEDIAN, LOAD_DIRECTION_MEDIAN,
    LOAD_GAIN_MAX, LOAD_GAIN_MEDIAN, LOAD_POINT_MEDIAN_MM, LOAD_REPEATABILITY_MAX,
    LOAD_REPEATABILITY_MEDIAN, LOWER_BOUND_LN_SD, MARK_MEDIAN_MM, MOUNT_YIELD_MEDIAN_MM,
    NARROW_LN_SD, OFFSET_MEDIAN_MM, OFFSET_PER_HARDPOINT, POSE_ARM_MM, POSE_LN_SD,
    POSE_SHIFT_MEDIAN_MM, POSE_TURN_MEDIAN_RAD, PRELOAD_MAX, PRELOAD_MEDIAN, SPRING_RATE_MAX,
    SPRING_RATE_MEDIAN, STATED_LN_SD, UPPER_BOUND_LN_SD, USUAL_LN_SD, WIDE_LN_SD,
};
use crate::settings::{STRAINED_BOUND_LN, STRAINED_LN_SD};
use admire_study::{PriorSetting, ToleranceSettings};

/// A group of random effects that share one standard deviation, because the parts are manufactured or the readings are taken in the same way.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum EffectGroup {
    /// Position errors of hardpoints (a length). All parts that meet at a hardpoint have the same error.
    Hardpoints,
    /// Position errors of the points at which the loads of the rig act (a length).
    LoadPoints,
    /// Offsets between the two sides of bushings and joints (a length).
    Offsets,
    /// Direction errors of the axes of bushings and joints, in radians.
    Axes,
    /// Relative gain errors of loads, constant over the cases.
    LoadGains,
    /// Errors of loads that vary from case to case, in cases where the load is not zero; relative to the largest value of the load.
    LoadRepeatability,
    /// Errors of loads that vary from case to case, in cases where the load is zero; relative to the largest value of the load.
    IdleLoads,
    /// Crosstalk of loads: fraction of one load that also acts along another load.
    LoadDirections,
    /// Position errors of marks on their parts (a length).
    Marks,
    /// Misalignment of the measuring frame, constant over the cases. The size is the standard deviation of the translation (a length). The
    /// standard deviation of the rotation has a fixed ratio to the size.
    FrameAlignment,
    /// Translation of the measuring frame in each case, common to all marks (a length).
    FrameShifts,
    /// Rotation of the measuring frame in each case about the centroid of the marks, in radians.
    FrameTurns,
    /// Drift of the measuring frame, a random walk over the cases. The size is the standard deviation of the change from one case to the next
    /// (a length).
    FrameDrifts,
    /// Displacement of the axle's mount on the rig at the largest value of each load (a length).
    MountYield,
    /// Relative errors of spring forces in the design position.
    Preloads,
    /// Relative errors of spring rates.
    SpringRates,
    /// Relative errors of bushing stiffnesses that are not identified.
    KnownStiffnesses,
}

/// Noise levels that are estimated: rigid-motion noise of the marks of a part, and factors on stated noise levels.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum NoiseScale {
    /// Standard deviation of a common translation of all marks of a part in a case (a length).
    PoseShift,
    /// Standard deviation of a common rotation of all marks of a part in a case, in radians.
    PoseTurn,
    /// Factor on the stated noise of mark coordinates. It is used if the scatter of the marks alone does not determine their noise.
    Marks,
    /// Factor on the declared noise of the wheel position.
    WheelPosition,
    /// Factor on the declared noise of the wheel angles.
    WheelAngles,
    /// Factor on the noise of the channel with this index.
    Channel(usize),
}

/// Prior of a standard deviation ("size") of errors or noise: a lognormal distribution with bounds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ScalePrior {
    /// Median of the prior of the size.
    pub median: f64,
    /// Standard deviation of the natural logarithm of the size.
    pub ln_sd: f64,
    /// Lower and upper bound of the natural logarithm of the size.
    pub bounds: (f64, f64),
}

impl ScalePrior {
    fn new(usual: f64, ln_sd: f64) -> Self {
        let middle = libm::log(usual);
        Self {
            median: usual,
            ln_sd,
            bounds: (
                middle - LOWER_BOUND_LN_SD * ln_sd,
                middle + UPPER_BOUND_LN_SD * ln_sd,
            ),
        }
    }

    /// Returns the prior of a size that the study may state, in multiples of `unit`. Returns `usual` if the size is not stated. Returns `None`
    /// if it is stated as zero, which switches the group off.
    fn of(stated: PriorSetting, unit: f64, usual: Self) -> Option<Self> {
        match stated {
            PriorSetting::Estimate => Some(usual),
            PriorSetting::Size(size) if size > 0.0 => Some(Self::new(size * unit, STATED_LN_SD)),
            PriorSetting::Size(_) => None,
        }
    }

    /// Returns the prior of the misalignment of a measuring frame that was aligned with the axle. `millimetre` is one millimetre in the deck's
    /// length unit.
    pub fn of_alignment(stated: PriorSetting, millimetre: f64) -> Option<(EffectGroup, Self)> {
        let usual = Self::new(ALIGNMENT_MEDIAN_MM * millimetre, USUAL_LN_SD);
        Self::of(stated, millimetre, usual).map(|size| (EffectGroup::FrameAlignment, size))
    }

    /// Returns the prior of the misalignment of a measuring frame that evidently differs from the deck's frame. Its upper bound is
    /// [`ALIGNMENT_MAX_MM`]. `millimetre` is one millimetre in the deck's length unit.
    pub fn of_another_frame(millimetre: f64) -> (EffectGroup, Self) {
        let mut size = Self::new(ALIGNMENT_MEDIAN_MM * millimetre, USUAL_LN_SD);
        size.bounds.1 = libm::log(ALIGNMENT_MAX_MM * millimetre);
        (EffectGroup::FrameAlignment, size)
    }

    /// Returns the priors of load errors that vary from case to case, due to load cells and load control. The first is for cases where the load
    /// acts, the second for cases where it is zero.
    pub fn of_load_errors() -> [(EffectGroup, Self); 2] {
        [
            (
                EffectGroup::LoadRepeatability,
                Self::new(LOAD_REPEATABILITY_MEDIAN, WIDE_LN_SD).at_most(LOAD_REPEATABILITY_MAX),
            ),
            (
                EffectGroup::IdleLoads,
                Self::new(IDLE_LOAD_RATIO * LOAD_REPEATABILITY_MEDIAN, WIDE_LN_SD)
                    .at_most(LOAD_REPEATABILITY_MAX),
            ),
        ]
    }

    /// Returns the priors of the errors of the measuring frame that vary between cases: translation, rotation and random walk. `millimetre` is
    /// one millimetre in the deck's length unit.
    pub fn of_frames(millimetre: f64) -> [(EffectGroup, Self); 3] {
        let shift = Self::new(FRAME_SHIFT_MEDIAN_MM * millimetre, WIDE_LN_SD)
            .at_most(FRAME_SHIFT_MAX_MM * millimetre);
        [
            (EffectGroup::FrameShifts, shift),
            (
                EffectGroup::FrameTurns,
                Self::new(FRAME_TURN_MEDIAN_RAD, WIDE_LN_SD).at_most(FRAME_TURN_MAX_RAD),
            ),
            (EffectGroup::FrameDrifts, shift),
        ]
    }

    /// Returns the prior of the displacement of an axle's mount at the largest value of a load. `millimetre` is one millimetre in the deck's
    /// length unit.
    pub fn of_a_mount(millimetre: f64) -> [(EffectGroup, Self); 1] {
        [(
            EffectGroup::MountYield,
            Self::new(MOUNT_YIELD_MEDIAN_MM * millimetre, WIDE_LN_SD),
        )]
    }

    /// Returns the ratio of the rotation to the translation of a measuring frame, from their prior medians. The unit is radians per length unit
    /// of the deck; `millimetre` is one millimetre in that unit.
    pub const fn turn_by_shift(millimetre: f64) -> f64 {
        FRAME_TURN_MEDIAN_RAD / (FRAME_SHIFT_MEDIAN_MM * millimetre)
    }

    /// Returns true if the size `exp(ln)` is implausibly large: far above the prior median, or at the upper bound. The group may then have
    /// absorbed an effect that the model lacks.
    pub fn is_strained(&self, ln: f64) -> bool {
        let above = ln - libm::log(self.median);
        above > STRAINED_LN_SD * self.ln_sd || ln > self.bounds.1 - STRAINED_BOUND_LN
    }

    fn at_most(mut self, most: f64) -> Self {
        self.bounds.1 = self.bounds.1.min(libm::log(most));
        self
    }

    /// Returns the logarithm of the prior density at the log size `ln`, without additive constants.
    pub fn ln_prior(&self, ln: f64) -> f64 {
        let z = (ln - libm::log(self.median)) / self.ln_sd;
        -0.5 * z * z - libm::log(self.ln_sd)
    }
}

/// Standard deviations of all groups of random effects and of all noise scales, with their priors. [`VarianceComponents::ln`] holds the current
/// values.
#[derive(Clone, PartialEq, Debug)]
pub struct VarianceComponents {
    /// Groups of random effects with the priors of their standard deviations.
    pub groups: Vec<(EffectGroup, ScalePrior)>,
    /// Noise scales with the priors of their standard deviations or factors.
    pub scales: Vec<(NoiseScale, ScalePrior)>,
    /// Natural logarithms of the current standard deviations: first of `groups`, then of `scales`.
    pub ln: Vec<f64>,
}

impl VarianceComponents {
    /// Creates the default groups and noise scales of a study at their prior medians, without groups that the study switches off.
    ///
    /// `millimetre` is one millimetre in the deck's length unit. `sigma_on_parts` is the stated standard deviation of a mark coordinate on its
    /// part. `frames` holds the stated standard deviations of the measuring frame in a case: translation and rotation. Lengths are in the
    /// deck's length unit, rotations in radians.
    pub fn new(
        settings: &ToleranceSettings,
        sigma_on_parts: f64,
        frames: [f64; 2],
        millimetre: f64,
    ) -> Self {
        let degree = 1f64.to_radians();
        let mm = millimetre;
        let of = ScalePrior::of;
        let marks = if sigma_on_parts > 0.0 {
            ScalePrior::new(sigma_on_parts, STATED_LN_SD)
        } else {
            ScalePrior::new(MARK_MEDIAN_MM * mm, USUAL_LN_SD)
        };
        let s = settings;
        let known_to_be = |stated: PriorSetting| match stated {
            PriorSetting::Size(size) if size > 0.0 => Some(size),
            _ => None,
        };
        let stated = known_to_be(s.load_repeatability);
        let mount = known_to_be(s.mount).map(|size| ScalePrior::new(size * mm, STATED_LN_SD));
        // If the study states only one of translation and rotation of the frame, the other gets a negligible size.
        let has_frames = frames.iter().any(|size| *size > 0.0);
        let known = |size: f64, least: f64| {
            has_frames.then(|| ScalePrior::new(size.max(least), STATED_LN_SD))
        };
        let groups = [
            (
                EffectGroup::Hardpoints,
                of(
                    s.hardpoints,
                    mm,
                    ScalePrior::new(HARDPOINT_MEDIAN_MM * mm, USUAL_LN_SD),
                ),
            ),
            (
                EffectGroup::LoadPoints,
                Some(ScalePrior::new(LOAD_POINT_MEDIAN_MM * mm, USUAL_LN_SD)),
            ),
            (
                EffectGroup::Offsets,
                of(
                    s.hardpoints,
                    OFFSET_PER_HARDPOINT * mm,
                    ScalePrior::new(OFFSET_MEDIAN_MM * mm, USUAL_LN_SD),
                ),
            ),
            (
                EffectGroup::Axes,
                of(
                    s.axes_deg,
                    degree,
                    ScalePrior::new(AXIS_MEDIAN_DEG * degree, USUAL_LN_SD),
                ),
            ),
            (
                EffectGroup::LoadGains,
                of(
                    s.load_gain,
                    1.0,
                    ScalePrior::new(LOAD_GAIN_MEDIAN, NARROW_LN_SD).at_most(LOAD_GAIN_MAX),
                ),
            ),
            (
                EffectGroup::LoadRepeatability,
                stated.map(|size| ScalePrior::new(size, STATED_LN_SD)),
            ),
            (
                EffectGroup::IdleLoads,
                stated.map(|size| ScalePrior::new(IDLE_LOAD_RATIO * size, WIDE_LN_SD)),
            ),
            (
                EffectGroup::LoadDirections,
                of(
                    s.load_direction_deg,
                    degree,
                    ScalePrior::new(LOAD_DIRECTION_MEDIAN, USUAL_LN_SD),
                ),
            ),
            (EffectGroup::Marks, of(s.marks_on_parts, mm, marks)),
            (
                EffectGroup::FrameShifts,
                known(frames[0], FRAME_SHIFT_NEGLIGIBLE_MM * mm),
            ),
            (
                EffectGroup::FrameTurns,
                known(frames[1], FRAME_TURN_NEGLIGIBLE_RAD),
            ),
            (EffectGroup::MountYield, mount),
            (
                EffectGroup::Preloads,
                of(
                    s.preloads,
                    1.0,
                    ScalePrior::new(PRELOAD_MEDIAN, NARROW_LN_SD).at_most(PRELOAD_MAX),
                ),
            ),
            (
                EffectGroup::SpringRates,
                of(
                    s.spring_rates,
                    1.0,
                    ScalePrior::new(SPRING_RATE_MEDIAN, NARROW_LN_SD).at_most(SPRING_RATE_MAX),
                ),
            ),
            (
                EffectGroup::KnownStiffnesses,
                of(
                    s.stiffnesses,
                    1.0,
                    ScalePrior::new(KNOWN_STIFFNESS_MEDIAN, NARROW_LN_SD)
                        .at_most(KNOWN_STIFFNESS_MAX),
                ),
            ),
        ];
        let groups = groups
            .into_iter()
            .filter_map(|(group, size)| Some((group, size?)));
        let arm = POSE_ARM_MM * mm;
        let pose = [
            (
                NoiseScale::PoseShift,
                of(
                    s.pose,
                    mm,
                    ScalePrior::new(POSE_SHIFT_MEDIAN_MM * mm, POSE_LN_SD),
                ),
            ),
            (
                NoiseScale::PoseTurn,
                of(
                    s.pose,
                    mm / arm,
                    ScalePrior::new(POSE_TURN_MEDIAN_RAD, POSE_LN_SD),
                ),
            ),
        ];
        let scales = pose
            .into_iter()
            .filter_map(|(scale, size)| Some((scale, size?)));
        let mut new = Self {
            groups: groups.collect(),
            scales: scales.collect(),
            ln: Vec::new(),
        };
        new.ln = new.usual();
        new
    }

    /// Adds a noise scale that is a factor on a noise level, with prior median 1. `declared` tells whether the study declares the noise level.
    /// If the level is only a guess, the factor has a wide prior.
    pub fn add_scale(&mut self, scale: NoiseScale, declared: bool) {
        let ln_sd = if declared {
            DECLARED_NOISE_LN_SD
        } else {
            GUESSED_NOISE_LN_SD
        };
        let size = ScalePrior::new(1.0, ln_sd);
        self.scales.push((scale, size));
        self.ln.push(libm::log(size.median));
    }

    /// Returns these components with one additional group, at the median of its prior.
    #[must_use]
    pub fn with_group(&self, group: EffectGroup, size: ScalePrior) -> Self {
        let mut new = self.clone();
        new.ln.insert(new.groups.len(), libm::log(size.median));
        new.groups.push((group, size));
        new
    }

    /// Returns the logarithms of the prior medians, in the order of `ln`.
    pub(crate) fn usual(&self) -> Vec<f64> {
        self.each().map(|size| libm::log(size.median)).collect()
    }

    /// Iterates over the priors in the order of `ln`.
    pub fn each(&self) -> impl Iterator<Item = &ScalePrior> {
        let groups = self.groups.iter().map(|(_, size)| size);
        groups.chain(self.scales.iter().map(|(_, size)| size))
    }

    /// Returns the index of a group in `ln`; `None` if the study has no such group.
    pub fn group(&self, group: EffectGroup) -> Option<usize> {
        self.groups.iter().position(|(of, _)| *of == group)
    }

    /// Returns the index of a noise scale in `ln`; `None` if the scale is not estimated.
    pub fn scale(&self, scale: NoiseScale) -> Option<usize> {
        let at = self.scales.iter().position(|(of, _)| *of == scale)?;
        Some(self.groups.len() + at)
    }

    /// Returns the current standard deviation of a group; `None` if the study has no such group.
    pub fn of(&self, group: EffectGroup) -> Option<f64> {
        self.group(group).map(|at| libm::exp(self.ln[at]))
    }

    /// Returns these components with the log standard deviations `ln`.
    #[must_use]
    pub fn at(&self, ln: Vec<f64>) -> Self {
        Self { ln, ..self.clone() }
    }

    /// Returns the log standard deviations, each limited to the logarithm of its prior median plus `over`.
    ///
    /// Candidate models start from these values. A group that has absorbed a deficiency of the previous model can thus release it.
    pub fn capped_above_median(&self, over: f64) -> Vec<f64> {
        let each = self.ln.iter().zip(self.each());
        each.map(|(ln, size)| ln.min(libm::log(size.median) + over))
            .collect()
    }
}

impl EffectGroup {
    /// Returns the name of the group in `diagnosis.json`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Hardpoints => "hardpoints",
            Self::LoadPoints => "load-points",
            Self::Offsets => "assembly-offsets",
            Self::Axes => "axes",
            Self::LoadGains => "load-gains",
            Self::LoadRepeatability => "load-repeatability",
            Self::IdleLoads => "idle-loads",
            Self::LoadDirections => "load-directions",
            Self::Marks => "marks-on-parts",
            Self::FrameAlignment => "frame-alignment",
            Self::FrameShifts => "frame-shifts",
            Self::FrameTurns => "frame-turns",
            Self::FrameDrifts => "frame-drifts",
            Self::MountYield => "mount-yield",
            Self::Preloads => "spring-preloads",
            Self::SpringRates => "spring-rates",
            Self::KnownStiffnesses => "known-stiffnesses",
        }
    }
}

impl NoiseScale {
    /// Returns the name of the noise scale in `diagnosis.json`; empty for a scale that is not written there.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::PoseShift => "pose-noise",
            Self::PoseTurn => "pose-noise-turn",
            _ => "",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_strained_beyond_its_prior_or_at_its_bound() {
        let size = ScalePrior::new(0.003, 1.5);
        let times = |factor: f64| size.is_strained(libm::log(0.003 * factor));
        assert!(!times(1.0) && !times(0.01) && !times(20.0));
        // The limit is 2.5 standard deviations, a factor of e^3.75 = 42.5.
        assert!(!times(42.0) && times(43.0));
        let bounded = ScalePrior::new(0.003, 0.5).at_most(0.01);
        assert!(!bounded.is_strained(libm::log(0.0095)) && bounded.is_strained(libm::log(0.01)));
    }
}
