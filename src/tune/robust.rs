//! Share of axles that meet the goals if the axles scatter by the tolerances of the study.

use std::ops::Range;

use crate::evaluation::{Evaluator, Scatter};
use crate::goal::Goal;
use crate::settings::{LINEAR_DRAWS, ROBUST_SD, TIGHTENED, TOLERANCE_SEED};
use crate::tuning::Tuning;
use admire_identify::tolerance::EffectGroup;
use admire_study::Noise;
use nalgebra::DVector;
use serde::Serialize;

/// Effect of the tolerances of a study on a deck. An axle counts as good if every miss is within the tolerance of its goal and all limits
/// hold.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Robust {
    /// Share of axles that meet all goals, in the linear model.
    pub share: f64,
    /// Statistics of the drawn axles; `None` if none were requested.
    pub drawn: Option<DrawnAxles>,
    /// True if all goals are met at two standard deviations to either side of the mean, in the linear model.
    pub met_two_sd: bool,
    /// Scatter of each goal, in the order of the goals.
    pub goals: Vec<GoalSpread>,
    /// Tolerances of hardpoints and elements. The first is the one whose reduction increases the share of good axles most.
    pub tolerances: Vec<ToleranceShare>,
}

/// Statistics of axles with drawn tolerances, each solved as a separate deck.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct DrawnAxles {
    /// Number of axles.
    pub count: usize,
    /// Number of axles without an equilibrium. They count as not meeting the goals.
    pub failed: usize,
    /// Share of axles that meet all goals.
    pub share: f64,
    /// Standard deviation of the share that results from the finite number of axles. It is estimated after adding one good and one bad
    /// axle.
    pub share_sd: f64,
    /// True if all goals are met at two standard deviations of the drawn axles to either side of their mean.
    pub met_two_sd: bool,
}

/// Scatter of a goal's values that the tolerances cause, in the unit of the goal.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct GoalSpread {
    /// Name of the goal.
    pub name: String,
    /// Share of axles that meet the goal, in the linear model.
    pub share: f64,
    /// Share of the drawn axles that meet the goal; `None` if none were drawn.
    pub share_drawn: Option<f64>,
    /// Largest standard deviation of a value, in the linear model.
    pub sd: f64,
    /// Largest standard deviation of a value over the drawn axles; `None` if fewer than two were solved.
    pub sd_drawn: Option<f64>,
    /// Largest miss within two standard deviations of the mean, in the linear model.
    pub two_sd: f64,
    /// True if the goal is met at two standard deviations to either side of the mean, in the linear model.
    pub is_met_two_sd: bool,
    /// Like `is_met_two_sd`, but with the mean and standard deviations of the drawn axles; `None` if fewer than two were solved.
    pub is_met_two_sd_drawn: Option<bool>,
}

/// Effect of the tolerance of a hardpoint or element on the goals.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ToleranceShare {
    /// Group of the tolerance: `hardpoints`, `assembly-offsets`, `axes`, `spring-preloads`, `spring-rates` or `known-stiffnesses`.
    pub group: &'static str,
    /// Address of the element, or of one marker of the hardpoint.
    pub element: String,
    /// Standard deviation of the tolerance.
    pub sd: f64,
    /// Unit of the standard deviation; `%` for a relative tolerance.
    pub unit: String,
    /// Fraction of the variance of all values that this tolerance causes. Values are in units of the tolerances of their goals, and all
    /// goals have equal weight.
    pub variance: f64,
    /// Share of axles that meet all goals if the standard deviation is halved, in the linear model.
    pub share_if_halved: f64,
}

impl ToleranceShare {
    /// Returns a description of the object that has the tolerance.
    pub fn name(&self) -> String {
        let what = match self.group {
            "hardpoints" => "hardpoint",
            "assembly-offsets" => "offset of",
            "axes" => "axes of",
            "spring-preloads" => "force of",
            "spring-rates" => "rate of",
            _ => "stiffnesses of",
        };
        format!("{what} {}", self.element)
    }
}

