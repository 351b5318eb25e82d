//! Template of a new study: a commented `study.toml` made from the contents of a deck, and tables to fill in.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::kc_starter::{
    CENTRE_WORDS, WHEEL_WORDS, is_number, kc_toml, looks_like_iso, number, spin_axis,
};
use super::schema::schema;
use admire_solver::mechanics::{Mat3, Vec3};
use admire_solver::model::{MarkerIx, Model, Part, PartKind, SforceKind};

/// Kind of measurement that a study may contain.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Kind {
    /// Marks (measured points) on parts, measured by a coordinate measuring machine or cameras.
    Marks,
    /// Position and angles of the wheel, measured by a K&C rig.
    Wheel,
    /// Toe, camber and other curves of a wheel, measured by a K&C rig.
    Curves,
    /// Readings of any scalar sensors.
    Readings,
}

/// A load of the deck that the load cases may drive.
#[derive(Clone, PartialEq, Debug)]
struct Driven {
    /// Name of the load's column in the file of load cases.
    column: String,
    /// Address of the driven parameter in the deck.
    target: String,
    /// Description of the load.
    what: String,
}

/// Template of a new study for one deck.
#[derive(Clone, Debug)]
pub struct Starter<'a> {
    model: &'a Model,
    loads: Vec<Driven>,
    /// Marker that most resembles the centre of a wheel; `None` if no marker resembles one.
    wheel: Option<MarkerIx>,
}

impl<'a> Starter<'a> {
    /// Creates the template for a deck: searches its model for loads that can be driven and for a wheel.
    pub fn of(model: &'a Model) -> Self {
        let loads = loads(model);
        Self {
            wheel: wheel(model),
            model,
            loads,
        }
    }

    /// Returns the addresses of all bushings of the deck.
    pub fn bushings(&self) -> Vec<String> {
        let address =
            |found: &admire_solver::model::Bushing| format!("BUSHING/{}", found.header.id);
        self.model.bushings.iter().map(address).collect()
    }

    /// Returns descriptions of the bushings, loads and wheel found in the deck, one line each.
    pub fn found(&self) -> Vec<String> {
        /// Maximum number of list entries that are shown. Further entries are only counted.
        const LISTED: usize = 12;
        let many = |list: Vec<String>, none: &str| match list.len() {
            0 => none.to_string(),
            count if count > LISTED => {
                let first = list[..LISTED].join(", ");
                format!("{first} and {} more", count - LISTED)
            }
            _ => list.join(", "),
        };
        let loads = self.loads.iter().map(|load| load.target.clone()).collect();
        let wheel = self.wheel.map(|at| self.marker(at)).into_iter().collect();
        vec![
            format!(
                "bushings  {}",
                many(
                    self.bushings(),
                    "none: name other numbers in identify.stiffnesses"
                )
            ),
            format!(
                "loads     {}",
                many(
                    loads,
                    "none with a constant FUNCTION: name the loads in loads.columns"
                )
            ),
            format!(
                "wheel     {}",
                many(wheel, "no part or marker looks like a wheel")
            ),
        ]
    }

    fn marker(&self, at: MarkerIx) -> String {
        let marker = &self.model.markers[at.0];
        let part = &self.model.parts[marker.part.0].header.name;
        format!("MARKER/{} on {part}", marker.header.id)
    }

