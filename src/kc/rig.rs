//! The rig: markers, loads and motions added to a copy of the deck as ordinary statements.
//!
//! Each wheel gets a marker `c` at the wheel centre with its z axis along the spin axis, a marker `a` further outboard on the spin axis,
//! and a ground marker `g` at the design position of the centre in the axes of Adams/Car. Variables carry the loads, and one GFORCE applies
//! them.
//!
//! Loads in the road plane follow the heading of the wheel. With the unit spin axis o from `c` to `a` and cos(gamma) = sqrt(1 - oz^2), the
//! lateral axis to the right is `h = (ox, oy, 0) / cos(gamma)`, with opposite sign on the left, and the rearward axis is `h x z`.
//!
//! A load at the contact patch is applied at the wheel centre together with its moment. The lever from the wheel centre to the patch is
//! `d = l (oz ox, oz oy, oz^2 - 1) / cos(gamma)`, with `l = R0 - max(Fn, 0) / (Kt cos(gamma))` from the law of the tyre in
//! [`contact`](super::contact). A MOTION holds the height where heights are driven; its reaction is part of the load.

use super::Side;
use super::config::{Config, Spelled, WheelConfig};
use super::test_kind::{Driven, TestKind};
use super::test_settings::{Hold, TestSettings};
use admire_solver::mechanics::{Mat3, Pose, Vec3, psi_theta_phi};
use admire_solver::model::{MarkerIx, Model, PartKind};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Edit, Span};
use admire_syntax::{Address, Dataset, NewStatement};

/// One wheel found in a deck.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FoundWheel {
    /// Side of the vehicle.
    pub side: Side,
    /// Index of the carrier part in the model.
    pub part: usize,
    /// Wheel centre and wheel axes in the frame of the part: z points outboard along the spin axis.
    pub local: Pose,
    /// Wheel centre and wheel axes at design, in ground axes of the deck.
    pub design: Pose,
    /// Lower and upper marker of the geometric steer axis.
    pub steer_axis: Option<[MarkerIx; 2]>,
    /// Marker whose height is held while the instant steer axis is computed.
    pub travel_lock: Option<MarkerIx>,
}

/// Variant of the rigged deck. Each variant is compiled once and serves all tests that hold the same height and steering.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Variant {
    /// True if motions hold the heights of the wheel centres.
    pub height_held: bool,
    /// True if the statement that locks the steering is kept.
    pub steering_locked: bool,
}

impl Variant {
    /// Returns the stem of the variant's file names.
    pub(crate) fn name(self) -> String {
        let height = if self.height_held { "height" } else { "load" };
        let steering = if self.steering_locked { "" } else { "_free" };
        format!("kc_{height}{steering}")
    }

    /// Returns the variant that holds this quantity, with the steering locked or free.
    pub(crate) fn of(hold: Hold, steering_locked: bool) -> Self {
        Self {
            height_held: hold == Hold::Height,
            steering_locked,
        }
    }

    /// Returns the variant for a test. A test that drives heights also holds them, whatever its settings.
    pub(crate) fn of_test(kind: TestKind, settings: &TestSettings) -> Self {
        let drives_heights = matches!(kind.driven(), Driven::Height(_));
        Self {
            height_held: drives_heights || settings.hold == Hold::Height,
            steering_locked: settings.steering_locked,
        }
    }
}

/// Ids of the statements added for one wheel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct WheelIds {
    /// Side of the vehicle.
    pub side: Side,
    /// Marker at the wheel centre.
    pub centre: u32,
    /// Ground marker at the design position of the wheel centre.
    pub ground: u32,
    /// Variables of the applied forces rearward and to the right in the heading of the wheel, of the vertical force and of the torque about Z.
    pub loads: [u32; 4],
    /// Two variables that are 1 for loads at the patch and 0 for loads at the centre. The first belongs to the vertical load, the second to
    /// the loads in the road plane.
    pub patch: [u32; 2],
    /// Motion that holds the height.
    pub motion: Option<u32>,
}

/// Deck on the rig.
#[derive(Clone, Debug)]
pub(crate) struct Rigged {
    /// Deck with the statements of the rig.
    pub dataset: Dataset,
    /// Ids of the statements added for each wheel.
    pub wheels: Vec<WheelIds>,
}