/// Tolerances of one group at one hardpoint or element.
struct Item {
    group: EffectGroup,
    element: String,
    sd: f64,
    /// Indices of the columns of these tolerances in [`Scatter::columns`].
    columns: Vec<usize>,
}

impl Tuning {
    /// Returns the effect of the tolerances of the study on the deck at the coordinates `x` of the unknowns. It is computed with the linear
    /// model, and with `draws` decks with drawn tolerances. Returns `None` if the study has no section `[tolerances]`, or if the deck has
    /// no equilibrium.
    ///
    /// `watch` receives the number of axles drawn so far. It returns false to stop drawing.
    pub fn robust(
        &self,
        x: &[f64],
        draws: usize,
        watch: &mut dyn FnMut(usize) -> bool,
    ) -> Option<Robust> {
        if !self.study.tolerances.is_stated {
            return None;
        }
        let mut evaluator = Evaluator::new(self);
        let scatter = evaluator.scattered(x)?;
        let items = items(&scatter);
        let linear = self.linear(&scatter, &items);
        let drawn = self.draw(&mut evaluator, &scatter, draws, watch);
        let sd = scatter.sd();
        let goals: Vec<GoalSpread> = self
            .ranges()
            .enumerate()
            .map(|(k, (goal, rows))| {
                let two_sd = two_sd(goal, rows.clone(), &scatter.values, &sd);
                let solved = drawn.as_ref().filter(|drawn| drawn.solved() > 1);
                let largest = |sd: &[f64]| sd[rows.clone()].iter().copied().fold(0.0, f64::max);
                GoalSpread {
                    name: goal.name(),
                    share: linear.goals[k],
                    share_drawn: drawn.as_ref().map(|drawn| drawn.share(drawn.good[k])),
                    sd: largest(&sd),
                    sd_drawn: solved.map(|drawn| largest(&drawn.sd())),
                    two_sd,
                    is_met_two_sd: two_sd <= goal.allowed(),
                    is_met_two_sd_drawn: solved.map(|drawn| two_sd_met(goal, rows.clone(), drawn)),
                }
            })
            .collect();
        let variances = self.variances(&scatter, &items);
        let units = &self.model.units;
        let mut tolerances: Vec<ToleranceShare> = items
            .iter()
            .zip(variances)
            .zip(&linear.halved)
            .map(|((item, variance), share_if_halved)| {
                let (sd, unit) = match item.group {
                    EffectGroup::Hardpoints | EffectGroup::Offsets => {
                        (item.sd, units.name(admire_syntax::units::Dimension::LENGTH))
                    }
                    EffectGroup::Axes => (item.sd.to_degrees(), "deg".to_string()),
                    _ => (100.0 * item.sd, "%".to_string()),
                };
                ToleranceShare {
                    group: item.group.as_str(),
                    element: item.element.clone(),
                    sd,
                    unit,
                    variance,
                    share_if_halved: *share_if_halved,
                }
            })
            .collect();
        tolerances.sort_by(|a, b| {
            let gains = b.share_if_halved.total_cmp(&a.share_if_halved);
            gains.then(b.variance.total_cmp(&a.variance))
        });
        Some(Robust {
            share: linear.all,
            drawn: drawn.map(|drawn| {
                let share = drawn.share(drawn.good_in_all);
                DrawnAxles {
                    count: drawn.count,
                    failed: drawn.failed,
                    share,
                    share_sd: {
                        let n = drawn.count as f64 + 2.0;
                        let p = (drawn.good_in_all as f64 + 1.0) / n;
                        (p * (1.0 - p) / n).sqrt()
                    },
                    met_two_sd: goals
                        .iter()
                        .all(|goal| goal.is_met_two_sd_drawn == Some(true)),
                }
            }),
            met_two_sd: goals.iter().all(|goal| goal.is_met_two_sd),
            goals,
            tolerances,
        })
    }

