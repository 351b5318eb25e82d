use std::collections::BTreeMap;

use super::{ResultsError, ResultsReader, Selection, StepKind};

/// Largest differences that count as round-off, by unit.
///
/// The floor of a unit is a share of the largest magnitude in that unit, over all columns and steps read so far. A torque is a force times a
/// length, so the product of the largest force and the largest length counts as a torque, too. Every magnitude counts as at least 1e-12 of
/// its unit. Columns without a unit may hold different quantities, so their floor is computed from this minimum alone.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct DifferenceFloor {
    share: f64,
    largest: BTreeMap<String, f64>,
}

impl DifferenceFloor {
    /// Default share of the largest magnitude up to which a difference counts as round-off.
    pub const DEFAULT_SHARE: f64 = 1e-12;
    /// Lower limit of the largest magnitude of a unit. It replaces smaller magnitudes in the computation of the floor.
    const MIN_LARGEST: f64 = 1e-12;

    /// Creates a floor with this share of the largest magnitudes. With a share of 0, values are compared exactly.
    pub fn new(share: f64) -> Self {
        Self {
            share,
            largest: BTreeMap::new(),
        }
    }

    /// Reads the remaining output steps of a file and keeps the largest finite magnitude of each unit. Steps of kind `input` are skipped.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read further.
    pub fn look(&mut self, reader: &mut dyn ResultsReader) -> Result<(), ResultsError> {
        let columns = Selection::all(reader.catalogue()).columns;
        let units: Vec<Option<String>> = columns
            .iter()
            .map(|column| column.units.as_deref().map(str::to_ascii_lowercase))
            .collect();
        let mut largest = vec![0.0_f64; columns.len()];
        let mut values = Vec::new();
        while let Some(step) = reader.next_step()? {
            if step.kind == StepKind::Input {
                continue;
            }
            step.values(&mut values)?;
            for (largest, column) in largest.iter_mut().zip(&columns) {
                let size = values[column.id - 1].abs();
                if size.is_finite() {
                    *largest = largest.max(size);
                }
            }
        }
        for (unit, size) in units.into_iter().zip(largest) {
            let Some(unit) = unit.filter(|unit| unit != NO_UNIT) else {
                continue;
            };
            let known = self.largest.entry(unit).or_insert(0.0);
            *known = known.max(size);
        }
        Ok(())
    }

    /// Returns the largest difference that counts as round-off, in the unit of the column.
    pub fn of(&self, unit: Option<&str>) -> f64 {
        let unit = unit.unwrap_or(NO_UNIT).to_ascii_lowercase();
        let of = |unit: &str| self.largest.get(unit).copied().unwrap_or(0.0);
        let product = match unit.split_once('-') {
            Some((force, length)) => of(force) * of(length),
            None => 0.0,
        };
        self.share * of(&unit).max(product).max(Self::MIN_LARGEST)
    }
}

/// Unit of columns whose values have no unit.
const NO_UNIT: &str = "no_units";

#[cfg(test)]
mod tests {
    use super::DifferenceFloor;
    use crate::{Tolerance, XrfReader, compare_above};

    /// Returns a results file with one step: a force, a length, a torque and a number without unit.
    fn file(values: [f64; 4]) -> Vec<u8> {
        let [force, length, torque, number] = values;
        let component = |name: &str, unit: &str, id: usize| {
            format!("<Component name=\"{name}\" unitsValue=\"{unit}\" id=\"{id}\" />\n")
        };
        let components = [
            component("FX", "newton", 2),
            component("X", "mm", 3),
            component("TX", "newton-mm", 4),
            component("Q", "no_units", 5),
        ];
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Results xmlns=\"http://www.mscsoftware.com/:xrf10\">\n\
             <Analysis name=\"a\" executionDate=\"x\" Solver=\"s\" script=\"-unknown-\">\n\
             <Units angle=\"rad\" length=\"mm\" mass=\"kg\" time=\"sec\" />\n<StepMap name=\"map_001\">\n\
             <Entity name=\"time\">\n{}</Entity>\n<Entity name=\"e\">\n{}</Entity>\n</StepMap>\n\
             <Data name=\"dynamic_001\" id=\"1\">\n<Step type=\"dynamic\">\n0 {force:e} {length:e} {torque:e} \
             {number:e}\n</Step>\n</Data>\n</Analysis>\n</Results>\n",
            component("TIME", "sec", 1),
            components.concat()
        )
        .into_bytes()
    }

    /// Returns the names of the columns in which two files differ.
    fn differing(a: [f64; 4], b: [f64; 4], share: f64) -> Vec<String> {
        let (a, b) = (file(a), file(b));
        let open = |bytes: &'static [u8]| XrfReader::open("x.res", bytes).expect("a results file");
        let (a, b): (&'static [u8], &'static [u8]) = (a.leak(), b.leak());
        let mut floor = DifferenceFloor::new(share);
        for bytes in [a, b] {
            floor.look(&mut open(bytes)).expect("values");
        }
        let exact = Tolerance {
            absolute: 0.0,
            relative: 0.0,
        };
        let found = compare_above(&mut open(a), &mut open(b), exact, &floor).expect("a comparison");
        let beyond = found.columns.into_iter().filter(|column| column.beyond > 0);
        beyond
            .map(|column| {
                column
                    .path
                    .rsplit('.')
                    .next()
                    .unwrap_or_default()
                    .to_string()
            })
            .collect()
    }

    #[test]
    fn round_off_is_no_difference_and_a_small_force_is_one() {
        let usual = DifferenceFloor::DEFAULT_SHARE;
        let none = Vec::<String>::new();
        let a = [4500.0, 700.0, 0.0, 1.0];
        // One torque is zero. The other torque is round-off of the largest force times the largest length.
        assert_eq!(differing(a, [4500.0, 700.0, 7e-29, 1.0], usual), none);
        assert_eq!(differing(a, [4500.0, 700.0, 1e-7, 1.0], usual), none);
        assert_eq!(differing(a, [4500.0, 700.0, 1e-5, 1.0], usual), ["TX"]);
        assert_eq!(differing(a, [4500.0 + 1e-10, 700.0, 0.0, 1.0], usual), none);
        assert_eq!(
            differing(a, [4500.0 + 1e-7, 700.0, 0.0, 1.0], usual),
            ["FX"]
        );
        // A mechanism without any force has a floor as well.
        assert_eq!(differing([0.0; 4], [0.0, 0.0, 7e-29, 0.0], usual), none);
        // The magnitudes of other columns do not affect numbers without a unit.
        assert_eq!(
            differing(a, [4500.0, 700.0, 0.0, 1.0 + 1e-10], usual),
            ["Q"]
        );
        assert_eq!(differing(a, [4500.0, 700.0, 7e-29, 1.0], 0.0), ["TX"]);
    }
}
