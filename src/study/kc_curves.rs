//! Curves of a kinematics and compliance (K&C) rig as readings: toe, camber, steer, caster, travel, base and track of a wheel.
//!
//! Each curve is a function of three auxiliary markers on the wheel carrier. The first is at the wheel centre. The second is one unit from the
//! centre along the spin axis, in the direction `o` (outboard). The third is one unit rearward of the centre in the design position, in the
//! direction `e`.
//!
//! With the unit vectors `f` forward, `r` to the right and z up, the angles are toe `atan(o.f / |o.r|)`, camber `-asin(o.z)`, steer `-atan(o.f
//! / o.r)` and caster `-atan(e.z / -e.f)`. Travel, base and track are the displacements of the wheel centre from its design position: upward,
//! rearward and to the right. Source: guide page `kc`, section "Geometry".

use super::section::{Section, SpannedText};
use super::settings::SpinAxis;
use super::table::Table;
use super::wheel::SpinDirection;
use admire_solver::mechanics::Vec3;
use admire_solver::model::{Header, Marker, MarkerIx, Model, Orientation};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Quantity that a curve of a kinematics and compliance (K&C) rig shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Curve {
    /// Toe angle, positive for toe-in.
    Toe,
    /// Camber angle, positive if the top of the wheel leans outboard.
    Camber,
    /// Steer angle, positive for steering to the right.
    Steer,
    /// Change of the caster angle from the design position, which is the pitch of the wheel carrier. Positive if the top moves rearward.
    Caster,
    /// Vertical displacement of the wheel centre from its design position, positive upward.
    Travel,
    /// Longitudinal displacement of the wheel centre from its design position, positive rearward.
    Base,
    /// Lateral displacement of the wheel centre from its design position, positive to the right.
    Track,
}

impl Curve {
    const ALL: [(&'static str, Self); 7] = [
        ("toe", Self::Toe),
        ("camber", Self::Camber),
        ("steer", Self::Steer),
        ("caster", Self::Caster),
        ("travel", Self::Travel),
        ("base", Self::Base),
        ("track", Self::Track),
    ];

    /// Returns the usual names of columns with this curve, in English, German and French.
    const fn called(self) -> &'static [&'static str] {
        match self {
            Self::Toe => &["toe", "spur", "vorspur", "spurwinkel", "pincement"],
            Self::Camber => &["camber", "sturz", "sturzwinkel", "carrossage"],
            Self::Steer => &["steer", "lenkwinkel", "braquage"],
            Self::Caster => &["caster", "castor", "nachlauf", "nachlaufwinkel", "chasse"],
            Self::Travel => &[
                "travel",
                "jounce",
                "radhub",
                "federweg",
                "einfederung",
                "debattement",
                "débattement",
            ],
            Self::Base => &[
                "base",
                "wheelbase",
                "recession",
                "radstand",
                "radstandsänderung",
                "radstandsaenderung",
                "empattement",
            ],
            Self::Track => &[
                "track",
                "spurweite",
                "spurweitenänderung",
                "spurweitenaenderung",
                "voie",
            ],
        }
    }

    /// Returns the curve with this keyword of `study.toml`.
    pub(super) fn named(word: &str) -> Option<Self> {
        let own = Self::ALL.iter().find(|(own, _)| *own == word);
        own.map(|(_, curve)| *curve)
    }

    /// Returns the keywords of all curves.
    pub(super) fn words() -> Vec<&'static str> {
        Self::ALL.iter().map(|(word, _)| *word).collect()
    }

    /// Returns a description of the sign convention of the curve.
    pub(crate) const fn sign_convention(self) -> &'static str {
        match self {
            Self::Toe => "positive for toe-in",
            Self::Camber => "positive with the top outboard",
            Self::Steer => "positive to the right",
            Self::Caster => "change of caster, positive with the top rearward",
            Self::Travel => "wheel centre, positive upward",
            Self::Base => "wheel centre, positive rearward",
            Self::Track => "wheel centre, positive to the right",
        }
    }

    /// Returns true if the curve is an angle, and false if it is a displacement.
    pub(crate) const fn is_angle(self) -> bool {
        matches!(self, Self::Toe | Self::Camber | Self::Steer | Self::Caster)
    }
}

