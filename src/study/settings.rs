use std::ops::RangeInclusive;

use super::section::{Section, SpannedText};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::{Dimension, Units};

const ANY: RangeInclusive<f64> = 0.0..=f64::INFINITY;
const POSITIVE: RangeInclusive<f64> = f64::MIN_POSITIVE..=f64::INFINITY;
/// Standard deviation of a reading of a wheel.
const WHEEL_SD: RangeInclusive<f64> = 1e-12..=f64::INFINITY;

/// Solver of a study.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BackendChoice {
    /// The built-in solver.
    Native,
    /// Any program with ADAMS' command line.
    Command,
    /// Recorded runs of such a program.
    Replay,
}

/// Settings of `[solver]`.
#[derive(Clone, PartialEq, Debug)]
pub struct SolverSettings {
    /// Choice of the solver.
    pub backend: BackendChoice,
    /// Program and arguments; `{acf}` stands for the command file.
    pub command: Vec<String>,
    /// Seconds after which a run is killed.
    pub timeout_s: f64,
    /// Seconds during which a refused licence is requested again.
    pub licence_wait_s: f64,
    /// Number of parallel runs.
    pub jobs: usize,
    /// Folder of recorded runs below the study, filled by `admire record` and read by the backend `replay`.
    pub recordings: SpannedText,
}

impl SolverSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let words = [
            ("native", BackendChoice::Native),
            ("command", BackendChoice::Command),
            ("replay", BackendChoice::Replay),
        ];
        let command = section.texts("command", out).map_or_else(
            || {
                ["mdi", "-c", "ru-standard", "i", "{acf}", "exit"]
                    .map(String::from)
                    .to_vec()
            },
            |texts| texts.into_iter().map(|spelled| spelled.text).collect(),
        );
        if command.is_empty() {
            section.wrong(
                "command",
                section.span(),
                "a program and its arguments",
                out,
            );
        }
        Self {
            backend: section.choice("backend", BackendChoice::Native, &words, out),
            command,
            timeout_s: section.number("timeout_s", 600.0, 1e-3..=1e9, out),
            licence_wait_s: section.number("licence_wait_s", 300.0, 0.0..=1e9, out),
            jobs: section.count("jobs", 1, 1..=1024, out),
            recordings: section
                .text("recordings", out)
                .unwrap_or_else(|| SpannedText {
                    text: "recorded".to_string(),
                    span: section.span(),
                }),
        }
    }
}

/// Symmetry that reduces the stiffnesses of a bushing.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Symmetry {
    /// Six independent stiffnesses.
    #[default]
    None,
    /// Kx = Ky and KTx = KTy.
    RadialZ,
}

/// Identification method.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// Least-squares fit of all readings, with exact sensitivities.
    #[default]
    GaussNewton,
    /// The iterative regression of the paper.
    Regression,
    /// Equilibrium equations at the measured poses, without a solver run.
    Direct,
}

impl Method {
    /// Returns the keyword of guide/study.md.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::GaussNewton => "gauss-newton",
            Self::Regression => "regression",
            Self::Direct => "direct",
        }
    }
}

/// A number with a default.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Amount {
    /// Value stated in the study, in units of the deck.
    Stated(f64),
    /// Default value, in newtons and millimetres.
    Usual(f64),
}

impl Amount {
    /// Reads a number of a section, or takes the default `usual`.
    fn read(
        section: &mut Section<'_>,
        key: &'static str,
        usual: f64,
        range: RangeInclusive<f64>,
        out: &mut Vec<Diagnostic>,
    ) -> Self {
        let stated = section.optional_number(key, range, out);
        stated.map_or(Self::Usual(usual), Self::Stated)
    }

    /// Converts the number to units of a deck.
    pub fn in_units(self, units: &Units, dimension: Dimension) -> f64 {
        match self {
            Self::Stated(value) => value,
            // Millimetres and newtons are the units of a deck that states none.
            Self::Usual(value) => value * (Units::default().si(dimension) / units.si(dimension)),
        }
    }
}

/// Initial values of the stiffnesses.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Initial {
    /// The deck's own values.
    Deck,
    /// One value for all translational stiffnesses and one for all rotational stiffnesses.
    Values {
        /// Translational stiffness, force per length.
        translational: Amount,
        /// Rotational stiffness, torque per degree.
        rotational_per_degree: Amount,
    },
}

/// Prior standard deviations of a shift and a rotation; zero switches the component off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ShiftSd {
    /// Standard deviation of each translation.
    pub length: Amount,
    /// Standard deviation of each rotation, in degrees.
    pub angle_deg: f64,
}

