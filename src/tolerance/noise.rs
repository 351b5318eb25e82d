//! Noise of mark readings without any model: the marks of a rigid part keep their distances.
//!
//! Of the 3 m coordinates of m marks six tell the pose; the others are noise and the marks' places on the part, which are the same in
//! every case and cancel against their mean.

use std::collections::BTreeMap;

use nalgebra::DVector;

use super::tails::Tails;
use crate::mechanics::Vec3;
use crate::rig::Measurement;
use crate::rig::orientation::absolute_orientation;

/// A reading is looked at as an outlier from so many standard deviations on,
const SUSPECT: f64 = 6.0;
/// and is one from so many on, where the other marks of its part agree among themselves.
const OUTLIER: f64 = 8.0;
/// A model shows a mark to be wrong that is off by this part of the worst of its part.
const APART: f64 = 0.4;
/// Of three marks one stands alone if the others are off by less than this part of it.
const ALONE: f64 = 0.25;
/// Marks agree when the sum of their squares per degree of freedom is below this.
const AGREE: f64 = 12.0;
/// The declared noise is contradicted from so many standard deviations of its logarithm on.
const CONTRADICTED: f64 = 4.0;
/// With heavy tails its logarithm may be off by so much more.
const TAILED: f64 = 0.3;
/// Marks are sorted so often at most.
const PASSES: usize = 4;
/// Scale of the median of absolute values for a Gaussian.
const MAD: f64 = 1.4826;

/// One reading of one mark that is wrong.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkOutlier {
    /// Load case.
    pub case: usize,
    /// Index into the readings of the case.
    pub reading: usize,
    /// How far it lies from where the other marks put it, ground axes.
    pub error: Vec3,
}

/// How exact mark coordinates are.
#[derive(Clone, PartialEq, Debug)]
pub struct Noise {
    /// Standard deviation of a coordinate as the study states it; `None` if it states none.
    pub declared: Option<f64>,
    /// The same from the readings, where parts carry four marks or more in several cases.
    pub estimated: Option<f64>,
    /// Standard deviation of the logarithm of the estimate.
    pub ln_sd: f64,
    /// By how many nats Student's t is a better distribution of what is left of the marks than the Gaussian.
    pub tails: f64,
    /// Readings that are plainly wrong.
    pub outliers: Vec<MarkOutlier>,
    /// Case and part of marks of which several are wrong, so that they do not tell themselves which: a model has to.
    pub suspects: Vec<(usize, usize)>,
}

/// Marks of one part in one case.
#[derive(Clone, PartialEq)]
struct Block {
    case: usize,
    part: usize,
    /// Indices of readings.
    readings: Vec<usize>,
}

impl Noise {
    /// From the marks of a measurement.
    pub(crate) fn of(measurement: &Measurement) -> Self {
        let declared = (!measurement.sigma_estimated).then_some(measurement.sigma);
        let all = blocks(measurement);
        let none = BTreeMap::new();
        // Robust first: what is plainly wrong must not decide what plain is. In few cases it does, until it is left out.
        let mut sorted = Sorted {
            blocks: all.clone(),
            ..Sorted::default()
        };
        for _ in 0..PASSES {
            let rough = residuals(measurement, &sorted.blocks, &none);
            let centre = centres(&rough, true);
            let sigma = spread(coordinates(measurement, &rough, &centre));
            let again = sort(measurement, all.clone(), &centre, sigma);
            let is_same = again.is_same(&sorted);
            sorted = again;
            if is_same {
                break;
            }
        }
        let Sorted {
            blocks,
            outliers,
            suspects,
        } = sorted;
        let clean = residuals(measurement, &blocks, &none);
        let centre = centres(&clean, false);
        let left = coordinates(measurement, &clean, &centre);
        let squares: f64 = left.iter().map(|value| value * value).sum();
        // Six of each block told its pose, and as many coordinates of each part as are left its mean.
        let mut dof: f64 = blocks
            .iter()
            .map(|b| 3.0 * b.readings.len() as f64 - 6.0)
            .sum();
        let mut parts = BTreeMap::new();
        for block in &blocks {
            let most = parts.entry(block.part).or_insert(0.0_f64);
            *most = most.max(3.0 * block.readings.len() as f64 - 6.0);
        }
        if !centre.is_empty() {
            dof -= parts.values().sum::<f64>();
        }
        let usable = dof >= 6.0 && squares > 0.0;
        Self {
            declared,
            estimated: usable.then(|| (squares / dof).sqrt()),
            ln_sd: (1.0 / (2.0 * dof.max(1.0))).sqrt(),
            tails: Tails::best(&left).map_or(0.0, |(_, gain)| gain),
            outliers,
            suspects,
        }
    }

