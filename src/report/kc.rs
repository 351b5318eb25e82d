use super::kc_summary;
use super::load_run::positive;
use super::number::rounded;
use super::scene::Role;
use super::{
    Align, Chart, DrawingError, Figure, Page, Scene, Series, SeriesStyle, Table, axis_label,
};
use admire_kc::{
    Branch, Convention, Gradient, KcRun, Reading, Sample, Side, TestKind, TestRun, driven_unit,
    fitted_slope, loop_half_width, output, shown, slope,
};
use admire_syntax::units::Units;

/// Measured curve of a K&C (kinematics and compliance) test, in the units of the deck and radians.
#[derive(Clone, PartialEq, Debug)]
pub struct MeasuredCurve {
    /// Name of the K&C test.
    pub test: String,
    /// Path of the characteristic, such as `toe_angle.left`.
    pub path: String,
    /// Pairs of the test's driven variable and the characteristic, in the order driven.
    pub points: Vec<(f64, f64)>,
}

/// Report of K&C (kinematics and compliance) tests as an HTML page.
#[derive(Debug)]
pub struct KcReport<'a> {
    /// Title of the page: the title of the deck, or the name of its file.
    pub title: &'a str,
    /// Three-dimensional view of the axle with its wheels.
    pub scene: Option<&'a Scene>,
    /// Results of the tests on the deck.
    pub run: &'a KcRun,
    /// Results of the same tests on other decks, with the names of these decks.
    pub others: &'a [(String, KcRun)],
    /// Measured curves, drawn beside the results.
    pub measured: &'a [MeasuredCurve],
    /// Units of the deck.
    pub units: &'a Units,
    /// Axis convention in which results are given.
    pub convention: Convention,
    /// Inputs and settings listed at the top of the page, by name.
    pub facts: &'a [(&'a str, String)],
}

/// Curves drawn for each test: name of the request, its left and right components, and title of the chart.
const CURVES: [(&str, [&str; 2], &str); 7] = [
    ("toe_angle", ["left", "right"], "Toe"),
    ("camber_angle", ["left", "right"], "Camber"),
    ("caster_angle", ["left", "right"], "Caster"),
    (
        "wheel_travel_base",
        ["base_left", "base_right"],
        "Base change",
    ),
    (
        "wheel_travel_track",
        ["track_left", "track_right"],
        "Track change",
    ),
    (
        "wheel_travel",
        ["vertical_left", "vertical_right"],
        "Wheel travel",
    ),
    (
        "wheel_load_vertical_force",
        ["vertical_left_force", "vertical_right_force"],
        "Vertical load",
    ),
];

/// Characteristics of the axle drawn for tests that drive heights: name of the request, component, and title of the chart.
const MIGRATION: [(&str, &str, &str); 2] = [
    ("roll_center_location", "vertical", "Roll centre height"),
    (
        "roll_center_location",
        "lateral_from_half_track",
        "Roll centre, lateral",
    ),
];

/// Requests listed in the ride height table.
const AT_RIDE_HEIGHT: [&str; 22] = [
    "toe_angle",
    "camber_angle",
    "caster_angle",
    "kingpin_incl_angle",
    "scrub_radius",
    "caster_moment_arm",
    "wheel_load_vertical_force",
    "wheel_rate",
    "ride_rate",
    "ride_steer",
    "ride_camber",
    "fr_view_swing_arm_length",
    "side_view_swing_arm_length",
    "roll_steer",
    "roll_camber_coefficient",
    "lat_force_defl_compliance",
    "lat_force_steer_compliance",
    "lat_force_camber_compliance",
    "alt_steer_compliance",
    "fore_aft_wheel_center_stiffness",
    "anti_dive_braking",
    "anti_squat_acceleration",
];