impl ShiftSd {
    /// Returns the standard deviation along an axis (0 to 2, in length units of a deck) or about an axis (3 to 5, in radians).
    pub fn of_axis(self, axis: usize, units: &Units) -> f64 {
        if axis < 3 {
            self.length.in_units(units, Dimension::LENGTH)
        } else {
            self.angle_deg.to_radians()
        }
    }
}

/// Loss function applied to the residuals.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Loss {
    /// Squared residuals.
    Gaussian,
    /// Squared residuals up to a few standard deviations, linear beyond.
    Huber,
}

/// Method by which a diagnosis selects the causes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Selection {
    /// Stepwise: causes are added, dropped and exchanged one at a time.
    #[default]
    Stepwise,
    /// Closure: all sets of causes near the best one in the linear model are confirmed by fits. Experimental.
    Closure,
}

impl Selection {
    /// Reads `[diagnosis]`.
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let words = [("stepwise", Self::Stepwise), ("closure", Self::Closure)];
        section.choice("selection", Self::default(), &words, out)
    }
}

/// Settings of `[identify]`.
#[derive(Clone, PartialEq, Debug)]
pub struct IdentifySettings {
    /// Addresses of bushings; every BUSHING of the deck if absent.
    pub bushings: Option<Vec<SpannedText>>,
    /// Addresses of other numbers to identify.
    pub stiffnesses: Vec<SpannedText>,
    /// Symmetry of the bushings without an entry of their own.
    pub symmetry: Symmetry,
    /// Symmetry of individual bushings.
    pub symmetry_of: Vec<(SpannedText, Symmetry)>,
    /// Identification method.
    pub method: Method,
    /// Initial values of the stiffnesses.
    pub initial: Initial,
    /// Standard deviation of ln K in the lognormal prior around the initial value.
    pub prior_log_sd: f64,
    /// Prior standard deviation of the assembly offset of each bushing.
    pub offset_sd: ShiftSd,
    /// Prior standard deviation of a shift of the measuring frame in each case.
    pub frame_sd: ShiftSd,
    /// Loss function of the residuals.
    pub loss: Loss,
}

impl IdentifySettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let methods = [Method::GaussNewton, Method::Regression, Method::Direct]
            .map(|method| (method.as_str(), method));
        let initial = if section.is_text("initial") {
            section.choice("initial", Initial::Deck, &[("deck", Initial::Deck)], out)
        } else {
            let mut initial = section.section("initial", out);
            let values = Initial::Values {
                translational: Amount::read(&mut initial, "translational", 1e4, POSITIVE, out),
                rotational_per_degree: Amount::read(
                    &mut initial,
                    "rotational_per_degree",
                    1e4,
                    POSITIVE,
                    out,
                ),
            };
            initial.finish(out);
            values
        };
        let mut symmetry = Symmetry::None;
        let mut symmetry_of = Vec::new();
        let mut symmetries = section.section("symmetry", out);
        for (bushing, word) in symmetries.all_texts(out) {
            let kind = match word.text.as_str() {
                "none" => Symmetry::None,
                "radial-z" => Symmetry::RadialZ,
                _ => {
                    let expected = "\"none\" or \"radial-z\"";
                    symmetries.wrong(&bushing.text, word.span, expected, out);
                    continue;
                }
            };
            if bushing.text == "default" {
                symmetry = kind;
            } else {
                symmetry_of.push((bushing, kind));
            }
        }
        Self {
            bushings: section.texts("bushings", out),
            stiffnesses: section.texts("stiffnesses", out).unwrap_or_default(),
            symmetry,
            symmetry_of,
            method: section.choice("method", Method::default(), &methods, out),
            initial,
            prior_log_sd: section.number("prior_log_sd", 3.0, 1e-9..=1e9, out),
            offset_sd: shift_sd(section, "offset_sd", (0.5, 0.5), out),
            frame_sd: shift_sd(section, "frame_sd", (0.0, 0.0), out),
            loss: section.choice(
                "loss",
                Loss::Gaussian,
                &[("gaussian", Loss::Gaussian), ("huber", Loss::Huber)],
                out,
            ),
        }
    }
}

fn shift_sd(
    section: &mut Section<'_>,
    key: &'static str,
    (length, angle_deg): (f64, f64),
    out: &mut Vec<Diagnostic>,
) -> ShiftSd {
    let mut inner = section.section(key, out);
    let sd = ShiftSd {
        length: Amount::read(&mut inner, "length", length, ANY, out),
        angle_deg: inner.number("angle_deg", angle_deg, ANY, out),
    };
    inner.finish(out);
    sd
}

