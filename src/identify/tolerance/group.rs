//! Groups of tolerances, their usual sizes, and how far the readings may move those.

use admire_study::{PriorSetting, ToleranceSettings};

/// What belongs together because it is made, or measured, in the same way.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum EffectGroup {
    /// Connection points, all parts that meet there together.
    Hardpoints,
    /// Points where the rig's loads act.
    LoadPoints,
    /// Bushings and joints whose two sides sit displaced.
    Offsets,
    /// Axes of bushings and joints.
    Axes,
    /// Factors of loads.
    LoadGains,
    /// Loads in single cases in which they act, parts of the largest value of each.
    LoadRepeatability,
    /// The same where they are zero.
    IdleLoads,
    /// Parts of one load that act along another.
    LoadDirections,
    /// Places of marks on their parts.
    Marks,
    /// Where the measuring frame sits, the same in all cases: a shift, and a turn that goes with it.
    FrameAlignment,
    /// Shifts of the measuring frame in each case, the same for all marks.
    FrameShifts,
    /// Turns of it about the centroid of the marks.
    FrameTurns,
    /// How it goes on from case to case: a random walk, whose step from a case to the next this is.
    FrameDrifts,
    /// How far the axle's mount on the rig moves with each load at its largest value.
    MountYield,
    /// Forces of springs at design.
    Preloads,
    /// Rates of springs.
    SpringRates,
    /// Stiffnesses of rubber taken as known.
    KnownStiffnesses,
}

/// What noise there is beside that of single coordinates.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum NoiseScale {
    /// A rigid shift of all marks of a part in a case.
    PoseShift,
    /// A rigid turn of all marks of a part in a case.
    PoseTurn,
    /// Mark coordinates over what is declared, where the marks themselves do not tell.
    Marks,
    /// Coordinates of the wheel over what is declared.
    WheelPosition,
    /// Angles of the wheel over what is declared.
    WheelAngles,
    /// A channel over what is declared.
    Channel(usize),
}

/// A size this many standard deviations of its prior above the median, or at its upper bound to so much, is more than the prior allows.
const STRAINED: f64 = 2.5;
const NEAR_BOUND: f64 = 0.01;

/// A size: median and standard deviation of the logarithm of its lognormal prior, and the most it may be.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Size {
    /// Median.
    pub median: f64,
    /// Standard deviation of the logarithm.
    pub ln_sd: f64,
    /// Natural logarithms of the bounds.
    pub bounds: (f64, f64),
}

/// Sizes that the user states are known so well.
const STATED: f64 = 0.25;
/// The usual error of a load in a single case, part of the largest value, and the most it may be; of one that is zero it is so much less.
const REPEATED: f64 = 0.001;
const MOST: f64 = 0.01;
const IDLE: f64 = 0.3;
/// What is usually left of the measuring frame's place when it was aligned with the axle, mm.
const ALIGNED: f64 = 0.05;
/// The most that another frame than the deck's may be off, mm.
const MOST_OFF: f64 = 20.0;
/// The usual shift of the measuring frame in a case, mm, and turn, radians, and the most they may be.
const SHIFTED: f64 = 0.005;
const MOST_SHIFTED: f64 = 0.2;
const TURNED: f64 = 1e-5;
const MOST_TURNED: f64 = 5e-4;
/// What an axle's mount usually yields at the largest value of a load, mm.
const YIELDED: f64 = 0.02;
/// Standard deviation of the logarithm of a size that differs much from rig to rig.
const LOOSE: f64 = 1.0;

impl Size {
    /// The usual error of a hardpoint of a production axle, mm.
    pub const HARDPOINTS: f64 = 0.2;

    fn new(usual: f64, ln_sd: f64) -> Self {
        let middle = libm::log(usual);
        Self {
            median: usual,
            ln_sd,
            bounds: (middle - 4.0 * ln_sd, middle + 2.5 * ln_sd),
        }
    }

    /// A size that may be stated: zero switches its group off.
    fn of(stated: PriorSetting, unit: f64, usual: Self) -> Option<Self> {
        match stated {
            PriorSetting::Estimate => Some(usual),
            PriorSetting::Size(size) if size > 0.0 => Some(Self::new(size * unit, STATED)),
            PriorSetting::Size(_) => None,
        }
    }

    /// What is left of a measuring frame's place when it was aligned with the axle.
    pub fn of_alignment(stated: PriorSetting, millimetre: f64) -> Option<(EffectGroup, Self)> {
        let usual = Self::new(ALIGNED * millimetre, 0.7);
        Self::of(stated, millimetre, usual).map(|size| (EffectGroup::FrameAlignment, size))
    }