/// Forward direction of the vehicle, which is parallel to the x or y axis of ground.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Forward {
    /// Ground axis: 0 for x, 1 for y.
    axis: usize,
    positive: bool,
}

impl Forward {
    fn vector(self) -> Vec3 {
        Vec3::ith(self.axis, if self.positive { 1.0 } else { -1.0 })
    }

    /// Returns the unit vector to the right of the vehicle, seen facing forward.
    fn right(self) -> Vec3 {
        self.vector().cross(&Vec3::z())
    }
}

/// Settings of one curve in `[kc.curves]`.
#[derive(Clone, PartialEq, Debug)]
pub struct CurveSettings {
    /// Name of the curve, which is also the name of its channel.
    pub name: SpannedText,
    /// Quantity that the curve shows.
    pub curve: Curve,
    /// Name of the column in the file, if it differs from the name of the curve.
    pub column: Option<SpannedText>,
    /// Unit of the readings, if the column header does not state it.
    pub unit: Option<SpannedText>,
    /// True if the rig uses the opposite sign convention.
    pub reversed: bool,
    /// Standard deviation of one reading, in the unit of the readings. If it is not given, it is estimated from repeated readings or from the
    /// residuals of a fit.
    pub sigma: Option<f64>,
    /// Wheel marker of this curve, if it differs from the marker of section `[kc]`.
    pub marker: Option<SpannedText>,
    /// Label of the case whose value is subtracted, if it differs from the reference case of section `[kc]`.
    pub relative_to: Option<SpannedText>,
}

/// Settings of section `[kc]`, without the readings.
#[derive(Clone, PartialEq, Debug)]
pub struct KcSettings {
    /// Marker at the wheel centre, on the wheel carrier.
    pub marker: SpannedText,
    /// Spin axis of the wheel, as an axis of this marker.
    pub axis: SpinAxis,
    /// Forward direction of the vehicle.
    pub forward: Forward,
    /// Label of the load case in which the displays of the rig read zero.
    pub relative_to: Option<SpannedText>,
    /// Curves to read from the file.
    pub curves: Vec<CurveSettings>,
}

impl KcSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Option<Self> {
        let marker = section.text("marker", out);
        let axis = SpinAxis::read(section, out);
        let forward = |axis, positive| Forward { axis, positive };
        let ways = [
            ("-x", forward(0, false)),
            ("+x", forward(0, true)),
            ("-y", forward(1, false)),
            ("+y", forward(1, true)),
        ];
        let forward = section.choice("forward", ways[0].1, &ways, out);
        let relative_to = section.text("relative_to", out);
        let mut curves = Vec::new();
        for (name, mut own) in section.section("curves", out).all_sections(out) {
            let named = Curve::ALL.iter().find(|(word, _)| *word == name.text);
            let usual = named.map_or(Curve::Toe, |(_, curve)| *curve);
            if named.is_none() && !own.is_text("curve") && !name.text.is_empty() {
                let words: Vec<&str> = Curve::ALL.iter().map(|(word, _)| *word).collect();
                let message = format!("`{}` needs `curve`: one of {}", name.text, words.join(", "));
                let complaint = Diagnostic::error(Code::MissingSetting, message);
                out.push(complaint.label(own.file(), name.span, ""));
            }
            curves.push(CurveSettings {
                curve: own.choice("curve", usual, &Curve::ALL, out),
                column: own.text("column", out),
                unit: own.text("unit", out),
                reversed: own.choice("sign", false, &[("+", false), ("-", true)], out),
                sigma: own.optional_number("sigma", 1e-300..=f64::INFINITY, out),
                marker: own.text("marker", out),
                relative_to: own.text("relative_to", out),
                name,
            });
            own.finish(out);
        }
        let Some(marker) = marker else {
            section.missing_marker(out);
            return None;
        };
        Some(Self {
            marker,
            axis,
            forward,
            relative_to,
            curves,
        })
    }
}

/// An auxiliary marker that the function of a channel needs and that the deck does not contain.
#[derive(Clone, PartialEq, Debug)]
pub struct Helper {
    /// Id of the auxiliary marker, which the deck does not use.
    pub id: u32,
    /// Id of a marker of the deck whose part and orientation the auxiliary marker shares.
    pub beside: u32,
    /// Position of the auxiliary marker in the frame of the part.
    pub place: Vec3,
}