    /// Returns the files of the new study, as pairs of name and text. `deck` is the path of the deck, and `kinds` the kinds of measurements.
    /// `bushings` holds the addresses of the bushings to identify; if it is empty, all are identified.
    pub fn files(
        &self,
        deck: &str,
        kinds: &BTreeSet<Kind>,
        bushings: &[String],
    ) -> Vec<(String, String)> {
        let mut files = vec![
            ("study.toml".to_string(), self.toml(deck, kinds, bushings)),
            ("load_cases.csv".to_string(), self.load_cases()),
        ];
        let parts = self.parts();
        if kinds.contains(&Kind::Marks) {
            let on_parts = format!(
                "part,mark,x,y,z\n# Position of each mark on its part, in the part's own frame; {}.\n# Three or more marks per part, not on one line.\n# part is one of: {parts}\n# {},1,10.0,-20.0,5.0\n",
                self.length(),
                self.example_part(),
            );
            files.push(("marks_on_parts.csv".to_string(), on_parts));
            let measured = format!(
                "case,part,mark,x,y,z\n# Position of each mark in each load case, in the ground frame; {}.\n# 1,{},1,110.0,-620.0,205.0\n",
                self.length(),
                self.example_part(),
            );
            files.push(("marks_measured.csv".to_string(), measured));
        }
        if kinds.contains(&Kind::Wheel) {
            let text = format!(
                "case,x,y,z,camber_deg,steer_deg\n# Wheel centre in the ground frame, {}; angles from the design position, see `admire guide study`.\n# 1,0.4,-720.1,305.2,-0.31,0.05\n",
                self.length()
            );
            files.push(("wheel.csv".to_string(), text));
        }
        if kinds.contains(&Kind::Curves) {
            let mut text =
                String::from("case,toe_deg,camber_deg,caster_deg,travel_mm,base_mm,track_mm\n");
            text += "# Readings of the rig at the wheel in each load case, loops in the order driven; an empty cell is a missing reading.\n";
            text += "# Names and units of the columns may be those of your rig: `Toe [min]`, `Wheel travel [mm]`.\n";
            text += "# 1,0.012,-0.310,0.040,12.5,0.42,-0.15\n";
            files.push(("kc.csv".to_string(), text));
        }
        if kinds.contains(&Kind::Readings) {
            files.push((
                "readings.csv".to_string(),
                "case,top_height\n# One column per channel of [readings.channels]; an empty cell is a missing reading.\n# 1,305.2\n".to_string(),
            ));
        }
        if let Some(wheel) = self.wheel {
            files.push(("kc.toml".to_string(), kc_toml(self.model, wheel)));
        }
        let schema = serde_json::to_string_pretty(&schema()).expect("a schema prints");
        files.push(("study.schema.json".to_string(), schema + "\n"));
        files
    }

    fn length(&self) -> String {
        format!("in {}", self.model.units.length.word)
    }

    fn rigid(&self) -> impl Iterator<Item = &Part> {
        self.model
            .parts
            .iter()
            .filter(|part| part.kind != PartKind::Ground)
    }

    fn parts(&self) -> String {
        let name = |part: &Part| {
            let (id, name) = (part.header.id, &part.header.name);
            if name.is_empty() {
                id.to_string()
            } else {
                format!("{name} ({id})")
            }
        };
        self.rigid().map(name).collect::<Vec<_>>().join(", ")
    }

    fn example_part(&self) -> String {
        let first = self.rigid().next();
        first.map_or_else(
            || "1".to_string(),
            |part| {
                let plain =
                    !part.header.name.is_empty() && !part.header.name.contains([',', '"', ';']);
                if plain {
                    part.header.name.clone()
                } else {
                    part.header.id.to_string()
                }
            },
        )
    }

    fn load_cases(&self) -> String {
        let columns: Vec<&str> = self.loads.iter().map(|load| load.column.as_str()).collect();
        let mut text = format!("case,{}\n", columns.join(","));
        text += "# One row per load case, in the order they were applied on the rig; friction depends on this order. The values replace those of the deck.\n";
        for load in &self.loads {
            writeln!(text, "# {}: {}", load.column, load.what).expect("writing to a string");
        }
        let vertical = columns
            .iter()
            .position(|name| *name == "vertical")
            .unwrap_or(0);
        let example: Vec<&str> = (0..columns.len())
            .map(|at| if at == vertical { "1500" } else { "0" })
            .collect();
        text + &format!("# 1,{}\n", example.join(","))
    }