    /// The same of a frame that is seen to be another one.
    pub fn of_another_frame(millimetre: f64) -> (EffectGroup, Self) {
        let mut size = Self::new(ALIGNED * millimetre, 0.7);
        size.bounds.1 = libm::log(MOST_OFF * millimetre);
        (EffectGroup::FrameAlignment, size)
    }

    /// What load cells and their control leave from case to case; and where a load is zero.
    pub fn of_load_errors() -> [(EffectGroup, Self); 2] {
        [
            (
                EffectGroup::LoadRepeatability,
                Self::new(REPEATED, LOOSE).at_most(MOST),
            ),
            (
                EffectGroup::IdleLoads,
                Self::new(IDLE * REPEATED, LOOSE).at_most(MOST),
            ),
        ]
    }

    /// What setting up a measuring frame anew for each case leaves. `millimetre` is one in the deck's unit.
    pub fn of_frames(millimetre: f64) -> [(EffectGroup, Self); 3] {
        let shift = Self::new(SHIFTED * millimetre, LOOSE).at_most(MOST_SHIFTED * millimetre);
        [
            (EffectGroup::FrameShifts, shift),
            (
                EffectGroup::FrameTurns,
                Self::new(TURNED, LOOSE).at_most(MOST_TURNED),
            ),
            (EffectGroup::FrameDrifts, shift),
        ]
    }

    /// How far the mount of an axle usually yields at the largest value of a load.
    pub fn of_a_mount(millimetre: f64) -> [(EffectGroup, Self); 1] {
        [(
            EffectGroup::MountYield,
            Self::new(YIELDED * millimetre, LOOSE),
        )]
    }

    /// The turn of a frame that goes with a shift, per length.
    pub const fn turn_by_shift(millimetre: f64) -> f64 {
        TURNED / (SHIFTED * millimetre)
    }

    /// True if a size is so large that its prior speaks against it: what grew so far took up what the model lacks.
    pub fn is_strained(&self, ln: f64) -> bool {
        let above = ln - libm::log(self.median);
        above > STRAINED * self.ln_sd || ln > self.bounds.1 - NEAR_BOUND
    }

    fn at_most(mut self, most: f64) -> Self {
        self.bounds.1 = self.bounds.1.min(libm::log(most));
        self
    }

    /// Logarithm of the prior's density, constants left out.
    pub fn ln_prior(&self, ln: f64) -> f64 {
        let z = (ln - libm::log(self.median)) / self.ln_sd;
        -0.5 * z * z - libm::log(self.ln_sd)
    }
}

/// Sizes of groups and noises: which there are, what is usual, and in [`Sizes::ln`] what they are taken to be.
#[derive(Clone, PartialEq, Debug)]
pub struct VarianceComponents {
    /// Groups, then scales; in the order of `ln`.
    pub groups: Vec<(EffectGroup, Size)>,
    /// Noises beside that of single coordinates.
    pub scales: Vec<(NoiseScale, Size)>,
    /// Natural logarithms.
    pub ln: Vec<f64>,
}

