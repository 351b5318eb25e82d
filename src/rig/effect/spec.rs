use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use admire_solver::mechanics::{Mat3, Vec3, exp};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// An effect to plant, in the form `cause@address:name=value,...`.
#[derive(Clone, PartialEq, Debug)]
pub struct EffectSpec {
    /// Text of the effect as the user typed it.
    pub text: String,
    /// Name of the cause: a cause of guide/study.md, or an effect outside that catalogue.
    pub cause: String,
    /// Place of the effect, such as `BUSHING/2.K.1`, `case 7`, `case 7 KNUCKLE 3`, `SFORCE/2<-SFORCE/3` or the name of a channel.
    pub address: String,
    values: BTreeMap<String, String>,
    asked: RefCell<BTreeSet<String>>,
}

impl EffectSpec {
    /// Parses the text of an `--effect` option.
    ///
    /// # Errors
    /// Returns a `bad-effect` diagnostic if the text does not have the form of [`EffectSpec`].
    pub fn parse(text: &str) -> Result<Self, Diagnostic> {
        let bad = |what: &str| {
            Diagnostic::error(Code::BadEffect, format!("`{text}`: {what}"))
                .help("for example dry-friction@BUSHING/2.K.1:force=200,stiffness=4000")
        };
        let Some((cause, rest)) = text.split_once('@') else {
            return Err(bad("an effect is written as cause@address:name=value,..."));
        };
        let (address, list) = rest.split_once(':').unwrap_or((rest, ""));
        let mut values = BTreeMap::new();
        for item in list.split(',').filter(|item| !item.trim().is_empty()) {
            let Some((name, value)) = item.split_once('=') else {
                return Err(bad(&format!("`{item}` is not name=value")));
            };
            let before = values.insert(name.trim().to_string(), value.trim().to_string());
            if before.is_some() {
                return Err(bad(&format!("`{}` is given twice", name.trim())));
            }
        }
        Ok(Self {
            text: text.to_string(),
            cause: cause.trim().to_string(),
            address: address.trim().to_string(),
            values,
            asked: RefCell::default(),
        })
    }

    /// Parses a list of effects, one per line. `#` starts a comment.
    ///
    /// # Errors
    /// Returns the error of [`EffectSpec::parse`] for the first wrong line.
    pub fn parse_list(text: &str) -> Result<Vec<Self>, Diagnostic> {
        text.lines()
            .map(|line| line.split('#').next().unwrap_or("").trim())
            .filter(|line| !line.is_empty())
            .map(Self::parse)
            .collect()
    }

    /// Returns a `bad-effect` diagnostic about this effect.
    pub(super) fn refuse(&self, what: impl Into<String>) -> Diagnostic {
        Diagnostic::error(Code::BadEffect, format!("`{}`: {}", self.text, what.into()))
    }

    fn get(&self, name: &str) -> Option<&str> {
        self.asked.borrow_mut().insert(name.to_string());
        self.values.get(name).map(String::as_str)
    }