/// Adds auxiliary markers to a model. Markers that the model already contains are skipped.
pub(crate) fn with_helpers<'a>(model: &mut Model, helpers: impl IntoIterator<Item = &'a Helper>) {
    for helper in helpers {
        let (None, Some(beside)) = (model.marker(helper.id), model.marker(helper.beside)) else {
            continue;
        };
        let beside = &model.markers[beside.0];
        let (part, R) = (beside.part, beside.R);
        model.markers.push(Marker {
            header: Header {
                id: helper.id,
                origin: usize::MAX,
                ..Header::default()
            },
            part,
            qp: helper.place,
            orientation: Orientation::Points,
            R,
            floating: false,
            relative: None,
        });
    }
}

/// Auxiliary markers of a wheel, and the directions with which the curves are computed. The markers are at the wheel centre, along the spin
/// axis and rearward of the centre.
#[derive(Clone, Debug)]
pub(super) struct Gauge {
    helpers: [Helper; 3],
    /// Position of the wheel centre in ground, in the design position.
    centre: Vec3,
    forward: Forward,
    /// Sense of the spin axis: +1 if it points to the right of the vehicle, -1 if it points to the left.
    side: f64,
}

impl Gauge {
    /// Places the auxiliary markers of a wheel with this wheel marker. Returns `None` if the deck does not determine the position of the wheel
    /// marker.
    pub(crate) fn new(
        model: &Model,
        marker: MarkerIx,
        axis: SpinAxis,
        forward: Forward,
    ) -> Option<Self> {
        let pose = model.marker_pose(marker)?;
        let wheel = &model.markers[marker.0];
        let part = &model.parts[wheel.part.0];
        let spin = SpinDirection::at_design(&pose, axis);
        let most = model.markers.iter().map(|m| m.header.id).max().unwrap_or(0);
        // The ids are derived from the id of the wheel marker, so they do not depend on elements that a fit adds to the deck.
        let first = most.max(1_000_000).saturating_add(10 * wheel.header.id);
        let to_part = |direction: Vec3| wheel.qp + part.pose.R.transpose() * direction;
        let helper = |k: u32, place: Vec3| Helper {
            id: first + k,
            beside: wheel.header.id,
            place,
        };
        Some(Self {
            helpers: [
                helper(0, wheel.qp),
                helper(1, to_part(spin.s0)),
                helper(2, to_part(-forward.vector())),
            ],
            centre: pose.p,
            forward,
            side: spin.s0.dot(&forward.right()).signum(),
        })
    }

    pub(crate) fn helpers(&self) -> &[Helper] {
        &self.helpers
    }

    /// Returns the ADAMS function of the curve, in degrees or in the deck's length unit.
    pub(crate) fn function(&self, curve: Curve) -> String {
        let [centre, spin, rear] = self.helpers.each_ref().map(|helper| helper.id);
        let signed = |sign: f64, text: String| {
            if sign < 0.0 {
                format!("(-{text})")
            } else {
                text
            }
        };
        // ADAMS function for the component along `way`, a ground axis with a sign, of the vector from the wheel centre to a marker.
        let along = |to: u32, way: &Vec3| {
            let axis = way.iamax();
            signed(
                way[axis],
                format!("D{}({to},{centre})", ["X", "Y", "Z"][axis]),
            )
        };
        let since = |way: &Vec3| {
            let axis = way.iamax();
            let here = format!(
                "(D{}({centre})-({:.12e}))",
                ["X", "Y", "Z"][axis],
                self.centre[axis]
            );
            signed(way[axis], here)
        };
        let (f, r) = (self.forward.vector(), self.forward.right());
        match curve {
            Curve::Toe => {
                let lateral = signed(self.side, along(spin, &r));
                format!("ATAN({}/{lateral})*RTOD", along(spin, &f))
            }
            Curve::Camber => format!("-ASIN({})*RTOD", along(spin, &Vec3::z())),
            Curve::Steer => format!("-ATAN({}/{})*RTOD", along(spin, &f), along(spin, &r)),
            Curve::Caster => {
                format!(
                    "-ATAN({}/{})*RTOD",
                    along(rear, &Vec3::z()),
                    along(rear, &-f)
                )
            }
            Curve::Travel => since(&Vec3::z()),
            Curve::Base => since(&-f),
            Curve::Track => since(&r),
        }
    }
}