/// Returns a readable name for a request.
fn called(entity: &str) -> String {
    match entity {
        "kingpin_incl_angle" => "kingpin inclination".to_string(),
        "caster_moment_arm" => "caster trail".to_string(),
        "wheel_load_vertical_force" => "vertical load".to_string(),
        "fr_view_swing_arm_length" => "front-view swing arm".to_string(),
        "side_view_swing_arm_length" => "side-view swing arm".to_string(),
        "lat_force_defl_compliance" => "lateral compliance".to_string(),
        "lat_force_steer_compliance" => "lateral force steer".to_string(),
        "lat_force_camber_compliance" => "lateral force camber".to_string(),
        "alt_steer_compliance" => "aligning torque steer".to_string(),
        "fore_aft_wheel_center_stiffness" => "fore-aft stiffness".to_string(),
        "anti_dive_braking" => "anti-dive (rear axle: anti-lift), braking".to_string(),
        "anti_squat_acceleration" => "anti-squat (front axle: anti-lift), driving".to_string(),
        other => other.replace("_angle", "").replace('_', " "),
    }
}

/// Size below which a value is a rounding error of an angle or a length.
const ROUND_OFF: f64 = 1e-11;

/// Formats a number with four significant digits; empty if the number is not finite.
fn digits(value: f64) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let value = if value.abs() < ROUND_OFF { 0.0 } else { value };
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let places = if size == 0.0 {
        0
    } else {
        (3 - libm::log10(size).floor() as i32).clamp(0, 6)
    };
    format!("{value:.*}", places as usize)
}

/// Formats an end of a linear range to three digits: it lies on a step of the test.
fn range_end(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return digits(value);
    }
    rounded(value, 3)
}

/// Formats a fraction in percent. Returns an empty text if the fraction is not finite, as for a single wheel.
fn percent(share: f64) -> String {
    if share.is_finite() {
        format!("{:.1} %", 100.0 * share + 0.0)
    } else {
        String::new()
    }
}

fn reading<'s>(sample: &'s Sample, entity: &str, component: &str) -> Option<&'s Reading> {
    let mut all = sample.readings.iter();
    all.find(|reading| reading.entity == entity && reading.component == component)
}

/// Returns true if the curves of the two branches coincide, to a thousandth of the plotted range.
fn one_curve(up: &[(f64, f64)], down: &[(f64, f64)]) -> bool {
    let values = || up.iter().map(|point| point.1);
    let (least, most) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let near = |(x, y): &(f64, f64)| {
        let apart = |point: &&(f64, f64)| (point.0 - x).abs();
        let there = up.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        there.is_some_and(|point| (point.1 - y).abs() <= 1e-3 * (most - least))
    };
    up.len() == down.len() && down.iter().all(near)
}

