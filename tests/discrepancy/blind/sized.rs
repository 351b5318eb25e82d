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