    /// Returns the value with this name as a finite number; `None` if it is not given.
    pub(super) fn optional(&self, name: &str) -> Result<Option<f64>, Diagnostic> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        match text.parse::<f64>().ok().filter(|number| number.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.refuse(format!("`{name}={text}` is not a number"))),
        }
    }

    /// Returns the value with this name as a finite number. A missing value is an error.
    pub(super) fn number(&self, name: &str) -> Result<f64, Diagnostic> {
        self.optional(name)?
            .ok_or_else(|| self.refuse(format!("needs {name}=...")))
    }

    /// Returns the value with this name as a positive number. A missing value is an error.
    pub(super) fn positive(&self, name: &str) -> Result<f64, Diagnostic> {
        let number = self.number(name)?;
        if number > 0.0 {
            Ok(number)
        } else {
            Err(self.refuse(format!("{name} must be above zero")))
        }
    }

    /// Returns the value with this name as text; `None` if it is not given.
    pub(super) fn label(&self, name: &str) -> Option<String> {
        self.get(name).map(str::to_string)
    }

    /// Returns the value with this name, which must be one of `words`. If it is not given, the first of `words` is returned.
    pub(super) fn word(
        &self,
        name: &str,
        words: &[&'static str],
    ) -> Result<&'static str, Diagnostic> {
        let Some(text) = self.get(name) else {
            return Ok(words[0]);
        };
        words
            .iter()
            .copied()
            .find(|word| *word == text)
            .ok_or_else(|| self.refuse(format!("{name} must be one of {}", words.join(", "))))
    }

    /// Returns the vector of the values `x`, `y` and `z`. Missing components are zero; an error is returned if all are zero.
    pub(super) fn shift(&self) -> Result<Vec3, Diagnostic> {
        let shift = self.vector(["x", "y", "z"])?;
        if shift == Vec3::zeros() {
            return Err(self.refuse("needs at least one of x, y, z"));
        }
        Ok(shift)
    }

    /// Returns the shift `x, y, z`, and the rotation matrix of the rotation vector `ax_deg, ay_deg, az_deg`. Missing components are zero; an
    /// error is returned if all are zero.
    pub(super) fn motion(&self) -> Result<(Vec3, Mat3), Diagnostic> {
        let shift = self.vector(["x", "y", "z"])?;
        let turn = self.turn_vector()?;
        if shift == Vec3::zeros() && turn == Vec3::zeros() {
            return Err(self.refuse("needs at least one of x, y, z, ax_deg, ay_deg, az_deg"));
        }
        Ok((shift, exp(&turn)))
    }

    /// Returns the rotation matrix of the rotation vector `ax_deg, ay_deg, az_deg`. An error is returned if the vector is zero.
    pub(super) fn turn(&self) -> Result<Mat3, Diagnostic> {
        let turn = self.turn_vector()?;
        if turn == Vec3::zeros() {
            return Err(self.refuse("needs at least one of ax_deg, ay_deg, az_deg"));
        }
        Ok(exp(&turn))
    }

    fn turn_vector(&self) -> Result<Vec3, Diagnostic> {
        Ok(self
            .vector(["ax_deg", "ay_deg", "az_deg"])?
            .map(f64::to_radians))
    }

    fn vector(&self, names: [&str; 3]) -> Result<Vec3, Diagnostic> {
        let mut vector = Vec3::zeros();
        for (k, name) in names.into_iter().enumerate() {
            vector[k] = self.optional(name)?.unwrap_or(0.0);
        }
        Ok(vector)
    }

    /// Returns an error if the effect has a value that was never queried.
    pub(super) fn all_used(&self) -> Result<(), Diagnostic> {
        let asked = self.asked.borrow();
        match self.values.keys().find(|name| !asked.contains(*name)) {
            Some(name) => {
                let known: Vec<&str> = asked.iter().map(String::as_str).collect();
                Err(self
                    .refuse(format!("has no parameter `{name}`"))
                    .help(format!("its parameters are {}", known.join(", "))))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_study_format() {
        let spec =
            EffectSpec::parse("dry-friction@BUSHING/2.K.1:force=200,stiffness=4000").unwrap();
        assert_eq!(
            (spec.cause.as_str(), spec.address.as_str()),
            ("dry-friction", "BUSHING/2.K.1")
        );
        assert_eq!(spec.positive("force").unwrap(), 200.0);
        assert!(spec.all_used().unwrap_err().message.contains("stiffness"));
        assert_eq!(spec.positive("stiffness").unwrap(), 4000.0);
        assert!(spec.all_used().is_ok());
        assert!(spec.number("clearance").is_err());
    }

    #[test]
    fn a_list_has_comments_and_empty_lines() {
        let list = "# what is wrong\n\nload-gain@SFORCE/3:gain=1.01 # a percent\nframe-drift@case 7:x=0.1\n";
        let found = EffectSpec::parse_list(list).unwrap();
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].address, "case 7");
        assert!(EffectSpec::parse_list("rust\n").is_err());
    }

    #[test]
    fn malformed_effects_are_refused() {
        for text in ["friction", "a@b:c", "a@b:c=1,c=2"] {
            assert_eq!(EffectSpec::parse(text).unwrap_err().code, Code::BadEffect);
        }
        let spec = EffectSpec::parse("a@b:x=one,y=NaN").unwrap();
        assert!(spec.number("x").is_err() && spec.number("y").is_err());
    }
}
