//! An effect whose size is still open.

/// Something to plant; its size is still open.
#[derive(Clone, PartialEq, Debug)]
pub struct Plant {
    /// Cause and address as `diagnosis.json` names them.
    pub cause: &'static str,
    /// See `cause`.
    pub address: String,
    /// True if no hypothesis uses its law.
    pub foreign: bool,
    /// The effect as a text for a size of one; `{}` stand for numbers proportional to the size.
    pub(super) form: Form,
    /// Rms shift wanted, in units of the noise.
    pub wanted: f64,
}

#[derive(Clone, PartialEq, Debug)]
pub(super) struct Form {
    /// Pieces of the specification: fixed text, and numbers that follow the size.
    pub(super) pieces: Vec<Piece>,
    /// The size never exceeds this.
    pub(super) most: f64,
}

#[derive(Clone, PartialEq, Debug)]
pub(super) enum Piece {
    Text(String),
    /// `base * size`
    Grows(f64),
    /// `base / size`
    Shrinks(f64),
    /// `1 + base * size`
    Factor(f64),
}

impl Plant {
    /// The effect for `admire rig`, at a size.
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

    /// The size that is never exceeded.
    pub const fn most(&self) -> f64 {
        self.form.most
    }
}

/// Fixed text.
pub(super) fn text(piece: impl Into<String>) -> Piece {
    Piece::Text(piece.into())
}

/// `x=,y=,z=` along a direction.
pub(super) fn shift(v: [f64; 3], scale: f64) -> Vec<Piece> {
    let names = ["x=", ",y=", ",z="];
    names
        .iter()
        .zip(v)
        .flat_map(|(name, x)| [text(*name), Piece::Grows(x * scale)])
        .collect()
}
