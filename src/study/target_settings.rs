//! Section `[target]` of `study.toml`: goals for characteristics of an axle and for load cases, and the numbers of the deck that may
//! change.

use super::section::{Section, SpannedText};
use super::table::Table;
use super::unknown_settings::UnknownSettings;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Part of a characteristic to which a goal applies.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum GoalScope {
    /// All samples of the test.
    #[default]
    Curve,
    /// Value at one value of the test's variable.
    Value,
    /// Slope of the least-squares line within the window of the test.
    Gradient,
}

/// Target of a goal. Numbers are in the units of `curves.csv` and `gradients.csv`.
#[derive(Clone, Debug)]
pub enum Wanted {
    /// Exactly this value or gradient.
    Number(f64),
    /// A curve, given by a table with the columns `test`, `value` and characteristics.
    Curve(Table),
    /// Any value between these limits. A missing limit is infinite.
    Limits([f64; 2]),
}

/// Test or load case in which a goal is read.
#[derive(Clone, Debug)]
pub enum GoalPlace {
    /// Name of a test in `kc.toml`, or `ride` for ride height.
    Test(SpannedText),
    /// A load case of the study.
    Case {
        /// Label of the load case.
        label: SpannedText,
        /// Label of the load case whose value is subtracted, if there is one.
        relative_to: Option<SpannedText>,
    },
}

/// One table `[[target.goal]]`. Names are not yet resolved.
#[derive(Clone, Debug)]
pub struct GoalSettings {
    /// Position of the table in `study.toml`.
    pub span: Span,
    /// Test or load case.
    pub place: GoalPlace,
    /// Name of the quantity: a characteristic such as `toe_angle.left`, or a force, position or reading such as `BUSHING/3.FX`.
    pub of: SpannedText,
    /// Part of the characteristic.
    pub scope: GoalScope,
    /// Value of the test's variable, for a single value.
    pub at: f64,
    /// Target of the goal.
    pub wanted: Wanted,
    /// Deviation that has the weighted value one. A goal with a smaller deviation is met.
    pub tolerance: f64,
    /// True if the largest deviation is minimised instead of the sum of squares.
    pub minimax: bool,
}

/// Settings of section `[target]`.
#[derive(Clone, Debug)]
pub struct TargetSettings {
    /// Contents of `kc.toml`: the wheels and the tests. `None` if every goal reads a load case.
    pub kc: Option<Source>,
    /// Number of additional starts, from Sobol points within the bounds.
    pub restarts: usize,
    /// Maximum number of evaluations for each start.
    pub evaluations: usize,
    /// True if the search is robust: goals must be met at two standard deviations of the tolerances to either side of the mean.
    pub robust: bool,
    /// Number of axles that are solved with drawn tolerances; no axle is drawn if it is zero.
    pub draws: usize,
    /// Goals, with names that are not yet resolved.
    pub goals: Vec<GoalSettings>,
    /// Numbers of the deck that may change.
    pub unknowns: Vec<UnknownSettings>,
}

impl TargetSettings {
    /// Returns the files that the section names.
    pub(super) fn sources(&self) -> impl Iterator<Item = &Source> {
        let curves = self.goals.iter().filter_map(|goal| match &goal.wanted {
            Wanted::Curve(table) => Some(&table.source),
            Wanted::Number(_) | Wanted::Limits(_) => None,
        });
        self.kc.iter().chain(curves)
    }

    /// Reads the section. `open` opens a file of the study folder.
    pub(super) fn read(
        section: &mut Section<'_>,
        open: &mut dyn FnMut(&SpannedText, &mut Vec<Diagnostic>) -> Option<Source>,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let kc = section.text("kc", out);
        let restarts = section.count("restarts", 8, 0..=1000, out);
        let evaluations = section.count("evaluations", 100, 1..=100_000, out);
        let robust = section.flag("robust", out);
        let draws = section.count("draws", 200, 0..=1_000_000, out);
        let unknowns = UnknownSettings::read_all(section, out);
        let goals: Vec<GoalSettings> = section
            .tables("goal", out)
            .into_iter()
            .filter_map(|table| GoalSettings::read(table, open, out))
            .collect();
        if section.is_inquiry() {
            return None;
        }
        let is_of_case = |goal: &GoalSettings| matches!(goal.place, GoalPlace::Case { .. });
        let needs_tests = goals.is_empty() || !goals.iter().all(is_of_case);
        let usual = || SpannedText {
            text: "kc.toml".to_string(),
            span: section.span(),
        };
        let kc = match kc.or_else(|| needs_tests.then(usual)) {
            Some(name) => Some(open(&name, out)?),
            None => None,
        };
        Some(Self {
            kc,
            restarts,
            evaluations,
            robust,
            draws,
            goals,
            unknowns,
        })
    }
}