fn marker_of(
    config: &Config,
    at: &Spelled,
    (dataset, model): (&Dataset, &Model),
) -> Result<MarkerIx, Diagnostic> {
    let address = Address::parse(&at.text, dataset)
        .map_err(|why| config.complain(at, why.code, why.message.clone()))?;
    let found = (address.kind == "MARKER")
        .then(|| address.id.and_then(|id| model.marker(id)))
        .flatten();
    found.ok_or_else(|| {
        config.complain(
            at,
            Code::WrongType,
            format!("the deck has no marker `{}`", at.text),
        )
    })
}

/// Returns the pose of a marker at design, in ground axes.
pub(crate) fn at_design(model: &Model, marker: MarkerIx) -> Pose {
    let frame = &model.markers[marker.0];
    model.parts[frame.part.0].pose.compose(&Pose {
        p: frame.qp,
        R: frame.R,
    })
}

/// Finds the wheels named in `kc.toml`.
///
/// # Errors
/// One diagnostic, with its place in the file, for each name that is missing or cannot be a wheel.
pub(crate) fn wheels(
    config: &Config,
    dataset: &Dataset,
    model: &Model,
) -> Result<Vec<FoundWheel>, Vec<Diagnostic>> {
    let mut found = Vec::new();
    let mut out = Vec::new();
    for side in config.sides() {
        let Some(wheel) = &config.wheels[side.index()] else {
            continue;
        };
        match find(config, (side, wheel), (dataset, model)) {
            Ok(wheel) => found.push(wheel),
            Err(why) => out.push(why),
        }
    }
    if out.is_empty() { Ok(found) } else { Err(out) }
}

fn find(
    config: &Config,
    (side, wheel): (Side, &WheelConfig),
    deck: (&Dataset, &Model),
) -> Result<FoundWheel, Diagnostic> {
    /// Smallest lateral component of a spin axis; a smaller one is a mistake in the file.
    const LEAST: f64 = 0.8;
    let (_, model) = deck;
    let centre = marker_of(config, &wheel.centre, deck)?;
    let part = model.markers[centre.0].part;
    if model.parts[part.0].kind != PartKind::Rigid {
        let message = format!("`{}` is not on a moving rigid part", wheel.centre.text);
        return Err(config.complain(&wheel.centre, Code::WrongType, message));
    }
    let pose = at_design(model, centre);
    let letter = ["x", "y", "z"]
        .iter()
        .position(|letter| wheel.spin.text.eq_ignore_ascii_case(letter));
    let axis: Vec3 = if let Some(k) = letter {
        pose.R.column(k).into()
    } else {
        let other = marker_of(config, &wheel.spin, deck)?;
        if model.markers[other.0].part != part {
            let message = format!(
                "`{}` is not on the same part as the wheel centre",
                wheel.spin.text
            );
            return Err(config.complain(&wheel.spin, Code::WrongType, message));
        }
        let between = at_design(model, other).p - pose.p;
        between.try_normalize(1e-9).ok_or_else(|| {
            let message =
                "the spin axis needs two different points, but `spin` lies at the wheel centre"
                    .to_string();
            config.complain(&wheel.spin, Code::WrongType, message)
        })?
    };
    let (p, o) = (config.frame.vector(&pose.p), config.frame.vector(&axis));
    if p.y * side.outboard_sign() <= 0.0 {
        let message = format!(
            "`{}` is not on the {} side of the vehicle in the axes `{}` of the deck",
            wheel.centre.text,
            side.word(),
            config.axes
        );
        return Err(config
            .complain(&wheel.centre, Code::BadSetting, message)
            .help("state the directions of X, Y and Z of the deck in `deck.axes`"));
    }
    if o.y.abs() < LEAST {
        let message = format!(
            "the spin axis `{}` does not lie across the vehicle: it is {:.0} degrees off",
            wheel.spin.text,
            libm::acos(o.y.abs()).to_degrees()
        );
        return Err(config.complain(&wheel.spin, Code::BadSetting, message));
    }
    let z = axis * (side.outboard_sign() * o.y.signum());
    let along = config.frame.to_deck(&Vec3::x());
    let x = (along - z * z.dot(&along)).normalize();
    let R = Mat3::from_columns(&[x, z.cross(&x), z]);
    let design = Pose { p: pose.p, R };
    let local = model.parts[part.0].pose.inverse().compose(&design);
    let steer_axis = wheel
        .steer_axis
        .as_ref()
        .map(|[lower, upper]| {
            Ok::<_, Diagnostic>([
                marker_of(config, lower, deck)?,
                marker_of(config, upper, deck)?,
            ])
        })
        .transpose()?;
    let travel_lock = wheel
        .travel_lock
        .as_ref()
        .map(|at| marker_of(config, at, deck))
        .transpose()?;
    Ok(FoundWheel {
        side,
        part: part.0,
        local,
        design,
        steer_axis,
        travel_lock,
    })
}