/// Returns the column of a curve in the file. This is the column that the study names, or else the only column whose name matches the name of
/// the curve. Units, capitals and punctuation are ignored, and usual synonyms count as matches.
pub(super) fn column(table: &Table, settings: &CurveSettings) -> Option<usize> {
    if let Some(column) = &settings.column {
        return table.column(&column.text);
    }
    let header = table.header();
    let plain = |text: &str| -> String {
        let name = name_and_unit(text).0;
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    };
    let own = plain(&settings.name.text);
    let only = |is: &dyn Fn(&str) -> bool| {
        let mut like = (0..header.len()).filter(|k| is(&header[*k]));
        like.next().filter(|_| like.next().is_none())
    };
    table
        .column(&settings.name.text)
        .or_else(|| only(&|name| plain(name) == own))
        .or_else(|| {
            let words = settings.curve.called();
            only(&|name| words.contains(&plain(name).as_str()))
                .or_else(|| only(&|name| words.iter().any(|word| has_word(name, word))))
        })
}

/// Returns true if a column name contains this word. For example, `Wheel travel [mm]` contains `travel`.
fn has_word(header: &str, word: &str) -> bool {
    let name = name_and_unit(header).0.to_lowercase();
    name.split(|c: char| !c.is_alphanumeric())
        .any(|own| own == word)
}

/// Splits a column name such as `Toe [deg]`, `Toe (min)`, `Toe / mm` or `toe_deg` into the plain name and the unit, if it contains one.
pub(super) fn name_and_unit(header: &str) -> (&str, Option<&str>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((name, rest)) = header.split_once(open)
            && let Some((unit, _)) = rest.split_once(close)
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    for mark in ['/', '_'] {
        if let Some((name, unit)) = header.rsplit_once(mark)
            && (factor(unit, true).is_some() || factor(unit, false).is_some())
        {
            return (name.trim(), Some(unit.trim()));
        }
    }
    (header, None)
}

/// Returns the factor from this unit to degrees if `angle` is true, otherwise to millimetres. Returns `None` for an unknown unit.
pub(super) fn factor(unit: &str, angle: bool) -> Option<f64> {
    let unit = unit.trim().to_lowercase();
    let of_angle = match unit.as_str() {
        "deg" | "degree" | "degrees" | "\u{b0}" => Some(1.0),
        "min" | "arcmin" | "'" => Some(1.0 / 60.0),
        "rad" => Some(1f64.to_degrees()),
        "mrad" => Some(1e-3_f64.to_degrees()),
        _ => None,
    };
    let of_length = match unit.as_str() {
        "mm" => Some(1.0),
        "cm" => Some(10.0),
        "m" => Some(1000.0),
        "in" | "inch" => Some(25.4),
        _ => None,
    };
    if angle { of_angle } else { of_length }
}

#[cfg(test)]
mod tests {
    use super::{factor, has_word, name_and_unit};

    #[test]
    fn a_curve_is_a_word_of_its_column() {
        assert!(has_word("Wheel travel [mm]", "travel") && has_word("toe_angle_deg", "toe"));
        assert!(!has_word("Travels [mm]", "travel") && !has_word("base / mm", "mm"));
    }

    #[test]
    fn units_stand_in_headers() {
        assert_eq!(name_and_unit("Toe [deg]"), ("Toe", Some("deg")));
        assert_eq!(
            name_and_unit("Wheel travel (mm)"),
            ("Wheel travel", Some("mm"))
        );
        assert_eq!(name_and_unit("camber_deg"), ("camber", Some("deg")));
        assert_eq!(name_and_unit("Fz / N"), ("Fz / N", None));
        assert_eq!(name_and_unit("toe / min"), ("toe", Some("min")));
        assert_eq!(name_and_unit("toe_left"), ("toe_left", None));
        assert_eq!(factor("min", true), Some(1.0 / 60.0));
        assert_eq!(factor("mm", true), None);
    }
}