impl GoalSettings {
    fn read(
        mut table: Section<'_>,
        open: &mut dyn FnMut(&SpannedText, &mut Vec<Diagnostic>) -> Option<Source>,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let any = f64::NEG_INFINITY..=f64::INFINITY;
        let [test, case, relative_to, of] =
            ["test", "case", "relative_to", "of"].map(|key| table.text(key, out));
        let file = table.text("curve", out);
        let [value, gradient, least, most] = ["value", "gradient", "least", "most"]
            .map(|key| table.optional_number(key, any.clone(), out));
        let at = table.optional_number("at", any, out);
        let tolerance = table.optional_number("tolerance", f64::MIN_POSITIVE..=f64::INFINITY, out);
        let scopes = [
            ("curve", GoalScope::Curve),
            ("value", GoalScope::Value),
            ("gradient", GoalScope::Gradient),
        ];
        let stated = table.choice("limits", GoalScope::Curve, &scopes, out);
        let minimax = table.flag("minimax", out);
        let mut wrong = Vec::new();
        for (key, there) in [("of", of.is_some()), ("tolerance", tolerance.is_some())] {
            if !there {
                wrong.push(format!("a goal needs `{}`", table.name(key)));
            }
        }
        let limited = least.is_some() || most.is_some();
        let place = match (test, case) {
            (Some(test), None) => {
                if relative_to.is_some() {
                    wrong.push("`relative_to` applies only to a goal of a load case".to_string());
                }
                Some(GoalPlace::Test(test))
            }
            (None, Some(label)) => {
                if file.is_some() || gradient.is_some() || stated != GoalScope::Curve {
                    wrong.push(
                        "a goal of a load case takes `value`, or the limits `least` and `most`; curves and gradients belong to tests of the rig".to_string(),
                    );
                }
                if at.is_some() {
                    wrong.push("`at` applies only to a goal of a test".to_string());
                }
                Some(GoalPlace::Case { label, relative_to })
            }
            _ => {
                let (test, case) = (table.name("test"), table.name("case"));
                wrong.push(format!("a goal needs one of `{test}` and `{case}`"));
                None
            }
        };
        let count = [file.is_some(), value.is_some(), gradient.is_some(), limited];
        if count.iter().filter(|given| **given).count() != 1 {
            wrong.push(
                "a goal needs one of `curve`, `value`, `gradient`, or the limits `least` and `most`"
                    .to_string(),
            );
        }
        let limits = [
            least.unwrap_or(f64::NEG_INFINITY),
            most.unwrap_or(f64::INFINITY),
        ];
        if limits[0] > limits[1] {
            wrong.push("`least` is more than `most`".to_string());
        }
        if limited && minimax {
            wrong.push("`minimax` does not apply to limits, which hold at every point".to_string());
        }
        let (scope, wanted) = match (file, value, gradient) {
            (Some(file), ..) => {
                let source = if table.is_inquiry() {
                    None
                } else {
                    open(&file, out)
                };
                let curve = source.map(|source| Wanted::Curve(Table::read(source, out)));
                (GoalScope::Curve, curve)
            }
            (_, Some(value), _) => (GoalScope::Value, Some(Wanted::Number(value))),
            (_, _, Some(slope)) => (GoalScope::Gradient, Some(Wanted::Number(slope))),
            _ => (stated, Some(Wanted::Limits(limits))),
        };
        let scope = match place {
            Some(GoalPlace::Case { .. }) => GoalScope::Value,
            _ => scope,
        };
        let (file, span, inquiry) = (table.file().to_string(), table.span(), table.is_inquiry());
        table.finish(out);
        if inquiry {
            return None;
        }
        let is_right = wrong.is_empty();
        out.extend(wrong.into_iter().map(|message| {
            Diagnostic::error(Code::BadSetting, message)
                .label(&*file, span, "")
                .help("`admire guide tune` shows every key")
        }));
        if !is_right {
            return None;
        }
        Some(Self {
            span,
            place: place?,
            of: of?,
            scope,
            at: at.unwrap_or(0.0),
            wanted: wanted?,
            tolerance: tolerance?,
            minimax,
        })
    }
}