    fn toml(&self, deck: &str, kinds: &BTreeSet<Kind>, bushings: &[String]) -> String {
        let mut text = format!(
            "#:schema ./study.schema.json
# A study: one model, the loads of a rig, what was measured on it.
# `admire check .` says what is still missing; `admire guide study` explains the format, `admire explain KEY` a key.

[model]
deck = {}

[loads]
file = \"load_cases.csv\"             # case,<one column per load>, in the order of application
",
            quoted(deck)
        );
        if self.loads.is_empty() {
            text += "# FILL IN: what each column drives, for example { vertical = \"SFORCE/3\", lateral = \"GFORCE/1.FY\", lift = \"MOTION/1\" }\ncolumns = {}\n";
        } else {
            let columns: Vec<String> = self
                .loads
                .iter()
                .map(|load| format!("{} = {}", load.column, quoted(&load.target)))
                .collect();
            text += "# Found in the deck; remove what the rig does not drive; the columns may be renamed.\n";
            text += &format!("columns = {{ {} }}\n", columns.join(", "));
        }
        if kinds.contains(&Kind::Marks) {
            text += "
[marks]                             # marks on parts, measured by a coordinate measuring machine or cameras
on_parts = \"marks_on_parts.csv\"     # part,mark,x,y,z       in each part's own frame
measured = \"marks_measured.csv\"     # case,part,mark,x,y,z  in the ground frame
# sigma = 0.05                      # standard deviation of one coordinate, in the length unit of the deck; if left out, estimated from the marks
";
        }
        if kinds.contains(&Kind::Wheel) {
            text += "\n[wheel]                             # position and angles of the wheel\n";
            text += &self.wheel_keys();
            text += "measured = \"wheel.csv\"              # case,x,y,z,camber_deg,steer_deg\n# sigma = { position = 0.05, angle_deg = 0.01 }\n";
        }
        if kinds.contains(&Kind::Curves) {
            text += "
[kc]                                # curves of a K&C rig, of one wheel
file = \"kc.csv\"                     # one row per load case
";
            text += &self.wheel_keys();
            let forward = self.wheel.is_some_and(|at| looks_like_iso(self.model, at));
            text += if forward {
                "forward = \"+x\"                      # forward direction of the vehicle, from the names of its sides; CHECK\n"
            } else {
                "forward = \"-x\"                      # forward direction of the vehicle, an axis of ground; CHECK\n"
            };
            text += "\
# relative_to = \"1\"                 # the case in which the readings of the rig were set to zero
# summary = \"kc_summary.csv\"        # gradients and loop widths, see `admire guide study`
[kc.curves]                         # remove the curves that were not measured; `admire check` shows which column is used
toe = {}                            # or { column = \"Toe-in [min]\", sigma = 0.3 }; sigma: sd of a reading; without it,
camber = {}                         # estimated from repeated cases, or by the fit
caster = {}
travel = {}
base = {}
track = {}
";
        }
        if kinds.contains(&Kind::Readings) {
            let marker = self.wheel.map_or_else(
                || "11".to_string(),
                |at| self.model.markers[at.0].header.id.to_string(),
            );
            text += &format!(
                "
[readings]                          # any scalar reading of a sensor, as an ADAMS function of the deck
file = \"readings.csv\"               # case,<one column per channel>
[readings.channels]
top_height = {{ function = \"DZ({marker})\", sigma = 0.1, unit = \"{}\" }}   # FILL IN: your own channels
",
                self.model.units.length.word
            );
        }
        let all = self.bushings();
        let chosen = if bushings.is_empty() {
            &all[..]
        } else {
            bushings
        };
        text += "\n[identify]\n";
        if chosen.is_empty() {
            text += "# FILL IN: the numbers to identify, for example\n# stiffnesses = [\"SPRINGDAMPER/1.K\"]\n";
        } else {
            let names: Vec<String> = chosen.iter().map(|name| quoted(name)).collect();
            text += &format!(
                "bushings = [{}]   # the six stiffnesses of each are identified\n",
                names.join(", ")
            );
        }
        let sound = self
            .model
            .bushings
            .iter()
            .all(|bushing| bushing.k.iter().chain(&bushing.kt).all(|k| *k > 0.0));
        if sound && !all.is_empty() {
            text += "initial = \"deck\"                   # start at the deck's values; or { translational = 1.0e4, rotational_per_degree = 1.0e4 }\n";
        } else {
            text += "initial = { translational = 1.0e4, rotational_per_degree = 1.0e4 }   # start values\n";
        }
        text += "# symmetry = { default = \"radial-z\" }   # round bushings: Kx = Ky, KTx = KTy

# [validate]
# hold_out = [\"3\", \"7\"]             # cases or curves that are held out of every fit, to validate the result
";
        text
    }

    /// Returns the lines of `study.toml` for the marker and the spin axis of the wheel.
    fn wheel_keys(&self) -> String {
        match self.wheel {
            Some(at) => format!(
                "marker = \"MARKER/{}\"                # looks like the wheel centre: {}; CHECK\naxis = \"{}\"\n",
                self.model.markers[at.0].header.id,
                self.marker(at),
                spin_axis(self.model, at)
            ),
            None => "marker = \"MARKER/?\"                 # FILL IN: a marker at the wheel centre, on the carrier\naxis = \"y\"                         # axis of this marker about which the wheel spins\n".to_string(),
        }
    }
}

/// Returns the text as a TOML string literal.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

fn loads(model: &Model) -> Vec<Driven> {
    let mut found = Vec::new();
    let mut taken = BTreeSet::from(["case".to_string()]);
    let mut add = |name: &str, usual: String, target: String, what: String| {
        let wanted = if column(name).is_empty() {
            usual
        } else {
            column(name)
        };
        let mut free = wanted.clone();
        let mut count = 2;
        while !taken.insert(free.clone()) {
            free = format!("{wanted}_{count}");
            count += 1;
        }
        found.push(Driven {
            column: free,
            target,
            what,
        });
    };
    for force in model
        .sforces
        .iter()
        .filter(|force| force.header.active && is_number(&force.function))
    {
        let rotational = force.kind == SforceKind::Rotational;
        let along = sforce_direction(model, force.i, force.j, force.action_only || rotational);
        let usual = along.and_then(direction).map_or_else(
            || format!("sforce_{}", force.header.id),
            |word| {
                if rotational {
                    format!("{word}_torque")
                } else {
                    word.to_string()
                }
            },
        );
        let what = if rotational {
            "torque".to_string()
        } else {
            format!("force in {}", model.units.force.word)
        };
        let on = &model.parts[model.markers[force.i.0].part.0].header.name;
        let along = along.map_or_else(String::new, |d| {
            format!(" along ({:.2}, {:.2}, {:.2}) in ground axes", d.x, d.y, d.z)
        });
        add(
            "",
            usual,
            format!("SFORCE/{}", force.header.id),
            format!(
                "{what} of SFORCE/{} on {on}{along} at design; {} in the deck",
                force.header.id,
                number(&force.function).unwrap_or_default()
            ),
        );
    }
    for force in model
        .vector_forces
        .iter()
        .filter(|force| force.header.active)
    {
        let kind = format!("{:?}", force.kind).to_uppercase();
        let on = &model.parts[model.markers[force.i.0].part.0].header.name;
        let axes = force.rm.map_or_else(Mat3::identity, |rm| {
            let frame = &model.markers[rm.0];
            model.parts[frame.part.0].pose.R * frame.R
        });
        for (k, (component, word)) in force
            .components
            .iter()
            .zip(["FX", "FY", "FZ", "TX", "TY", "TZ"])
            .enumerate()
        {
            let Some(own) = component.as_ref().and_then(number) else {
                continue;
            };
            let along: Vec3 = axes.column(k % 3).into();
            let turns = if k < 3 { "" } else { "_torque" };
            let usual = direction(along).map_or_else(
                || format!("{}_{}", kind.to_lowercase(), word.to_lowercase()),
                |word| format!("{word}{turns}"),
            );
            add(
                "",
                usual,
                format!("{kind}/{}.{word}", force.header.id),
                format!(
                    "{word} of {kind}/{} on {on} along ({:.2}, {:.2}, {:.2}) in ground axes at design; {own} in the deck",
                    force.header.id, along.x, along.y, along.z
                ),
            );
        }
    }
    for motion in model
        .motions
        .iter()
        .filter(|motion| motion.header.active && is_number(&motion.function))
    {
        let id = motion.header.id;
        add(
            &motion.header.name,
            format!("motion_{id}"),
            format!("MOTION/{id}"),
            format!("displacement that MOTION/{id} prescribes"),
        );
    }
    found
}

/// Returns the direction of an SFORCE in ground, in the design position. It is the z axis of J if `along_j` is true, otherwise the line from J
/// to I.
fn sforce_direction(model: &Model, i: MarkerIx, j: MarkerIx, along_j: bool) -> Option<Vec3> {
    let [i, j] = [i, j].map(|at| {
        let marker = &model.markers[at.0];
        let part = &model.parts[marker.part.0].pose;
        (part.point(&marker.qp), part.R * marker.R)
    });
    let line = if along_j {
        Vec3::from(j.1.column(2))
    } else {
        i.0 - j.0
    };
    line.try_normalize(1e-9)
}

/// Returns a word for a direction near an axis of ground; `None` for other directions.
fn direction(along: Vec3) -> Option<&'static str> {
    let words = ["longitudinal", "lateral", "vertical"];
    (0..3)
        .find(|&axis| along[axis].abs() > 0.9)
        .map(|axis| words[axis])
}

/// Converts the view name of an element to a column name.
fn column(name: &str) -> String {
    let last = name.rsplit('.').next().unwrap_or_default();
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        }
    };
    last.chars()
        .map(plain)
        .collect::<String>()
        .trim_matches('_')
        .to_string()
}