impl KcReport<'_> {
    /// Returns the page as HTML text. `footer` names the program that made it.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn page(&self, footer: &str) -> Result<String, DrawingError> {
        let sides = output::sides(self.run);
        let side = sides.first().copied().unwrap_or(Side::Left);
        let mut page = Page::new(
            "Kinematics and compliance",
            self.title,
            &kc_summary::sentence(self.run, side, self.units),
        );
        page.origin(self.facts);
        page.meaning();
        if let Some(test) = self.run.tests.iter().find(|t| t.kind == TestKind::Bounce) {
            let mut pair = Vec::new();
            for (entity, components, title) in &CURVES[..2] {
                pair.extend(self.curve(test, entity, components, title)?);
            }
            page.figures(&Self::drawn(&mut pair)?);
        }
        if let Some(scene) = self.scene {
            page.scene(scene);
        }
        page.found(&[]);
        page.table(&kc_summary::summary(
            self.run,
            self.others,
            &sides,
            self.units,
        ));
        page.note(
            "Values at ride height; a single value is that of the left wheel. Slopes are tangents. Positive toe is toe-in and positive camber is top outboard, on both sides. Definitions: `admire guide kc`.",
        );
        for test in &self.run.tests {
            self.test(&mut page, test)?;
        }
        page.detail("Characteristics at ride height, with the names of Adams/Car");
        page.table(&self.ride_height());
        page.note(
            "Angles are in degrees. Definitions and signs: `admire guide kc`. Anti-dive, anti-lift and anti-squat are those of this axle.",
        );
        Ok(page.finish(footer))
    }

    /// Draws charts. Charts of the same quantity share one scale.
    fn drawn(charts: &mut [Chart]) -> Result<Vec<Figure>, DrawingError> {
        Chart::equalise(charts);
        charts
            .iter()
            .map(|chart| Figure::chart(chart, ""))
            .collect()
    }

    fn ride_height(&self) -> Table {
        let mut heads = vec![("characteristic", Align::Left), ("unit", Align::Left)];
        heads.extend([("left", Align::Right), ("right", Align::Right)]);
        let names: Vec<String> = self
            .others
            .iter()
            .flat_map(|(name, _)| [format!("{name}: left"), format!("{name}: right")])
            .collect();
        heads.extend(names.iter().map(|name| (name.as_str(), Align::Right)));
        let mut table = Table::new(&heads);
        for entity in AT_RIDE_HEIGHT {
            let Some(first) = self.run.ride.readings.iter().find(|r| r.entity == entity) else {
                continue;
            };
            let unit = shown(0.0, first.unit, self.units).1;
            let mut row = vec![called(entity), unit];
            for run in std::iter::once(self.run).chain(self.others.iter().map(|o| &o.1)) {
                for side in Side::BOTH {
                    let mut all = run.ride.readings.iter();
                    let found =
                        all.find(|r| r.entity == entity && r.component.contains(side.word()));
                    row.push(found.map_or_else(String::new, |r| {
                        digits(shown(r.value_in(self.convention), r.unit, self.units).0)
                    }));
                }
            }
            table.row(row);
        }
        for (entity, component, name) in [
            ("roll_center_location", "vertical", "roll centre height"),
            (
                "roll_center_location",
                "lateral_from_half_track",
                "roll centre, lateral",
            ),
            (
                "susp_roll_rate",
                "suspension_roll_rate",
                "suspension roll rate",
            ),
            ("total_roll_rate", "total_roll_rate", "total roll rate"),
        ] {
            let Some(found) = reading(&self.run.ride, entity, component) else {
                continue;
            };
            let unit = shown(0.0, found.unit, self.units).1;
            let mut row = vec![name.to_string(), unit];
            for run in std::iter::once(self.run).chain(self.others.iter().map(|o| &o.1)) {
                let found = reading(&run.ride, entity, component);
                row.push(found.map_or_else(String::new, |r| {
                    digits(shown(r.value_in(self.convention), r.unit, self.units).0)
                }));
                row.push(String::new());
            }
            table.row(row);
        }
        table
    }

    fn test(&self, page: &mut Page, test: &TestRun) -> Result<(), DrawingError> {
        let settings = &test.settings;
        let name = test.kind.name().replace('_', " ");
        let mut title = name[..1].to_uppercase() + &name[1..];
        if !settings.steering_locked {
            title += ", free steering";
        }
        page.detail(&title);
        let same = test
            .gradients
            .iter()
            .all(|g| g.hysteresis <= 1e-6 * g.tangent.abs() * settings.window);
        let both = test.samples.iter().any(|s| s.branch == Branch::Down);
        page.paragraph(&format!(
            "Input: {} from {} to {} {}. Loads act at the {}; {} held constant. {}",
            test.kind.variable(),
            settings.range[0],
            settings.range[1],
            driven_unit(test.kind.driven(), self.units),
            if settings.point == admire_kc::LoadPoint::Patch {
                "contact patch"
            } else {
                "wheel centre"
            },
            match (settings.hold, test.kind) {
                (admire_kc::Hold::Height, _) => "wheel centre height is",
                (_, TestKind::Roll) => "axle load is",
                _ => "vertical loads are",
            },
            match (both, same) {
                (false, _) => "The input is applied in one direction.",
                (true, true) => "Both branches coincide: the deck has no friction.",
                (true, false) => "The branches differ because of friction; the table below has the half width of each loop.",
            }
        ));
        let mut figures = Vec::new();
        for (entity, components, title) in CURVES {
            // In tests that hold heights, wheel travel is the input.
            if entity == "wheel_travel" && settings.hold == admire_kc::Hold::Height {
                continue;
            }
            figures.extend(self.curve(test, entity, &components, title)?);
        }
        for (entity, component, title) in MIGRATION {
            if settings.hold == admire_kc::Hold::Height {
                figures.extend(self.curve(test, entity, &[component], title)?);
            }
        }
        page.figures(&Self::drawn(&mut figures)?);
        page.subheading("Gradients at ride height")
            .table(&self.gradients(test));
        page.note(
            "Tangent: the exact derivative at ride height. Fitted: slope of the least-squares line within the window, mean of both branches. Linear range: the range in which the curve deviates from the tangent by less than 5 % of the whole change, or 10 % of the change up to that point.",
        );
        Ok(())
    }

    /// Draws one chart. Returns `None` if all its curves are constant, because such a chart carries no information.
    fn curve(
        &self,
        test: &TestRun,
        entity: &'static str,
        components: &[&'static str],
        title: &str,
    ) -> Result<Option<Chart>, DrawingError> {
        let mut series = Vec::new();
        let mut unit = String::new();
        for component in components {
            let word = if components.len() > 1 && component.contains("right") {
                "right"
            } else if components.len() > 1 {
                "left"
            } else {
                ""
            };
            let points = |test: &TestRun, branch: Branch, unit: &mut String| -> Vec<(f64, f64)> {
                let samples = test.samples.iter().filter(|s| s.branch == branch);
                samples
                    .filter_map(|sample| {
                        let found = reading(sample, entity, component)?;
                        let value = found.value_in(self.convention);
                        let (value, word) = shown(value, found.unit, self.units);
                        *unit = word;
                        Some((sample.value, value))
                    })
                    .collect()
            };
            let up = points(test, Branch::Up, &mut unit);
            if up.is_empty() {
                continue;
            }
            let named = |what: &str| match (word, what) {
                ("", "") if self.others.is_empty() => String::new(),
                ("", "") => "this deck".to_string(),
                _ => format!("{word} {what}").trim().to_string(),
            };
            let mut down = points(test, Branch::Down, &mut unit);
            if one_curve(&up, &down) {
                down.clear();
            }
            let up_name = named(if down.is_empty() { "" } else { "up" });
            series.push(Series::new(&up_name, SeriesStyle::LinePoints, up));
            if !down.is_empty() {
                series.push(Series::new(&named("down"), SeriesStyle::Dashed, down));
            }
            for (name, run) in self.others {
                let same = run.tests.iter().find(|other| other.kind == test.kind);
                let points = same.map_or_else(Vec::new, |t| points(t, Branch::Up, &mut unit));
                series.push(Series::new(&named(name), SeriesStyle::Line, points));
            }
            let path = format!("{entity}.{component}");
            for curve in self.measured {
                if curve.test == test.kind.name() && curve.path == path {
                    let angle = unit.starts_with("deg");
                    let turned = |v: f64| if angle { v.to_degrees() } else { v };
                    let points = curve.points.iter().map(|p| (p.0, turned(p.1)));
                    series.push(Series {
                        name: named("measured"),
                        ..Series::of(Role::Measured, points.collect())
                    });
                }
            }
        }
        merge_sides(&mut series);
        let all = || series.iter().flat_map(|s| &s.points).map(|p| p.1);
        let (low, high) = (
            all().fold(f64::MAX, f64::min),
            all().fold(f64::MIN, f64::max),
        );
        if !(high - low > 1e-9 * high.abs().max(low.abs()).max(1e-6)) {
            return Ok(None);
        }
        let name = title.to_lowercase();
        let mut y = axis_label(&name, &unit);
        // Coordinates change sign with the axis convention of the results.
        let is_coordinate = name.ends_with("change");
        if let Some(sign) =
            positive(&name).filter(|_| !is_coordinate || self.convention == Convention::AdamsCar)
        {
            y += &format!(", + {sign}");
        }
        let variable = test.kind.variable();
        let driven = match variable {
            "antiphase travel" => Some("left wheel up"),
            "lateral force" => Some("to the right"),
            "braking force" => Some("rearward"),
            "driving force" => Some("forward"),
            "aligning torque" => Some("about +z"),
            other => positive(other),
        };
        let mut x = axis_label(variable, &driven_unit(test.kind.driven(), self.units));
        if let Some(sign) = driven {
            x += &format!(", + {sign}");
        }
        Ok(Some(Chart {
            title: title.to_string(),
            x,
            y,
            series,
            ..Chart::default()
        }))
    }

    fn gradients(&self, test: &TestRun) -> Table {
        let driven = test.kind.driven();
        let mut heads = vec![
            ("quantity", Align::Left),
            ("unit", Align::Left),
            ("tangent", Align::Right),
            ("fitted", Align::Right),
        ];
        // Without friction, all loops are closed to round-off, and the column would hold zeros.
        let loops = test.gradients.iter().any(|gradient| {
            shown(gradient.hysteresis, gradient.unit, self.units)
                .0
                .abs()
                >= ROUND_OFF
        });
        if loops {
            heads.push(("half width of loop", Align::Right));
        }
        heads.extend(
            ["linear from", "linear to", "asymmetry, left to right"]
                .map(|name| (name, Align::Right)),
        );
        let names: Vec<&str> = self.others.iter().map(|(name, _)| name.as_str()).collect();
        heads.extend(names.iter().map(|name| (*name, Align::Right)));
        let measured = self
            .measured
            .iter()
            .any(|curve| curve.test == test.kind.name());
        if measured {
            heads.push(("measured, fitted slope", Align::Right));
            heads.push(("measured, half width of loop", Align::Right));
        }
        let mut table = Table::new(&heads);
        for gradient in &test.gradients {
            let factor = self.convention.factor(gradient.sense);
            let of = |value: f64| slope(value, gradient.unit, driven, self.units);
            let width = |value: f64| {
                let (value, unit) = shown(value, gradient.unit, self.units);
                let text = digits(value);
                if text.is_empty() {
                    text
                } else {
                    format!("{text} {unit}")
                }
            };
            let (tangent, unit) = of(factor * gradient.tangent);
            let mut row = vec![
                format!("{}.{}", gradient.entity, gradient.component),
                unit,
                digits(tangent),
                digits(of(factor * gradient.fitted).0),
            ];
            row.extend(loops.then(|| width(gradient.hysteresis)));
            row.extend(gradient.linear_range.map(range_end));
            row.push(percent(gradient.asymmetry(&test.gradients)));
            for (_, run) in self.others {
                let same = run.tests.iter().find(|other| other.kind == test.kind);
                let found = same.and_then(|test| {
                    let like =
                        |g: &&Gradient| g.entity == gradient.entity && g.side == gradient.side;
                    test.gradients.iter().find(like)
                });
                row.push(found.map_or_else(String::new, |g| digits(of(factor * g.tangent).0)));
            }
            if measured {
                let path = format!("{}.{}", gradient.entity, gradient.component);
                let mut all = self.measured.iter();
                let curve = all.find(|c| c.test == test.kind.name() && c.path == path);
                let slope = curve.map(|c| fitted_slope(&c.points, test.settings.window));
                let loops = curve.map(|c| loop_half_width(&c.points));
                row.push(slope.map_or_else(String::new, |value| digits(of(value).0)));
                row.push(loops.map_or_else(String::new, width));
            }
            table.row(row);
        }
        table
    }
}

/// Merges the curves of the left and the right wheel if they coincide, as on a symmetric axle with the wheels in phase.
fn merge_sides(series: &mut Vec<Series>) {
    let mut at = 0;
    while at < series.len() {
        let Some(what) = series[at].name.strip_prefix("right") else {
            at += 1;
            continue;
        };
        let left = format!("left{what}");
        let both = format!("left and right{what}");
        let same = series
            .iter()
            .position(|other| other.name == left && one_curve(&other.points, &series[at].points));
        match same {
            Some(other) => {
                series[other].name = both;
                series.remove(at);
            }
            None => at += 1,
        }
    }
}
