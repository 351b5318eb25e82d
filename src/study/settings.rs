use std::ops::RangeInclusive;

use super::section::{Section, SpannedText};
use super::unknown_settings::UnknownSettings;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::{Dimension, Units};

const ANY: RangeInclusive<f64> = 0.0..=f64::INFINITY;
const POSITIVE: RangeInclusive<f64> = f64::MIN_POSITIVE..=f64::INFINITY;
/// Allowed range of the standard deviations of wheel readings.
const WHEEL_SD: RangeInclusive<f64> = 1e-12..=f64::INFINITY;

/// Choice of the solver of a study.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BackendChoice {
    /// The built-in solver.
    Native,
    /// An external program that takes the command line of ADAMS.
    Command,
    /// Recorded runs of an external program.
    Replay,
}

/// Settings of section `[solver]`.
#[derive(Clone, PartialEq, Debug)]
pub struct SolverSettings {
    /// Choice of the solver.
    pub backend: BackendChoice,
    /// External program and its arguments. The argument `{acf}` is replaced by the path of the command file.
    pub command: Vec<String>,
    /// Time after which a run of the external program is killed, in seconds.
    pub timeout_s: f64,
    /// Time during which a refused licence is requested again, in seconds.
    pub licence_wait_s: f64,
    /// Number of solver runs in parallel.
    pub jobs: usize,
    /// Folder of the recorded runs, inside the study folder. `admire record` fills it, and the backend `replay` reads it.
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

/// Symmetry of a bushing, which reduces the number of its independent stiffnesses.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Symmetry {
    /// Six independent stiffnesses.
    #[default]
    None,
    /// Rotational symmetry about z: Kx = Ky and KTx = KTy.
    RadialZ,
}

/// Identification method.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// Gauss-Newton fit of all readings.
    #[default]
    GaussNewton,
    /// Iterative regression by the method of the paper (see guide page `paper`).
    Regression,
    /// Solution of the equilibrium equations at the measured poses, without solver runs.
    Direct,
}

impl Method {
    /// Returns the keyword of the method in `study.toml`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::GaussNewton => "gauss-newton",
            Self::Regression => "regression",
            Self::Direct => "direct",
        }
    }
}

/// A dimensional setting with a default value.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Amount {
    /// Value stated in the study, in the units of the deck.
    Stated(f64),
    /// Default value, in newtons and millimetres.
    Usual(f64),
}

impl Amount {
    /// Reads a setting from a section. If the key is absent, returns the default `usual`.
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

    /// Returns the value in the units of a deck.
    pub fn in_units(self, units: &Units, dimension: Dimension) -> f64 {
        match self {
            Self::Stated(value) => value,
            // Millimetres and newtons are also the default units of a deck, given by Units::default.
            Self::Usual(value) => value * (Units::default().si(dimension) / units.si(dimension)),
        }
    }
}

/// Initial values of the bushing stiffnesses.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Initial {
    /// The values in the deck.
    Deck,
    /// One value for all translational stiffnesses and one for all rotational stiffnesses.
    Values {
        /// Initial translational stiffness, force per length.
        translational: Amount,
        /// Initial rotational stiffness, torque per degree.
        rotational_per_degree: Amount,
    },
}

/// Prior standard deviations of an unknown translation and rotation. Zero switches the component off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ShiftSd {
    /// Standard deviation of the translation along each axis.
    pub length: Amount,
    /// Standard deviation of the rotation about each axis, in degrees.
    pub angle_deg: f64,
}

impl ShiftSd {
    /// Returns the standard deviation of one component. Axes 0 to 2 are translations in the length unit of the deck, axes 3 to 5 are rotations
    /// in radians.
    pub fn of_axis(self, axis: usize, units: &Units) -> f64 {
        if axis < 3 {
            self.length.in_units(units, Dimension::LENGTH)
        } else {
            self.angle_deg.to_radians()
        }
    }
}

/// Loss function that a fit applies to the residuals.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Loss {
    /// Squared residuals, as for Gaussian noise.
    Gaussian,
    /// Huber's loss: quadratic in small residuals, and linear in residuals above 1.345 standard deviations.
    Huber,
}

