//! FIELDs that Adams/Car writes for its bushings. The parameters of their user subroutine contain the ids of the SPLINEs and ARRAYs that
//! define a bushing.
//!
//! No public dataset of Adams/Car was found. The sources of this interpretation are listed in `grammar/NOTES.md`. All other FIELDs keep
//! their subroutine.

use std::collections::BTreeMap;

use crate::{Address, Dataset, Stated, Statement, Value, as_id};

/// Axis words in the names of curves and arrays, in the order of the components of a FIELD.
const WORDS: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];
/// Names of the components in results, in the same order.
const COMPONENTS: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];
/// Largest deviation of an odd curve from its mirror image, relative to its largest value. Files give six digits or more.
const ODD_RELATIVE: f64 = 1e-6;
/// Largest number of parameters that a message lists.
const MAX_LISTED: usize = 8;

/// Curves and arrays of a bushing of Adams/Car, whose ids are parameters of the user subroutine of a FIELD.
#[derive(Clone, PartialEq, Debug)]
pub struct CarField {
    /// Name of the bushing, which is the common prefix of the names of its curves and arrays.
    pub bushing: String,
    /// Ids of the SPLINEs `tx_spline` to `rz_spline`.
    pub curves: [u32; 6],
    /// Ids of the ARRAYs `tx_data_array` to `rz_data_array`.
    pub arrays: [u32; 6],
    /// Parameters that are neither the id of a curve nor the id of an array of the bushing.
    pub others: Vec<f64>,
}

/// Parameters of one axis of a bushing of Adams/Car. The law is `F = preload - scale C(stretch d - offset)`, where C is the curve of the
/// axis and d the displacement.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CarAxis {
    /// Scale of the curve.
    pub scale: f64,
    /// Constant term of the force or torque on I.
    pub preload: f64,
    /// Offset that is subtracted from the scaled displacement.
    pub offset: f64,
    /// Scale of the displacement.
    pub stretch: f64,
    /// Damping coefficient (force per velocity), multiplied by its scale and by the scale of the velocity.
    pub damping: f64,
}

impl CarAxis {
    /// Number of values in the array of an axis.
    pub const LENGTH: usize = 11;
    /// Index (from 0) of the scale of the stiffness in the array of an axis.
    pub const SCALE: usize = 2;
    /// Index (from 0) of the preload in the array of an axis.
    pub const PRELOAD: usize = 6;
    /// Index (from 0) of the offset of the displacement in the array of an axis.
    pub const OFFSET: usize = 7;
    /// Index (from 0) of the scale of the displacement in the array of an axis.
    pub const STRETCH: usize = 8;
    /// Indices (from 0) of scale, preload, offset and stretch in the array of an axis.
    pub const PLACES: [usize; 4] = [Self::SCALE, Self::PRELOAD, Self::OFFSET, Self::STRETCH];

    /// Reads the array of an axis. Its values have the order of Adams/Car: type, value and scale of the stiffness; type, value and scale of
    /// the damping; preload; offset and scale of the displacement; offset and scale of the velocity.
    ///
    /// # Errors
    /// Returns the reason why the array cannot be read, as the predicate of a sentence: `has 9 numbers, instead of 11`.
    pub fn read(numbers: &[f64]) -> Result<Self, String> {
        let &[
            kind,
            value,
            scale,
            damping_kind,
            damping,
            damping_scale,
            preload,
            offset,
            stretch,
            velocity_offset,
            velocity_scale,
        ] = numbers
        else {
            return Err(format!(
                "has {} numbers, instead of {}",
                numbers.len(),
                Self::LENGTH
            ));
        };
        if let Some(kind) = [kind, damping_kind].iter().find(|kind| kind.fract() != 0.0) {
            return Err(format!("has type {kind}, which is not a whole number"));
        }
        if value != 0.0 {
            return Err(format!(
                "has both a stiffness of {value} and a curve; which of them applies is unknown"
            ));
        }
        let damping = damping * damping_scale * velocity_scale;
        if damping != 0.0 && velocity_offset != 0.0 {
            return Err(format!(
                "has a velocity offset of {velocity_offset}; its sign convention is unknown"
            ));
        }
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err("has a number that is not finite".to_string());
        }
        Ok(Self {
            scale,
            preload,
            offset,
            stretch,
            damping,
        })
    }
}