    /// Returns the shares of good axles in the linear model. For a single value, they follow from the normal distribution; otherwise they
    /// are estimated from random draws.
    fn linear(&self, scatter: &Scatter, items: &[Item]) -> Linear {
        let rows: Vec<(&Goal, Range<usize>)> = self.ranges().collect();
        let count = scatter.tolerances.len();
        let mut noise = Noise::new(TOLERANCE_SEED, "linear tolerances");
        let mut goals = vec![0_usize; rows.len()];
        let (mut all, mut halved) = (0_usize, vec![0_usize; items.len()]);
        let parts: Vec<_> = items
            .iter()
            .map(|item| scatter.columns.select_columns(&item.columns))
            .collect();
        let middle = DVector::from_column_slice(&scatter.values);
        let is_good = |values: &DVector<f64>| {
            let mut each = rows.iter();
            each.all(|(goal, rows)| holds(goal, rows.clone(), values.as_slice()))
        };
        for _ in 0..LINEAR_DRAWS {
            let z: Vec<f64> = (0..count).map(|_| noise.normal()).collect();
            let of = |item: &Item| {
                DVector::from_iterator(item.columns.len(), item.columns.iter().map(|k| z[*k]))
            };
            let moves: Vec<DVector<f64>> = parts
                .iter()
                .zip(items)
                .map(|(part, item)| part * of(item))
                .collect();
            let mut values = middle.clone();
            for own in &moves {
                values += own;
            }
            for ((goal, rows), good) in rows.iter().zip(&mut goals) {
                *good += usize::from(holds(goal, rows.clone(), values.as_slice()));
            }
            all += usize::from(is_good(&values));
            for (own, good) in moves.iter().zip(&mut halved) {
                let tightened = &values - own * (1.0 - TIGHTENED);
                *good += usize::from(is_good(&tightened));
            }
        }
        let share = |good: usize| good as f64 / LINEAR_DRAWS as f64;
        let mut found = Linear {
            all: share(all),
            goals: goals.into_iter().map(share).collect(),
            halved: halved.into_iter().map(share).collect(),
        };
        let sd = scatter.sd();
        for (k, (goal, rows)) in rows.iter().enumerate() {
            if rows.len() == 1 {
                found.goals[k] = normal_share(goal, scatter.values[rows.start], sd[rows.start]);
            }
        }
        if let [(goal, rows)] = rows.as_slice()
            && rows.len() == 1
        {
            found.all = found.goals[0];
            for (item, halved) in items.iter().zip(&mut found.halved) {
                let own = scatter.columns.row(rows.start);
                let part: f64 = item.columns.iter().map(|k| own[*k] * own[*k]).sum();
                let rest = sd[rows.start] * sd[rows.start] - part * (1.0 - TIGHTENED * TIGHTENED);
                *halved = normal_share(goal, scatter.values[rows.start], rest.max(0.0).sqrt());
            }
        }
        found
    }

    /// Solves axles with drawn tolerances. Returns `None` if no axle was drawn.
    fn draw(
        &self,
        evaluator: &mut Evaluator<'_>,
        scatter: &Scatter,
        draws: usize,
        watch: &mut dyn FnMut(usize) -> bool,
    ) -> Option<Drawn> {
        let mut noise = Noise::new(TOLERANCE_SEED, "drawn axles");
        let mut found = Drawn {
            count: 0,
            failed: 0,
            good_in_all: 0,
            good: vec![0; self.goals.len()],
            sum: vec![0.0; scatter.values.len()],
            squares: vec![0.0; scatter.values.len()],
            middle: scatter.values.clone(),
        };
        for k in 0..draws {
            if !watch(k) {
                break;
            }
            let z: Vec<f64> = scatter.tolerances.iter().map(|_| noise.normal()).collect();
            found.count += 1;
            let Some(values) = evaluator.drawn(&scatter.dataset, &scatter.tolerances, &z) else {
                found.failed += 1;
                continue;
            };
            let mut is_good = true;
            for ((goal, rows), good) in self.ranges().zip(&mut found.good) {
                let own = holds(goal, rows, &values);
                *good += usize::from(own);
                is_good &= own;
            }
            found.good_in_all += usize::from(is_good);
            for (row, value) in values.iter().enumerate() {
                let away = value - found.middle[row];
                found.sum[row] += away;
                found.squares[row] += away * away;
            }
        }
        (found.count > 0).then_some(found)
    }