    /// Marks under suspicion judged by a model: `misfit` is reading minus prediction of a reading in a case.
    pub(crate) fn judge(
        &mut self,
        measurement: &Measurement,
        misfit: &dyn Fn(usize, usize) -> Option<Vec3>,
    ) {
        let sigma = self.sigma().unwrap_or(0.0);
        for (case, part) in std::mem::take(&mut self.suspects) {
            let readings = measurement.cases[case].marks.iter().enumerate();
            let errors: Vec<(usize, Vec3)> = readings
                .filter(|(_, mark)| mark.part == part)
                .filter_map(|(reading, _)| Some((reading, misfit(case, reading)?)))
                .collect();
            let largest = errors.iter().map(|(_, e)| e.norm()).fold(0.0, f64::max);
            let least = (OUTLIER * sigma).max(APART * largest);
            let wrong = errors.into_iter().filter(|(_, e)| e.norm() > least);
            self.outliers
                .extend(wrong.map(|(reading, error)| MarkOutlier {
                    case,
                    reading,
                    error,
                }));
        }
        self.outliers
            .sort_by_key(|outlier| (outlier.case, outlier.reading));
    }

    /// The standard deviation a fit should use: the estimate where there is one.
    pub(crate) fn sigma(&self) -> Option<f64> {
        self.estimated.or(self.declared)
    }

    /// True if the declared noise is not the noise of the readings, which may have heavy tails.
    pub(crate) fn contradicts(&self, tailed: bool) -> bool {
        match (self.declared, self.estimated) {
            (Some(declared), Some(estimated)) if declared > 0.0 => {
                // With heavy tails a standard deviation says little.
                let loose = if tailed { TAILED } else { 0.0 };
                libm::log(estimated / declared).abs() > CONTRADICTED * self.ln_sd + loose
            }
            _ => false,
        }
    }

    /// True if the residuals are further out than those of a Gaussian.
    pub(crate) fn has_tails(&self) -> bool {
        self.tails > Tails::BETTER
    }

    /// True if they may be: marks in few cases do not tell.
    pub(crate) fn may_have_tails(&self) -> bool {
        self.tails > Tails::HINT
    }

    /// Puts three marks of a part under suspicion where a model of which most marks are `usual` far off says so: they fit a rigid part if one
    /// of them is off across the others. Of a part that has no more, one has to stand alone. True if there are any.
    pub(crate) fn suspect_three(
        &mut self,
        measurement: &Measurement,
        misfit: &dyn Fn(usize, usize) -> Option<Vec3>,
        usual: f64,
    ) -> bool {
        let least = OUTLIER * usual.max(self.sigma().unwrap_or(0.0));
        let before = self.suspects.len();
        for block in blocks(measurement) {
            let (case, part) = (block.case, block.part);
            if self.suspects.contains(&(case, part)) {
                continue;
            }
            let is_here = |o: &MarkOutlier| o.case == case && block.readings.contains(&o.reading);
            let lost = self.outliers.iter().filter(|o| is_here(o)).count();
            if block.readings.len() - lost > 3 {
                continue;
            }
            let is_out = |k: &&usize| {
                let mut known = self.outliers.iter().filter(|o| is_here(o));
                known.any(|o| o.reading == **k)
            };
            let rest = block.readings.iter().filter(|k| !is_out(k));
            let mut off: Vec<f64> = rest
                .filter_map(|k| Some(misfit(case, *k)?.amax()))
                .collect();
            off.sort_by(|a, b| b.total_cmp(a));
            let [largest, next, ..] = off[..] else {
                continue;
            };
            if largest > least && (lost > 0 || next < ALONE * largest) {
                self.outliers.retain(|o| !is_here(o));
                self.suspects.push((case, part));
            }
        }
        self.suspects.len() > before
    }
}

/// Standard deviation by the median of absolute values.
pub(crate) fn spread(mut values: Vec<f64>) -> f64 {
    values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    MAD * values
        .get(values.len() / 2)
        .map_or(0.0, |value| value.abs())
}

/// Marks sorted into those that fit rigid parts and others.
#[derive(Default)]
struct Sorted {
    blocks: Vec<Block>,
    outliers: Vec<MarkOutlier>,
    suspects: Vec<(usize, usize)>,
}

impl Sorted {
    fn is_same(&self, other: &Self) -> bool {
        self.blocks == other.blocks && self.suspects == other.suspects
    }
}