impl CarField {
    /// Reads a FIELD whose values come from a user subroutine. `user` is the text of the call, `USER(...)`. `stated` returns the statement
    /// with a given kind and id.
    ///
    /// Returns `None` if no parameter is the id of a curve or array that is named like those of a bushing of Adams/Car.
    ///
    /// # Errors
    /// Returns the reason why the FIELD is not read as a bushing. An object may be missing or belong to another bushing, or an array or a
    /// curve may be unsuitable.
    pub fn read<'a>(
        dataset: &'a Dataset,
        field: &Statement,
        user: &str,
        stated: impl Fn(&'static str, u32) -> Option<Stated<'a>>,
    ) -> Option<Result<Self, String>> {
        let mut found: BTreeMap<(&str, usize), (u32, String)> = BTreeMap::new();
        let mut others = Vec::new();
        for number in parameters(user) {
            let mut named = false;
            for (kind, ending) in [("SPLINE", "_spline"), ("ARRAY", "_data_array")] {
                let id = as_id(number);
                let Some(statement) = id.and_then(|id| dataset.statement(kind, Some(id))) else {
                    continue;
                };
                let name = dataset.name(statement);
                let Some((bushing, last)) = name.rsplit_once('.') else {
                    continue;
                };
                let last = last.to_ascii_lowercase();
                let word = last.strip_suffix(ending);
                let axis = WORDS.iter().position(|axis| word == Some(*axis));
                if let (Some(axis), Some(id)) = (axis, id) {
                    found.insert((kind, axis), (id, bushing.to_string()));
                    named = true;
                }
            }
            if !named {
                others.push(number);
            }
        }
        let bushing = found.values().next()?.1.clone();
        let read = Self::named(&dataset.name(field), &bushing, &found, others);
        let array = |id| stated("ARRAY", id).map_or_else(Vec::new, |a| values(&a, "NUMBERS"));
        let curve = |id| {
            let spline = stated("SPLINE", id)?;
            let of_file = spline.latest(&["FILE", "X", "Y"]).next() == Some("FILE");
            (!of_file).then(|| (values(&spline, "X"), values(&spline, "Y")))
        };
        Some(read.and_then(|read| match read.misfit(array, curve) {
            None => Ok(read),
            Some(why) => Err(why),
        }))
    }

