/// Symmetry of an entry in a subsystem or assembly file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Symmetry {
    /// `left/right`: one entry for both sides. The left side is as written; the right side is its mirror image in the plane y = 0.
    Pair,
    /// `left`: an entry that exists only on the left side.
    Left,
    /// `right`: an entry that exists only on the right side.
    Right,
    /// `single`: an entry without a side.
    Single,
}

/// Side of the vehicle for an instance of an entry.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Side {
    /// Left side, letter `l`.
    Left,
    /// Right side, letter `r`.
    Right,
    /// No side, letter `s`.
    Single,
}

impl Symmetry {
    /// Returns the symmetry for a word of a file; `None` for other words. Case and surrounding blanks are ignored.
    pub fn parse(word: &str) -> Option<Self> {
        match word.trim().to_ascii_lowercase().as_str() {
            "left/right" => Some(Self::Pair),
            "left" => Some(Self::Left),
            "right" => Some(Self::Right),
            "single" => Some(Self::Single),
            _ => None,
        }
    }

    /// Returns the sides on which the entry has an instance.
    pub const fn sides(self) -> &'static [Side] {
        match self {
            Self::Pair => &[Side::Left, Side::Right],
            Self::Left => &[Side::Left],
            Self::Right => &[Side::Right],
            Self::Single => &[Side::Single],
        }
    }
}

impl Side {
    /// Returns the letter of the side in names of Adams/Car: `hpl_`, `hpr_`, `hps_`.
    pub const fn letter(self) -> char {
        match self {
            Self::Left => 'l',
            Self::Right => 'r',
            Self::Single => 's',
        }
    }

    /// Returns the side with this letter in names of Adams/Car.
    pub const fn of_letter(letter: char) -> Option<Self> {
        match letter {
            'l' => Some(Self::Left),
            'r' => Some(Self::Right),
            's' => Some(Self::Single),
            _ => None,
        }
    }
}