/// Returns the number of wheel words that a name contains.
fn wheel_words(name: &str) -> usize {
    let name = name.to_lowercase();
    WHEEL_WORDS
        .iter()
        .filter(|word| name.contains(**word))
        .count()
}

/// Returns the number of force components at a marker whose FUNCTION is a plain number. Typically, a rig drives such components.
fn numbers_at(model: &Model, at: MarkerIx) -> usize {
    let scalar = model
        .sforces
        .iter()
        .filter(|force| force.i == at && is_number(&force.function));
    let vector = model.vector_forces.iter().filter(|force| force.i == at);
    let components = vector.flat_map(|force| force.components.iter().take(3).flatten());
    scalar.count() + components.filter(|function| is_number(function)).count()
}

/// Returns the marker that most resembles the centre of a wheel. The name of the marker, the name of its part and the loads at the marker are
/// scored. If no name is informative, a marker with several constant force components is returned.
fn wheel(model: &Model) -> Option<MarkerIx> {
    let score = |at: usize| {
        let marker = &model.markers[at];
        let part = &model.parts[marker.part.0];
        if part.kind == PartKind::Ground || marker.floating || part.cm == Some(MarkerIx(at)) {
            return 0;
        }
        let name = marker.header.name.to_lowercase();
        let part_name = part.header.name.to_lowercase();
        // Wheel words that the part's name contains as well do not count, because names of other markers on the carrier, such as `CARRIER_M1`,
        // repeat them.
        let own = WHEEL_WORDS
            .iter()
            .filter(|word| name.contains(**word) && !part_name.contains(**word))
            .count();
        let mut tokens = name.split(|c: char| !c.is_alphanumeric());
        let centre = tokens.any(|token| ["wc", "wcl", "wcr"].contains(&token))
            || (wheel_words(&name) > 0 && CENTRE_WORDS.iter().any(|word| name.contains(word)));
        let scalar = model.sforces.iter().filter(|force| force.i.0 == at);
        let vector = model.vector_forces.iter().filter(|force| force.i.0 == at);
        let loaded = scalar.count() + vector.count();
        let on_part = wheel_words(&part.header.name);
        if own + on_part + usize::from(centre) == 0 {
            // If no name is informative, a marker qualifies if several constant force components act at it.
            return usize::from(numbers_at(model, MarkerIx(at)) > 1);
        }
        8 * own + 12 * usize::from(centre) + 3 * on_part + 2 * loaded.min(3)
    };
    let best = (0..model.markers.len()).max_by_key(|&at| (score(at), std::cmp::Reverse(at)))?;
    (score(best) > 0).then_some(MarkerIx(best))
}