    /// Creates the field from the curves and arrays found by their names. `own` is the name of the FIELD. Returns the reason as an error if
    /// an object is missing or the objects belong to different bushings.
    fn named(
        own: &str,
        bushing: &str,
        found: &BTreeMap<(&str, usize), (u32, String)>,
        others: Vec<f64>,
    ) -> Result<Self, String> {
        let same = |name: &str| name.eq_ignore_ascii_case(bushing);
        if let Some((_, other)) = found.values().find(|(_, other)| !same(other)) {
            return Err(format!(
                "its parameters name objects of `{bushing}` and of `{other}`"
            ));
        }
        let parent = own.rsplit_once('.').map_or("", |(parent, _)| parent);
        if !same(own) && !same(parent) {
            return Err(format!(
                "its parameters name objects of `{bushing}`, but the FIELD is called `{own}`"
            ));
        }
        let object = |kind: &'static str, axis: usize| {
            let ending = if kind == "SPLINE" {
                "spline"
            } else {
                "data_array"
            };
            let id = found.get(&(kind, axis)).map(|(id, _)| *id);
            id.ok_or_else(|| {
                format!(
                    "its parameters name no {kind} `{bushing}.{}_{ending}`",
                    WORDS[axis]
                )
            })
        };
        let (mut curves, mut arrays) = ([0; 6], [0; 6]);
        for axis in 0..6 {
            curves[axis] = object("SPLINE", axis)?;
            arrays[axis] = object("ARRAY", axis)?;
        }
        Ok(Self {
            bushing: bushing.to_string(),
            curves,
            arrays,
            others,
        })
    }

    /// Returns the address of a value in the array of an axis. `index` counts from 0, as in [`CarAxis::SCALE`].
    pub fn parameter(&self, axis: usize, index: usize) -> Address {
        Address::of_argument("ARRAY", self.arrays[axis], "NUMBERS", Some(index + 1))
    }

    /// Returns the name of an axis as used in results: `bkl_arm_outer.fx`.
    pub fn axis(&self, axis: usize) -> String {
        format!("{}.{}", self.bushing, COMPONENTS[axis])
    }

    /// Returns the reason why the array or the curve of an axis is unsuitable, for the first such axis; `None` if there is no such axis.
    /// `array` returns the numbers of the ARRAY with a given id. `curve` returns x and y of the SPLINE with a given id, or `None` if its
    /// points are in a file.
    pub fn misfit(
        &self,
        array: impl Fn(u32) -> Vec<f64>,
        curve: impl Fn(u32) -> Option<(Vec<f64>, Vec<f64>)>,
    ) -> Option<String> {
        (0..6).find_map(|axis| {
            let name = self.axis(axis);
            if let Err(why) = CarAxis::read(&array(self.arrays[axis])) {
                return Some(format!("the array of `{name}` {why}"));
            }
            let (x, y) = curve(self.curves[axis])?;
            if x.len() < 2 || x.len() != y.len() {
                return Some(format!("the SPLINE of `{name}` needs at least two points, and as many y values as x values"));
            }
            let is_odd = opposite(&x) && opposite(&y);
            (axis < 2 && !is_odd).then(|| {
                format!("the curve of `{name}` is not an odd function; the coupling of x and y is known only for odd curves")
            })
        })
    }

    /// Iterates over the FIELDs of a dataset that refer to objects of a bushing of Adams/Car, each with the result of [`Self::read`].
    pub fn all(dataset: &Dataset) -> impl Iterator<Item = (&Statement, Result<Self, String>)> {
        let fields = dataset.statements().iter();
        let fields = fields.filter(|statement| statement.kind() == Some("FIELD"));
        fields.filter_map(|field| {
            let argument = field.argument("FUNCTION")?;
            if !matches!(argument.value, Value::User(_)) {
                return None;
            }
            let user = argument.text(dataset.source())?;
            let read = Self::read(dataset, field, &user, |kind, id| {
                let statement = dataset.statement(kind, Some(id))?;
                Some(Stated::plain(statement, dataset.source()))
            })?;
            Some((field, read))
        })
    }
}

/// Returns the numbers of an argument.
fn values(stated: &Stated, name: &str) -> Vec<f64> {
    stated.numbers(name).iter().map(|n| n.value).collect()
}

/// Returns true if the sequence is antisymmetric: each value is the negative of its mirror image, within the tolerance [`ODD_RELATIVE`].
fn opposite(values: &[f64]) -> bool {
    let tolerance = ODD_RELATIVE * values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let mut pairs = values.iter().zip(values.iter().rev());
    pairs.all(|(a, b)| (a + b).abs() <= tolerance)
}

/// Returns the numeric parameters of a USER call.
pub fn parameters(user: &str) -> impl Iterator<Item = f64> + '_ {
    let inside = user.split_once('(').map_or("", |(_, inside)| inside);
    let words = inside.trim_end().trim_end_matches(')').split(',');
    words.filter_map(|w| w.trim().trim_start_matches(',').parse::<f64>().ok())
}

/// Returns the message that the built-in solver reads FIELDs as bushings of Adams/Car, and the help text of this message. `count` is the
/// number of FIELDs. `others` contains the parameters whose meaning is unknown.
pub fn reading(count: usize, others: &[f64]) -> (String, String) {
    let subject = match count {
        1 => "1 FIELD is read as a bushing".to_string(),
        _ => format!("{count} FIELDs are read as bushings"),
    };
    let message = format!(
        "{subject} of Adams/Car: F = preload - force scale * C(displacement scale * d - offset), with an Akima curve C; x and y are coupled radially"
    );
    let mut listed: Vec<String> = others.iter().map(f64::to_string).collect();
    listed.dedup();
    listed.truncate(MAX_LISTED);
    let help = if listed.is_empty() {
        "recognised by the names of its curves and arrays; unverified, because no dataset of Adams/Car was available"
            .to_string()
    } else {
        format!(
            "recognised by the names of its curves and arrays; the parameters {} are not used",
            listed.join(", ")
        )
    };
    (message, help)
}
