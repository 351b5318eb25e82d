use super::section::{Section, SpannedText};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::{Dimension, Units};

const ANY: (f64, f64) = (0.0, f64::INFINITY);

/// Who solves.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BackendChoice {
    /// The built-in solver.
    Native,
    /// Any program with ADAMS' command line.
    Command,
    /// Recorded runs of such a program.
    Replay,
}

/// `[solver]`.
#[derive(Clone, PartialEq, Debug)]
pub struct SolverSettings {
    /// Who solves.
    pub backend: BackendChoice,
    /// Program and arguments; `{acf}` stands for the command file.
    pub command: Vec<String>,
    /// Seconds after which a run is killed.
    pub timeout_s: f64,
    /// Seconds for which a licence that is refused is asked for again.
    pub licence_wait_s: f64,
    /// Parallel runs.
    pub jobs: usize,
    /// Folder of recorded runs below the study: what `admire record` fills and backend `replay` serves.
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
            timeout_s: section.number("timeout_s", 600.0, (1e-3, 1e9), out),
            licence_wait_s: section.number("licence_wait_s", 300.0, (0.0, 1e9), out),
            jobs: section.count("jobs", 1, (1, 1024), out),
            recordings: section
                .text("recordings", out)
                .unwrap_or_else(|| SpannedText {
                    text: "recorded".to_string(),
                    span: section.span(),
                }),
        }
    }
}

/// How bushings are reduced.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Symmetry {
    /// Six stiffnesses.
    #[default]
    None,
    /// Kx = Ky and KTx = KTy.
    RadialZ,
}

/// What identifies.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// Fit of everything that was read, with exact sensitivities.
    #[default]
    GaussNewton,
    /// The paper's loop.
    Regression,
    /// Equilibrium of the measured poses, no solver run.
    Direct,
}

impl Method {
    /// The word of guide/study.md.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::GaussNewton => "gauss-newton",
            Self::Regression => "regression",
            Self::Direct => "direct",
        }
    }
}

/// A number that may be left out.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Amount {
    /// As the study states it, in units of the deck.
    Stated(f64),
    /// The usual one, in newton and millimetre.
    Usual(f64),
}

impl Amount {
    /// A number of a section, or the usual one.
    fn read(
        section: &mut Section<'_>,
        key: &'static str,
        usual: f64,
        range: (f64, f64),
        out: &mut Vec<Diagnostic>,
    ) -> Self {
        let stated = section.optional_number(key, range, out);
        stated.map_or(Self::Usual(usual), Self::Stated)
    }

    /// In units of a deck.
    pub fn in_units(self, units: &Units, dimension: Dimension) -> f64 {
        match self {
            Self::Stated(value) => value,
            // Millimetre and newton are the units of a deck that states none.
            Self::Usual(value) => value * (Units::default().si(dimension) / units.si(dimension)),
        }
    }
}

/// Where stiffnesses start.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Initial {
    /// The deck's own values.
    Deck,
    /// One value for all translational ones (force/length), one for all rotational ones (torque per degree).
    Values {
        /// Force per length.
        translational: Amount,
        /// Torque per degree.
        rotational_per_degree: Amount,
    },
}

/// A prior standard deviation of a shift and a turn; zero switches it off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ShiftSd {
    /// Of each translation.
    pub length: Amount,
    /// Of each rotation, in degrees.
    pub angle_deg: f64,
}

impl ShiftSd {
    /// Along an axis (0 to 2, in length units of a deck) or about one (3 to 5, in radians).
    pub fn of_axis(self, axis: usize, units: &Units) -> f64 {
        if axis < 3 {
            self.length.in_units(units, Dimension::LENGTH)
        } else {
            self.angle_deg.to_radians()
        }
    }
}

/// How residuals count.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Loss {
    /// Squares.
    Gaussian,
    /// Squares up to a few standard deviations, linear beyond.
    Huber,
}

