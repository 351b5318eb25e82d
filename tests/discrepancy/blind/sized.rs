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
    /// Nor falls below this.
    pub(super) least: f64,
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

    /// How many usual tolerances the planted effect is, where such small errors belong to every axle: hardpoints 0.2 mm, bushings
    /// displaced by 0.05 mm and turned by 0.1 degrees, points of loads 0.5 mm, loads 0.3 and their directions 0.1 percent, spring
    /// rates 1.5, preloads 0.3 and rubber 3 percent. `None` for what nobody tolerates.
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

    /// The size it has at least.
    pub const fn least(&self) -> f64 {
        self.form.least
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
