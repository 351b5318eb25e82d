//! Planted effects whose size is still to be determined.

/// An effect to be planted, with its size still open.
#[derive(Clone, PartialEq, Debug)]
pub struct Plant {
    /// Cause, as spelled in `diagnosis.json`.
    pub cause: &'static str,
    /// Address, as spelled in `diagnosis.json`.
    pub address: String,
    /// True if the law of the effect differs from every hypothesis.
    pub foreign: bool,
    /// Specification of the effect as a function of its size.
    pub(super) form: Form,
    /// Desired rms shift of the readings, in units of the noise.
    pub wanted: f64,
}

#[derive(Clone, PartialEq, Debug)]
pub(super) struct Form {
    /// Pieces of the specification: fixed text, and numbers that depend on the size.
    pub(super) pieces: Vec<Piece>,
    /// Largest size.
    pub(super) most: f64,
    /// Smallest size.
    pub(super) least: f64,
}

#[derive(Clone, PartialEq, Debug)]
pub(super) enum Piece {
    Text(String),
    /// The number `base * size`.
    Grows(f64),
    /// The number `base / size`.
    Shrinks(f64),
    /// The number `1 + base * size`.
    Factor(f64),
}

impl Plant {
    /// Returns the specification of the effect for `admire rig` at a given size.
    pub fn spec(&self, size: f64) -> String {
        let mut text = format!("{}@{}:", self.cause, self.address);
        for piece in &self.form.pieces {
            match piece {
                Piece::Text(piece) => text += piece,
                Piece::Grows(base) => text += &format!("{:.9e}", base * size),
                Piece::Shrinks(base) => text += &format!("{:.9e}", base / size),
                Piece::Factor(base) => text += &format!("{:.12}", 1.0 + base * size),
            }
        }
        text
    }

    /// Returns the size of the planted effect in units of the usual tolerance; `None` for effects without a tolerance.
    ///
    /// Tolerances: hardpoints 0.2 mm, bushings displaced by 0.05 mm and rotated by 0.1 degrees, load points 0.5 mm, loads 0.3 percent, load
    /// directions 0.1 percent, spring rates 1.5 percent, preloads 0.3 percent, rubber 3 percent.
    pub fn tolerances(&self, spec: &str) -> Option<f64> {
        let numbers: Vec<f64> = spec
            .rsplit(':')
            .next()?
            .split(',')
            .filter_map(|pair| pair.split('=').nth(1)?.parse().ok())
            .collect();
        let most = numbers.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let off = (numbers.first()? - 1.0).abs();
        let one = match self.cause {
            "hardpoint-error" => most / 0.2,
            "assembly-offset" => most / 0.05,
            "bushing-orientation" => most / 0.1,
            "load-point-error" => most / 0.5,
            "load-gain" => off / 0.003,
            "load-crosstalk" => most / 0.001,
            "element-parameter" if self.address.contains(".FORCE") => off / 0.003,
            "element-parameter" if self.address.starts_with("SPRING") => off / 0.015,
            "element-parameter" => off / 0.03,
            _ => return None,
        };
        Some(one)
    }

    /// Returns the smallest size.
    pub const fn least(&self) -> f64 {
        self.form.least
    }

    /// Returns the largest size.
    pub const fn most(&self) -> f64 {
        self.form.most
    }
}

/// Returns a piece of fixed text.
pub(super) fn text(piece: impl Into<String>) -> Piece {
    Piece::Text(piece.into())
}

/// Returns the pieces `x=,y=,z=` of a shift along a direction.
pub(super) fn shift(v: [f64; 3], scale: f64) -> Vec<Piece> {
    let names = ["x=", ",y=", ",z="];
    names
        .iter()
        .zip(v)
        .flat_map(|(name, x)| [text(*name), Piece::Grows(x * scale)])
        .collect()
}