/// Collector of new statements, each with the next free id of its kind. One edit inserts them all before END.
struct Builder<'a> {
    dataset: &'a Dataset,
    next: std::collections::BTreeMap<String, u32>,
    text: Vec<u8>,
}

impl Builder<'_> {
    fn add(&mut self, kind: &str, name: &str, arguments: &[(&str, Option<String>)]) -> u32 {
        let statements = self.dataset.statements();
        let next = self.next.entry(kind.to_string()).or_insert_with(|| {
            let same = statements.iter().filter(|s| s.kind() == Some(kind));
            let last = same.filter_map(admire_syntax::Statement::number).max();
            // Ids start at the next thousand, so that they differ visibly from the deck's ids.
            (last.unwrap_or(0) / 1000 + 1) * 1000
        });
        *next += 1;
        let id = *next;
        let written = self.dataset.written(&NewStatement {
            kind: kind.to_string(),
            id: Some(id),
            view_name: Some(format!("kc_{name}")),
            arguments: arguments
                .iter()
                .map(|(name, value)| ((*name).to_string(), value.clone()))
                .collect(),
        });
        self.text.extend_from_slice(&written);
        self.text.push(b'\n');
        id
    }

    /// Returns the dataset with the collected statements.
    fn finish(self) -> Dataset {
        let end = self.dataset.end().map(|end| end.span.start());
        let mut text = self.text;
        if end.is_none() {
            text.insert(0, b'\n');
        }
        let at = end.unwrap_or(self.dataset.bytes().len());
        let edit = Edit::new(Span::at(at), text);
        let edited = self.dataset.edited(&[edit]);
        edited.expect("one edit does not overlap").value
    }

    fn marker(&mut self, name: &str, part: u32, frame: &Pose) -> u32 {
        let list = |values: [f64; 3]| Some(values.map(number).join(", "));
        let angles = psi_theta_phi(&frame.R);
        self.add(
            "MARKER",
            name,
            &[
                ("PART", Some(part.to_string())),
                ("QP", list(frame.p.into())),
                ("REULER", list(angles)),
            ],
        )
    }

    fn variable(&mut self, name: &str, function: String) -> u32 {
        self.add("VARIABLE", name, &[("FUNCTION", Some(function))])
    }
}

/// Formats a number with all its digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        "0.0".to_string()
    } else {
        format!("{value:.17E}")
    }
}

/// Puts a deck on the rig: removes the statements named in `kc.toml` and adds the statements of the rig.
///
/// # Errors
/// A diagnostic if a statement to be removed is missing or cannot be removed.
pub(crate) fn rigged(
    config: &Config,
    dataset: &Dataset,
    model: &Model,
    wheels: &[FoundWheel],
    variant: Variant,
) -> Result<Rigged, Diagnostic> {
    let mut dataset = dataset.clone();
    let lock = config
        .steering_lock
        .as_ref()
        .filter(|_| !variant.steering_locked);
    for at in config.without.iter().chain(lock) {
        let complain = |why: Diagnostic| config.complain(at, why.code, why.message);
        let address = Address::parse(&at.text, &dataset).map_err(complain)?;
        if matches!(address.kind.as_str(), "PART" | "MARKER" | "POINT_MASS") {
            let message =
                format!("{address} cannot be left out: only loads, motions and joints can");
            return Err(config.complain(at, Code::WrongType, message));
        }
        let edits = dataset.remove(&address).map_err(complain)?;
        dataset = dataset
            .edited(&edits)
            .expect("edits of one statement do not overlap")
            .value;
    }
    let mut builder = Builder {
        dataset: &dataset,
        next: std::collections::BTreeMap::new(),
        text: Vec::new(),
    };
    let ground = model
        .parts
        .iter()
        .find(|part| part.kind == PartKind::Ground)
        .map_or(1, |part| part.header.id);
    let length = 0.1 / model.units.length.si;
    let mut ids = Vec::new();
    for wheel in wheels {
        ids.push(add_wheel(
            &mut builder,
            config,
            model,
            (ground, length),
            wheel,
            variant,
        ));
    }
    Ok(Rigged {
        dataset: builder.finish(),
        wheels: ids,
    })
}

