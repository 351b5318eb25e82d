//! Noise of the marks that deviates from the normal distribution with the declared standard deviation: heavy tails, outliers and a wrong
//! declaration.

use super::effect::{EffectSpec, GroundTruth};
use admire_study::Noise;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Deviations of the noise of the marks (measured points) from the normal distribution with the declared standard deviation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Scatter {
    /// Degrees of freedom of the Student t distribution of the noise, whose scale is the standard deviation of the study; infinite for a normal
    /// distribution.
    pub tails: f64,
    /// Number of outliers among the mark readings.
    pub outliers: usize,
    /// Magnitude of the error of each outlier, in the deck's length unit. Its direction is random.
    pub outlier_size: f64,
    /// Ratio of the standard deviation that the new study declares to the actual one.
    pub declared: f64,
}

impl Default for Scatter {
    fn default() -> Self {
        Self {
            tails: f64::INFINITY,
            outliers: 0,
            outlier_size: 2.0,
            declared: 1.0,
        }
    }
}

impl Scatter {
    /// Parses a text such as `tails=3,outliers=6,outlier_size=2,declared=0.5`. Values that are not given keep their defaults.
    ///
    /// # Errors
    /// Returns a `bad-effect` diagnostic if the text does not have this form.
    pub fn parse(text: &str) -> Result<Self, Diagnostic> {
        let mut scatter = Self::default();
        for item in text.split(',').filter(|item| !item.trim().is_empty()) {
            let (name, value) = item.split_once('=').unwrap_or((item, ""));
            let size = value.trim().parse::<f64>().ok();
            let Some(size) = size.filter(|size| *size > 0.0) else {
                return Err(refuse(item));
            };
            match name.trim() {
                "tails" => scatter.tails = size,
                "outliers" if size.fract() == 0.0 && size < 1e6 => scatter.outliers = size as usize,
                "outlier_size" if size.is_finite() => scatter.outlier_size = size,
                "declared" if size.is_finite() => scatter.declared = size,
                _ => return Err(refuse(item)),
            }
        }
        Ok(scatter)
    }

    /// Draws the outliers as `mark-outlier` effects, at most one per mark and case.
    ///
    /// # Errors
    /// Returns a `bad-effect` diagnostic if more outliers are requested than there are mark readings.
    pub(super) fn drawn(
        &self,
        seed: u64,
        reality: &GroundTruth,
    ) -> Result<Vec<EffectSpec>, Diagnostic> {
        let mut places: Vec<(usize, usize, usize)> = Vec::new();
        for case in 0..reality.programme.cases.len() {
            for (part, marked) in reality.marks.iter().enumerate() {
                places.extend((0..marked.labels.len()).map(|mark| (case, part, mark)));
            }
        }
        let mut noise = Noise::new(seed, "outliers");
        let mut specs = Vec::new();
        for _ in 0..self.outliers {
            if places.is_empty() {
                return Err(Diagnostic::error(
                    Code::BadEffect,
                    format!(
                        "the number of readings is smaller than the number of outliers, {}",
                        self.outliers
                    ),
                ));
            }
            let (case, part, mark) = places.swap_remove(noise.below(places.len()));
            let shift = noise.vector(1.0).normalize() * self.outlier_size;
            let marked = &reality.marks[part];
            specs.push(EffectSpec::parse(&format!(
                "mark-outlier@case {} {} {}:x={:e},y={:e},z={:e}",
                reality.programme.cases[case].label,
                marked.name,
                marked.labels[mark],
                shift.x,
                shift.y,
                shift.z
            ))?);
        }
        Ok(specs)
    }
}

fn refuse(item: &str) -> Diagnostic {
    Diagnostic::error(
        Code::BadEffect,
        format!("`{item}` is not a setting of the mark scatter"),
    )
    .help("for example tails=3,outliers=6,outlier_size=2,declared=0.5")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_numbers_and_their_ranges() {
        let found = Scatter::parse("tails=3, declared=0.5").unwrap();
        assert_eq!((found.tails, found.declared, found.outliers), (3.0, 0.5, 0));
        for text in [
            "tails",
            "outliers=1.5",
            "declared=0",
            "noise=1",
            "tails=NaN",
        ] {
            assert!(Scatter::parse(text).is_err(), "{text}");
        }
    }
}