/// Form of equation 16: as printed, or with the weights inverted as the text of the paper implies.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Weights {
    /// 1 / sum (F - mean F)^2.
    Printed,
    /// sum (F - mean F)^2.
    Corrected,
}

/// Form of equation 13: as printed, or the inverse regression.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Slope {
    /// cov(F, delta) / var(delta).
    Printed,
    /// var(F) / cov(F, delta), for noise on delta.
    Inverse,
}

/// Settings of `[regression]`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RegressionSettings {
    /// Convergence tolerance of equation 17: the largest relative change at which the loop ends.
    pub epsilon: f64,
    /// Correlation of equation 15 below which a stiffness keeps its previous value.
    pub r_min: f64,
    /// Weights of equation 16.
    pub weights: Weights,
    /// Slope of equation 13.
    pub slope: Slope,
    /// Number of iterations after which the loop stops.
    pub max_iterations: usize,
}

impl Default for RegressionSettings {
    fn default() -> Self {
        Self {
            epsilon: 0.01,
            r_min: 0.75,
            weights: Weights::Printed,
            slope: Slope::Printed,
            max_iterations: 200,
        }
    }
}

impl RegressionSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let default = Self::default();
        let weights = [
            ("printed", Weights::Printed),
            ("corrected", Weights::Corrected),
        ];
        let slopes = [("printed", Slope::Printed), ("inverse", Slope::Inverse)];
        Self {
            epsilon: section.number("epsilon", default.epsilon, 1e-12..=1.0, out),
            r_min: section.number("r_min", default.r_min, -1.0..=1.0, out),
            weights: section.choice("weights", default.weights, &weights, out),
            slope: section.choice("slope", default.slope, &slopes, out),
            max_iterations: section.count(
                "max_iterations",
                default.max_iterations,
                1..=1_000_000,
                out,
            ),
        }
    }
}

/// Spin axis among the axes of the wheel marker.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SpinAxis {
    /// Axis of the marker: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Sense of the axis, +1 or -1, if the study states it. Otherwise the axis points outboard at design.
    pub sign: Option<i8>,
}

impl SpinAxis {
    /// Reads `axis`, with or without a sign; the default is `"y"`.
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let words = ["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"];
        let axes = std::array::from_fn::<_, 9, _>(|at| {
            let sign = [None, Some(1), Some(-1)][at / 3];
            (words[at], Self { axis: at % 3, sign })
        });
        section.choice("axis", axes[1].1, &axes, out)
    }
}

/// Settings of `[wheel]` without the readings.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelSettings {
    /// Marker on the wheel carrier.
    pub marker: SpannedText,
    /// Spin axis of this marker.
    pub axis: SpinAxis,
    /// Standard deviation of a coordinate.
    pub sigma_position: Amount,
    /// Standard deviation of an angle, in degrees.
    pub sigma_angle_deg: f64,
}

impl WheelSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Option<Self> {
        let marker = section.text("marker", out);
        let axis = SpinAxis::read(section, out);
        let mut sigma = section.section("sigma", out);
        let (sigma_position, sigma_angle_deg) = (
            Amount::read(&mut sigma, "position", 0.05, WHEEL_SD, out),
            sigma.number("angle_deg", 0.01, WHEEL_SD, out),
        );
        sigma.finish(out);
        let Some(marker) = marker else {
            section.wrong("marker", section.span(), "given: the wheel's marker", out);
            return None;
        };
        Some(Self {
            marker,
            axis,
            sigma_position,
            sigma_angle_deg,
        })
    }
}

/// Settings of one channel in `[readings.channels]`.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelSettings {
    /// Name of the channel and of its column.
    pub name: String,
    /// ADAMS function of the deck.
    pub function: SpannedText,
    /// Standard deviation of one reading; estimated from the fit if it is not given.
    pub sigma: Option<f64>,
    /// Unit of the readings, for reports.
    pub unit: Option<String>,
    /// Case whose value is subtracted: its label, or `previous`.
    pub relative_to: Option<SpannedText>,
}

impl ChannelSettings {
    pub(super) fn read(
        name: &SpannedText,
        section: &mut Section<'_>,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let function = section.text("function", out);
        let sigma = section.optional_number("sigma", 1e-300..=f64::INFINITY, out);
        let unit = section.text("unit", out).map(|spelled| spelled.text);
        let relative_to = section.text("relative_to", out);
        let Some(function) = function else {
            out.push(
                Diagnostic::error(
                    Code::MissingSetting,
                    format!("channel `{}` needs `function`", name.text),
                )
                .label(section.file(), name.span, ""),
            );
            return None;
        };
        Some(Self {
            name: name.text.clone(),
            function,
            sigma,
            unit,
            relative_to,
        })
    }
}