/// Settings of section `[identify]`.
#[derive(Clone, PartialEq, Debug)]
pub struct IdentifySettings {
    /// Addresses of the bushings to identify; `None` for every BUSHING of the deck.
    pub bushings: Option<Vec<SpannedText>>,
    /// Addresses of further parameters to identify.
    pub stiffnesses: Vec<SpannedText>,
    /// Symmetry of all bushings that are not listed in `symmetry_of`.
    pub symmetry: Symmetry,
    /// Bushings with an explicitly stated symmetry.
    pub symmetry_of: Vec<(SpannedText, Symmetry)>,
    /// Identification method.
    pub method: Method,
    /// Initial values of the stiffnesses.
    pub initial: Initial,
    /// Standard deviation of ln K in the lognormal prior of each stiffness K, whose median is the initial value.
    pub prior_log_sd: f64,
    /// Prior standard deviations of the assembly offset of each bushing.
    pub offset_sd: ShiftSd,
    /// Prior standard deviations of the displacement of the measuring frame in each case.
    pub frame_sd: ShiftSd,
    /// Loss function of the residuals.
    pub loss: Loss,
    /// Further numbers of the deck to identify: tables `[[identify.unknown]]`.
    pub unknowns: Vec<UnknownSettings>,
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
            unknowns: UnknownSettings::read_all(section, out),
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

/// Weights of equation 16 of the paper, which averages the stiffnesses of a round bushing. The weights are as printed, or inverted as the text of the
/// paper implies.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Weights {
    /// Weight as printed: `1 / sum (F - mean F)^2`.
    Printed,
    /// Corrected weight: `sum (F - mean F)^2`.
    Corrected,
}

/// Slope of the regression line of force F against deflection delta (equation 13 of the paper). The slope is as printed, or from inverse regression.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Slope {
    /// Slope as printed: `cov(F, delta) / var(delta)`.
    Printed,
    /// Slope of the inverse regression, which is unbiased by noise on delta: `var(F) / cov(F, delta)`.
    Inverse,
}

/// Settings of section `[regression]`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RegressionSettings {
    /// Convergence tolerance of equation 17: the iteration ends if no stiffness changes by more than this fraction.
    pub epsilon: f64,
    /// Correlation of force and deflection (equation 15) up to which a stiffness keeps its previous value.
    pub r_min: f64,
    /// Form of the weights of equation 16.
    pub weights: Weights,
    /// Form of the slope of equation 13.
    pub slope: Slope,
    /// Maximum number of iterations.
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

/// Spin axis of a wheel, chosen among the axes of the wheel marker.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SpinAxis {
    /// Axis of the wheel marker: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Sense of the spin axis relative to the marker axis, +1 or -1, if the study states it. If it is `None`, the spin axis points outboard in
    /// the design position.
    pub sign: Option<i8>,
}

impl SpinAxis {
    /// Reads the key `axis`, an axis name with or without a sign. The default is `"y"`.
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let words = ["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"];
        let axes = std::array::from_fn::<_, 9, _>(|at| {
            let sign = [None, Some(1), Some(-1)][at / 3];
            (words[at], Self { axis: at % 3, sign })
        });
        section.choice("axis", axes[1].1, &axes, out)
    }
}

/// Settings of section `[wheel]`, without the readings.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelSettings {
    /// Marker on the wheel carrier.
    pub marker: SpannedText,
    /// Spin axis of the wheel, as an axis of this marker.
    pub axis: SpinAxis,
    /// Standard deviation of the wheel position, per coordinate.
    pub sigma_position: Amount,
    /// Standard deviation of camber and steer, in degrees.
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
            section.missing_marker(out);
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

/// Settings of one channel (scalar sensor) in `[readings.channels]`.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelSettings {
    /// Name of the channel, which is also the name of its column.
    pub name: String,
    /// ADAMS function expression that the channel measures.
    pub function: SpannedText,
    /// Standard deviation of one reading. If it is not given, it is estimated from the residuals of a fit.
    pub sigma: Option<f64>,
    /// Unit of the readings, for reports.
    pub unit: Option<String>,
    /// Label of the case whose value is subtracted from each reading, or `previous` for the preceding case.
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
                .label(section.file(), name.span, "")
                .help("give the reading as an ADAMS function, for example function = \"DZ(11)\""),
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