impl VarianceComponents {
    /// All groups and scales a study needs as a rule; none that the user has switched off. `millimetre` is one in the deck's unit, in
    /// which marks on parts and shifts of the frame are stated; its turns are in radians.
    pub fn new(
        settings: &ToleranceSettings,
        (sigma_on_parts, frames): (f64, [f64; 2]),
        millimetre: f64,
    ) -> Self {
        let degree = 1f64.to_radians();
        let mm = millimetre;
        let of = Size::of;
        let marks = if sigma_on_parts > 0.0 {
            Size::new(sigma_on_parts, STATED)
        } else {
            Size::new(0.01 * mm, 0.7)
        };
        let s = settings;
        let known_to_be = |stated: PriorSetting| match stated {
            PriorSetting::Size(size) if size > 0.0 => Some(size),
            _ => None,
        };
        let stated = known_to_be(s.load_repeatability);
        let mount = known_to_be(s.mount).map(|size| Size::new(size * mm, STATED));
        // One that is stated to be zero is next to nothing where the other is not.
        let has_frames = frames.iter().any(|size| *size > 0.0);
        let known = |size: f64, least: f64| has_frames.then(|| Size::new(size.max(least), STATED));
        let groups = [
            (
                EffectGroup::Hardpoints,
                of(s.hardpoints, mm, Size::new(Size::HARDPOINTS * mm, 0.7)),
            ),
            (EffectGroup::LoadPoints, Some(Size::new(0.5 * mm, 0.7))),
            (
                EffectGroup::Offsets,
                of(s.hardpoints, 0.25 * mm, Size::new(0.05 * mm, 0.7)),
            ),
            (EffectGroup::Axes, Some(Size::new(0.1 * degree, 0.7))),
            (
                EffectGroup::LoadGains,
                of(s.load_gain, 1.0, Size::new(0.003, 0.5).at_most(0.01)),
            ),
            (
                EffectGroup::LoadRepeatability,
                stated.map(|size| Size::new(size, STATED)),
            ),
            (
                EffectGroup::IdleLoads,
                stated.map(|size| Size::new(IDLE * size, LOOSE)),
            ),
            (
                EffectGroup::LoadDirections,
                of(s.load_direction_deg, degree, Size::new(0.001, 0.7)),
            ),
            (EffectGroup::Marks, of(s.marks_on_parts, mm, marks)),
            (EffectGroup::FrameShifts, known(frames[0], 1e-6 * mm)),
            (EffectGroup::FrameTurns, known(frames[1], 1e-9)),
            (EffectGroup::MountYield, mount),
            (
                EffectGroup::Preloads,
                Some(Size::new(0.003, 0.5).at_most(0.01)),
            ),
            (
                EffectGroup::SpringRates,
                Some(Size::new(0.015, 0.5).at_most(0.025)),
            ),
            (
                EffectGroup::KnownStiffnesses,
                Some(Size::new(0.03, 0.5).at_most(0.1)),
            ),
        ];
        let groups = groups
            .into_iter()
            .filter_map(|(group, size)| Some((group, size?)));
        let arm = 100.0 * mm;
        let pose = [
            (
                NoiseScale::PoseShift,
                of(s.pose, mm, Size::new(0.003 * mm, 1.5)),
            ),
            (
                NoiseScale::PoseTurn,
                of(s.pose, mm / arm, Size::new(3e-5, 1.5)),
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

    /// With one more noise, over what is declared or, where nothing is, over a guess.
    pub fn add_scale(&mut self, scale: NoiseScale, declared: bool) {
        let size = Size::new(1.0, if declared { 0.5 } else { 3.0 });
        self.scales.push((scale, size));
        self.ln.push(libm::log(size.median));
    }

    /// With one more group, at its usual size.
    #[must_use]
    pub fn with_group(&self, group: EffectGroup, size: Size) -> Self {
        let mut new = self.clone();
        new.ln.insert(new.groups.len(), libm::log(size.median));
        new.groups.push((group, size));
        new
    }

    /// Logarithms of the usual sizes.
    pub(crate) fn usual(&self) -> Vec<f64> {
        self.each().map(|size| libm::log(size.median)).collect()
    }

    /// Prior and bounds of each, in the order of `ln`.
    pub fn each(&self) -> impl Iterator<Item = &Size> {
        let groups = self.groups.iter().map(|(_, size)| size);
        groups.chain(self.scales.iter().map(|(_, size)| size))
    }

    /// Where a group is in `ln`.
    pub fn group(&self, group: EffectGroup) -> Option<usize> {
        self.groups.iter().position(|(of, _)| *of == group)
    }

    /// Where a scale is in `ln`.
    pub fn scale(&self, scale: NoiseScale) -> Option<usize> {
        let at = self.scales.iter().position(|(of, _)| *of == scale)?;
        Some(self.groups.len() + at)
    }

    /// The size of a group.
    pub fn of(&self, group: EffectGroup) -> Option<f64> {
        self.group(group).map(|at| libm::exp(self.ln[at]))
    }

    /// The same with other values.
    #[must_use]
    pub fn at(&self, ln: Vec<f64>) -> Self {
        Self { ln, ..self.clone() }
    }

    /// Where a candidate's sizes start: not above what is usual by more than a factor e, so that sizes that have swallowed a cause
    /// let it go.
    pub fn shrunk_to_median(&self, over: f64) -> Vec<f64> {
        let each = self.ln.iter().zip(self.each());
        each.map(|(ln, size)| ln.min(libm::log(size.median) + over))
            .collect()
    }
}

impl EffectGroup {
    /// Its name in `diagnosis.json`.
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
    /// Its name in `diagnosis.json`; empty for a noise whose size is not written there.
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
        let size = Size::new(0.003, 1.5);
        let times = |factor: f64| size.is_strained(libm::log(0.003 * factor));
        assert!(!times(1.0) && !times(0.01) && !times(20.0));
        // 2.5 standard deviations: a factor of e^3.75.
        assert!(!times(42.0) && times(43.0));
        let bounded = Size::new(0.003, 0.5).at_most(0.01);
        assert!(!bounded.is_strained(libm::log(0.0095)) && bounded.is_strained(libm::log(0.01)));
    }
}