/// Sorts the marks of all blocks by what the others of each say.
fn sort(
    measurement: &Measurement,
    mut blocks: Vec<Block>,
    centre: &BTreeMap<(usize, usize), Vec3>,
    sigma: f64,
) -> Sorted {
    let (mut outliers, mut suspects) = (Vec::new(), Vec::new());
    if sigma > 0.0 {
        blocks.retain_mut(|block| {
            loop {
                match worst(measurement, block, centre, sigma) {
                    Looks::Fine => return true,
                    Looks::Wrong(at, error) => outliers.push(MarkOutlier {
                        case: block.case,
                        reading: block.readings.remove(at),
                        error,
                    }),
                    Looks::Mixed => {
                        suspects.push((block.case, block.part));
                        return false;
                    }
                }
            }
        });
    }
    Sorted {
        blocks,
        outliers,
        suspects,
    }
}

/// Parts with more marks than a pose needs.
fn blocks(measurement: &Measurement) -> Vec<Block> {
    let mut out = Vec::new();
    for (case, read) in measurement.cases.iter().enumerate() {
        for part in 0..measurement.parts.len() {
            let readings: Vec<usize> = (0..read.marks.len())
                .filter(|k| read.marks[*k].part == part)
                .collect();
            if readings.len() > 2 {
                out.push(Block {
                    case,
                    part,
                    readings,
                });
            }
        }
    }
    out
}

/// (case, reading, (part, mark)).
type Key = (usize, usize, (usize, usize));

/// Residuals of each part in each case.
fn by_block(residuals: &[(Key, Vec3)]) -> BTreeMap<(usize, usize), Vec<(Key, Vec3)>> {
    let mut out: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for (key, e) in residuals {
        let block: &mut Vec<(Key, Vec3)> = out.entry((key.0, key.2.0)).or_default();
        block.push((*key, *e));
    }
    out
}

/// What is left of all blocks, the centres taken off, along directions that no rigid motion changes.
fn coordinates(
    measurement: &Measurement,
    residuals: &[(Key, Vec3)],
    centre: &BTreeMap<(usize, usize), Vec3>,
) -> Vec<f64> {
    let mut out = Vec::new();
    for (block, own) in by_block(residuals) {
        let marks = &measurement.cases[block.0].marks;
        let place = |reading: usize| measurement.parts[block.1].marks[marks[reading].mark].p;
        let places: Vec<Vec3> = own.iter().map(|(key, _)| place(key.1)).collect();
        let e: Vec<f64> = own
            .iter()
            .flat_map(|(key, e)| {
                let e = e - centre.get(&key.2).copied().unwrap_or_default();
                [e.x, e.y, e.z]
            })
            .collect();
        out.extend(internal(&places, &DVector::from_vec(e)));
    }
    out
}

/// Coordinates of residuals that no rigid motion of the marks changes, along an orthonormal basis: all of the same variance.
fn internal(places: &[Vec3], e: &DVector<f64>) -> Vec<f64> {
    let n = e.len();
    let centroid = places.iter().sum::<Vec3>() / places.len() as f64;
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut orthogonal = |mut column: DVector<f64>, least: f64| {
        let size = column.norm();
        for _ in 0..2 {
            for known in &basis {
                let along = known.dot(&column);
                column.axpy(-along, known, 1.0);
            }
        }
        let left = column.norm();
        if left > least * size {
            basis.push(column / left);
        }
        basis.len()
    };
    let mut rigid = 0;
    for k in 0..6 {
        let of = |mark: &Vec3| {
            if k < 3 {
                Vec3::ith(k, 1.0)
            } else {
                Vec3::ith(k - 3, 1.0).cross(&(mark - centroid))
            }
        };
        let column = places.iter().flat_map(|mark| {
            let v = of(mark);
            [v.x, v.y, v.z]
        });
        rigid = orthogonal(DVector::from_iterator(n, column), 1e-9);
    }
    for k in 0..n {
        let mut unit = DVector::zeros(n);
        unit[k] = 1.0;
        orthogonal(unit, 1e-3);
    }
    basis[rigid..]
        .iter()
        .map(|direction| direction.dot(e))
        .collect()
}