    /// Returns the fraction of the variance of all values that each item causes. Values are in units of the tolerances of their goals.
    fn variances(&self, scatter: &Scatter, items: &[Item]) -> Vec<f64> {
        let of = |item: &Item| {
            let goals = self.ranges().map(|(goal, rows)| {
                let part = scatter.columns.rows(rows.start, rows.len());
                let columns = item.columns.iter();
                let sum: f64 = columns.map(|k| part.column(*k).norm_squared()).sum();
                sum / (goal.tolerance * goal.tolerance * rows.len() as f64)
            });
            goals.sum::<f64>()
        };
        let each: Vec<f64> = items.iter().map(of).collect();
        let all: f64 = each.iter().sum();
        let share = |own: &f64| if all > 0.0 { own / all } else { 0.0 };
        each.iter().map(share).collect()
    }
}

/// Shares of good axles in the linear model.
struct Linear {
    all: f64,
    goals: Vec<f64>,
    /// Share of axles that meet all goals if the standard deviation of one item is halved, for each item.
    halved: Vec<f64>,
}

/// Axles that were drawn and solved.
struct Drawn {
    count: usize,
    failed: usize,
    good_in_all: usize,
    good: Vec<usize>,
    /// Sum over the solved axles of the differences of each value from `middle`.
    sum: Vec<f64>,
    squares: Vec<f64>,
    middle: Vec<f64>,
}

impl Drawn {
    fn solved(&self) -> usize {
        self.count - self.failed
    }

    fn share(&self, good: usize) -> f64 {
        good as f64 / self.count as f64
    }

    fn mean(&self) -> Vec<f64> {
        let each = self.middle.iter().zip(&self.sum);
        each.map(|(middle, sum)| middle + sum / self.solved() as f64)
            .collect()
    }

    fn sd(&self) -> Vec<f64> {
        let n = self.solved() as f64;
        let each = self.sum.iter().zip(&self.squares);
        each.map(|(sum, squares)| ((squares - sum * sum / n) / (n - 1.0)).max(0.0).sqrt())
            .collect()
    }
}

/// Groups the tolerances by hardpoint and element.
fn items(scatter: &Scatter) -> Vec<Item> {
    let mut all: Vec<Item> = Vec::new();
    for (k, own) in scatter.tolerances.iter().enumerate() {
        let same = |item: &&mut Item| item.group == own.group && item.element == own.element;
        match all.iter_mut().find(same) {
            Some(item) => item.columns.push(k),
            None => all.push(Item {
                group: own.group,
                element: own.element.clone(),
                sd: own.sd,
                columns: vec![k],
            }),
        }
    }
    all
}

/// Returns true if the values of the rows meet the goal.
fn holds(goal: &Goal, rows: Range<usize>, values: &[f64]) -> bool {
    let mut each = goal.rows.iter().zip(&values[rows]);
    each.all(|(own, value)| own.miss(*value).abs() <= goal.allowed())
}

/// Returns the largest miss of a goal within two standard deviations of the mean.
fn two_sd(goal: &Goal, rows: Range<usize>, mean: &[f64], sd: &[f64]) -> f64 {
    let each = goal.rows.iter().zip(rows);
    each.map(|(own, row)| own.reach(mean[row], ROBUST_SD * sd[row]))
        .fold(0.0, f64::max)
}

fn two_sd_met(goal: &Goal, rows: Range<usize>, drawn: &Drawn) -> bool {
    two_sd(goal, rows, &drawn.mean(), &drawn.sd()) <= goal.allowed()
}

/// Returns the probability that the only value of a goal meets the goal if it is normally distributed.
fn normal_share(goal: &Goal, mean: f64, sd: f64) -> f64 {
    let [least, most] = goal.rows[0].wanted;
    let (least, most) = (least - goal.allowed(), most + goal.allowed());
    if sd == 0.0 {
        return f64::from(u8::from((least..=most).contains(&mean)));
    }
    let below = |value: f64| 0.5 * libm::erfc((mean - value) / (sd * std::f64::consts::SQRT_2));
    below(most) - below(least)
}