fn add_wheel(
    builder: &mut Builder<'_>,
    config: &Config,
    model: &Model,
    (ground, length): (u32, f64),
    wheel: &FoundWheel,
    variant: Variant,
) -> WheelIds {
    let side = wheel.side;
    let named = |name: &str| format!("{}_{name}", side.word());
    let part = model.parts[wheel.part].header.id;
    let centre = builder.marker(&named("centre"), part, &wheel.local);
    let out = Pose {
        p: wheel.local.point(&(Vec3::z() * length)),
        R: wheel.local.R,
    };
    let axis = builder.marker(&named("axis"), part, &out);
    let fixed = Pose {
        p: wheel.design.p,
        R: config.frame.from_deck.transpose(),
    };
    let g = builder.marker(&named("ground"), ground, &fixed);
    let reaction = builder.add(
        "MARKER",
        &named("reaction"),
        &[("PART", Some(ground.to_string())), ("FLOATING", None)],
    );
    let motion = variant.height_held.then(|| {
        builder.add(
            "MOTION",
            &named("height"),
            &[
                ("I", Some(centre.to_string())),
                ("J", Some(g.to_string())),
                ("Z", None),
                ("FUNCTION", Some("0.0".to_string())),
            ],
        )
    });
    let loads =
        ["fx", "fy", "fz", "mz"].map(|name| builder.variable(&named(name), "0.0".to_string()));
    let patch = ["vertical_at_patch", "plane_at_patch"]
        .map(|name| builder.variable(&named(name), "0.0".to_string()));
    let [_, _, fz, _] = loads;
    let total = builder.variable(
        &named("load"),
        match motion {
            Some(motion) => format!("VARVAL({fz})+MOTION({motion},0,4,{g})"),
            None => format!("VARVAL({fz})"),
        },
    );
    let v = |id: u32| format!("VARVAL({id})");
    let [ox, oy, oz] = ["X", "Y", "Z"].map(|k| {
        let function = format!("D{k}({axis},{centre},{g})/{}", number(length));
        v(builder.variable(&named(&format!("spin_{}", k.to_lowercase())), function))
    });
    let mut variable = |name: &str, function: String| v(builder.variable(&named(name), function));
    let tilt = variable("tilt", format!("SQRT(1-{oz}**2)"));
    // The lateral axis of the wheel in the road plane points to +Y on both sides; the longitudinal one points rearward.
    let sign = if side.outboard_sign() > 0.0 { "" } else { "-" };
    let hx = variable("heading_x", format!("{sign}{ox}/{tilt}"));
    let hy = variable("heading_y", format!("{sign}{oy}/{tilt}"));
    let (n, [fx, fy, _, mz]) = (v(total), loads.map(v));
    let fx_road = variable("road_x", format!("{fx}*{hy}+{fy}*{hx}"));
    let fy_road = variable("road_y", format!("{fy}*{hy}-{fx}*{hx}"));
    let torques = match &config.tyre {
        Some(tyre) => {
            let radius = match tyre.stiffness {
                // A tyre that pulls keeps the lever of the unloaded radius.
                Some(k) => format!(
                    "{}-MAX({n},0.0)/({}*{tilt})",
                    number(tyre.radius),
                    number(k)
                ),
                None => number(tyre.radius),
            };
            let reach = variable("reach", format!("({radius})/{tilt}"));
            let dx = variable("lever_x", format!("{reach}*{oz}*{ox}"));
            let dy = variable("lever_y", format!("{reach}*{oz}*{oy}"));
            let dz = variable("lever_z", format!("{reach}*({oz}**2-1)"));
            let [up, plane] = patch.map(v);
            [
                format!("{up}*{dy}*{n}-{plane}*{dz}*{fy_road}"),
                format!("{plane}*{dz}*{fx_road}-{up}*{dx}*{n}"),
                format!("{plane}*({dx}*{fy_road}-{dy}*{fx_road})+{mz}"),
            ]
        }
        None => ["0.0".to_string(), "0.0".to_string(), mz],
    };
    let [tx, ty, tz] = torques.map(Some);
    let arguments = [
        ("I", Some(centre.to_string())),
        ("JFLOAT", Some(reaction.to_string())),
        ("RM", Some(g.to_string())),
        ("FX", Some(fx_road)),
        ("FY", Some(fy_road)),
        ("FZ", Some(v(loads[2]))),
        ("TX", tx),
        ("TY", ty),
        ("TZ", tz),
    ];
    builder.add("GFORCE", &named("loads"), &arguments);
    WheelIds {
        side,
        centre,
        ground: g,
        loads,
        patch,
        motion,
    }
}