/// What the best rigid motion leaves of each reading, in part axes.
fn residuals(
    measurement: &Measurement,
    blocks: &[Block],
    centre: &BTreeMap<(usize, usize), Vec3>,
) -> Vec<(Key, Vec3)> {
    let mut out = Vec::new();
    for block in blocks {
        let marks = &measurement.cases[block.case].marks;
        let read: Vec<_> = block.readings.iter().map(|k| marks[*k]).collect();
        let local = |mark: usize| {
            let shift = centre.get(&(block.part, mark)).copied().unwrap_or_default();
            measurement.parts[block.part].marks[mark].p + shift
        };
        let on_part: Vec<Vec3> = read.iter().map(|mark| local(mark.mark)).collect();
        let measured: Vec<Vec3> = read.iter().map(|mark| mark.x).collect();
        let Ok(fit) = absolute_orientation(&on_part, &measured, 1.0) else {
            continue;
        };
        for ((k, mark), e) in block.readings.iter().zip(&read).zip(&fit.residuals) {
            let key = (block.case, *k, (block.part, mark.mark));
            out.push((key, fit.pose.R.transpose() * e));
        }
    }
    out
}

/// Mean or median of each mark's residual over the cases; empty with fewer than three cases, where they would take most of the noise.
fn centres(residuals: &[(Key, Vec3)], median: bool) -> BTreeMap<(usize, usize), Vec3> {
    let mut by_mark: BTreeMap<(usize, usize), Vec<Vec3>> = BTreeMap::new();
    for (key, e) in residuals {
        by_mark.entry(key.2).or_default().push(*e);
    }
    let cases = by_mark.values().map(Vec::len).max().unwrap_or(0);
    if cases < 3 {
        return BTreeMap::new();
    }
    let centre = |list: Vec<Vec3>| {
        Vec3::from_fn(|axis, _| {
            let mut values: Vec<f64> = list.iter().map(|e| e[axis]).collect();
            if median {
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            } else {
                values.iter().sum::<f64>() / values.len() as f64
            }
        })
    };
    by_mark
        .into_iter()
        .map(|(key, list)| (key, centre(list)))
        .collect()
}

/// How the marks of a part in a case look.
enum Looks {
    /// As one rigid part.
    Fine,
    /// The others, which agree among themselves, show this one to be wrong, by so much.
    Wrong(usize, Vec3),
    /// No single one is.
    Mixed,
}

/// Looks for a wrong mark in a block.
fn worst(
    measurement: &Measurement,
    block: &Block,
    centre: &BTreeMap<(usize, usize), Vec3>,
    sigma: f64,
) -> Looks {
    let count = block.readings.len();
    if count < 3 {
        return Looks::Fine;
    }
    let marks = &measurement.cases[block.case].marks;
    let read: Vec<_> = block.readings.iter().map(|k| marks[*k]).collect();
    let local = |mark: usize| {
        let shift = centre.get(&(block.part, mark)).copied().unwrap_or_default();
        measurement.parts[block.part].marks[mark].p + shift
    };
    let on_part: Vec<Vec3> = read.iter().map(|mark| local(mark.mark)).collect();
    let measured: Vec<Vec3> = read.iter().map(|mark| mark.x).collect();
    let Ok(all) = absolute_orientation(&on_part, &measured, 1.0) else {
        return Looks::Fine;
    };
    let largest = all.residuals.iter().map(Vec3::amax).fold(0.0, f64::max);
    let usual = sigma * (1.0 - 6.0 / (3.0 * count as f64)).sqrt();
    if count == 3 {
        // Three marks show that one is wrong along their plane, but not which.
        return if largest > 2.0 * SUSPECT * usual {
            Looks::Mixed
        } else {
            Looks::Fine
        };
    }
    if largest < SUSPECT * usual {
        return Looks::Fine;
    }
    let mut best: Option<(f64, usize, Vec3)> = None;
    for out in 0..count {
        let keep = |list: &[Vec3]| -> Vec<Vec3> {
            let kept = list.iter().enumerate().filter(|(k, _)| *k != out);
            kept.map(|(_, v)| *v).collect()
        };
        let Ok(fit) = absolute_orientation(&keep(&on_part), &keep(&measured), 1.0) else {
            continue;
        };
        let rest: f64 = fit.residuals.iter().map(Vec3::norm_squared).sum();
        if best.as_ref().is_none_or(|(least, ..)| rest < *least) {
            let error = measured[out] - fit.pose.point(&on_part[out]);
            best = Some((rest, out, error));
        }
    }
    let Some((rest, at, error)) = best else {
        return Looks::Fine;
    };
    let freedom = (3 * (count - 1) - 6) as f64;
    let agree = rest < AGREE * freedom * sigma * sigma;
    match (agree, error.amax() > OUTLIER * sigma) {
        (true, true) => Looks::Wrong(at, error),
        // Noise with tails has such blocks, too; only what is far out is kept from the fit.
        (false, _) if largest > 2.0 * SUSPECT * sigma => Looks::Mixed,
        _ => Looks::Fine,
    }
}