/// `[identify]`.
#[derive(Clone, PartialEq, Debug)]
pub struct IdentifySettings {
    /// Addresses of bushings; every BUSHING of the deck if absent.
    pub bushings: Option<Vec<SpannedText>>,
    /// Addresses of other numbers.
    pub stiffnesses: Vec<SpannedText>,
    /// Symmetry of bushings not named.
    pub symmetry: Symmetry,
    /// Symmetry of named bushings.
    pub symmetry_of: Vec<(SpannedText, Symmetry)>,
    /// What identifies.
    pub method: Method,
    /// Where stiffnesses start.
    pub initial: Initial,
    /// Sd of the lognormal prior around the initial value.
    pub prior_log_sd: f64,
    /// Prior sd of the assembly offset of each bushing.
    pub offset_sd: ShiftSd,
    /// Prior sd of a per-case shift of the measuring frame.
    pub frame_sd: ShiftSd,
    /// How residuals count.
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
            let positive = (f64::MIN_POSITIVE, f64::INFINITY);
            let values = Initial::Values {
                translational: Amount::read(&mut initial, "translational", 1e4, positive, out),
                rotational_per_degree: Amount::read(
                    &mut initial,
                    "rotational_per_degree",
                    1e4,
                    positive,
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
            prior_log_sd: section.number("prior_log_sd", 3.0, (1e-9, 1e9), out),
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

/// Equation 16: as printed, or with the weights turned round as its text means.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Weights {
    /// 1 / sum (F - mean F)^2.
    Printed,
    /// sum (F - mean F)^2.
    Corrected,
}

/// Equation 13: as printed, or the inverse regression.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Slope {
    /// cov(F, delta) / var(delta).
    Printed,
    /// var(F) / cov(F, delta): the noise is on delta.
    Inverse,
}

/// `[regression]`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RegressionSettings {
    /// Equation 17.
    pub epsilon: f64,
    /// Equation 15.
    pub r_min: f64,
    /// Equation 16.
    pub weights: Weights,
    /// Equation 13.
    pub slope: Slope,
    /// Iterations after which the loop gives up.
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
            epsilon: section.number("epsilon", default.epsilon, (1e-12, 1.0), out),
            r_min: section.number("r_min", default.r_min, (-1.0, 1.0), out),
            weights: section.choice("weights", default.weights, &weights, out),
            slope: section.choice("slope", default.slope, &slopes, out),
            max_iterations: section.count(
                "max_iterations",
                default.max_iterations,
                (1, 1_000_000),
                out,
            ),
        }
    }
}

/// Which axis of the wheel marker is the spin axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SpinAxis {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// +1 or -1 where the study gives a sign; otherwise the sense that points outboard at design is taken.
    pub sign: Option<i8>,
}

impl SpinAxis {
    /// `axis = "y"`, which it is by default, with or without a sign.
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let words = ["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"];
        let axes = std::array::from_fn::<_, 9, _>(|at| {
            let sign = [None, Some(1), Some(-1)][at / 3];
            (words[at], Self { axis: at % 3, sign })
        });
        section.choice("axis", axes[1].1, &axes, out)
    }
}

/// `[wheel]` without its table.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelSettings {
    /// The marker on the wheel carrier.
    pub marker: SpannedText,
    /// Its spin axis.
    pub axis: SpinAxis,
    /// Sd of a coordinate.
    pub sigma_position: Amount,
    /// Sd of an angle, degrees.
    pub sigma_angle_deg: f64,
}

impl WheelSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Option<Self> {
        let marker = section.text("marker", out);
        let axis = SpinAxis::read(section, out);
        let mut sigma = section.section("sigma", out);
        let positive = (1e-12, f64::INFINITY);
        let (sigma_position, sigma_angle_deg) = (
            Amount::read(&mut sigma, "position", 0.05, positive, out),
            sigma.number("angle_deg", 0.01, positive, out),
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

/// One channel of `[readings.channels]`.
#[derive(Clone, PartialEq, Debug)]
pub struct ChannelSettings {
    /// Its column.
    pub name: String,
    /// An ADAMS function of the deck.
    pub function: SpannedText,
    /// Sd of one reading; estimated from the fit if it is not given.
    pub sigma: Option<f64>,
    /// Its unit, for reports.
    pub unit: Option<String>,
    /// The case whose value is subtracted: its label, or `previous`.
    pub relative_to: Option<SpannedText>,
}

impl ChannelSettings {
    pub(super) fn read(
        name: &SpannedText,
        section: &mut Section<'_>,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let function = section.text("function", out);
        let sigma = section.optional_number("sigma", (1e-300, f64::INFINITY), out);
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
