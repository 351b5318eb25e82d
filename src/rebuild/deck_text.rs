//! Numbers, names and functions in the text form of a deck.

/// Formats a number for a deck, with all digits and with a point or an exponent.
pub(crate) fn number(value: f64) -> String {
    let plain = format!("{value:?}");
    plain.replace('e', "E")
}

/// Formats the numbers of a list, separated by commas, in lines of at most 80 columns.
pub(crate) fn list(values: impl Iterator<Item = f64>) -> String {
    let mut text = String::new();
    let mut width = 0;
    for (k, value) in values.enumerate() {
        let word = number(value);
        if k > 0 {
            text.push_str(if width + word.len() > 60 {
                "\n, "
            } else {
                ", "
            });
            if width + word.len() > 60 {
                width = 0;
            }
        }
        width += word.len() + 2;
        text += &word;
    }
    text
}

/// Returns the line that names an object in Adams/View.
pub(crate) fn named(name: &str) -> String {
    format!(
        "!                 adams_view_name='{}'\n",
        name.replace('\'', "")
    )
}

/// Breaks a function expression into lines of at most 80 columns. The comma that continues a line is not part of the expression.
pub(crate) fn broken(expression: &str) -> String {
    let mut text = String::new();
    let mut width = 14;
    for piece in expression.split_inclusive(['*', '+', ',', '/']) {
        if width + piece.len() > 72 && !text.ends_with("**") && !piece.starts_with('*') {
            text += "\n, ";
            width = 2;
        }
        width += piece.len();
        text += piece;
    }
    text
}

/// Returns an identifier for a column: letters, digits and underscores.
pub(crate) fn identifier(name: &str) -> String {
    let word = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        }
    };
    name.chars().map(word).collect()
}

/// Formats a factor so that it can follow a sign.
pub(crate) fn signed(value: f64) -> String {
    if value < 0.0 {
        format!("({})", number(value))
    } else {
        number(value)
    }
}

/// Extends a curve given for positive arguments to an odd curve: adds the origin and the mirrored points `(-r, -x)`.
pub(crate) fn both_sides(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mirrored = points.iter().rev().map(|(r, x)| (-r, -x));
    let mut all: Vec<(f64, f64)> = mirrored.collect();
    all.push((0.0, 0.0));
    all.extend(points.iter().copied());
    all.dedup_by(|a, b| a.0 <= b.0);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_all_digits() {
        for value in [1.0, -0.1, 1.0 / 3.0, 1e-300, 6.022e23] {
            assert_eq!(number(value).replace('E', "e").parse::<f64>(), Ok(value));
            assert!(number(value).contains(['.', 'E']));
        }
    }

    #[test]
    fn an_odd_curve_runs_through_the_origin() {
        let all = both_sides(&[(1.0, 10.0), (2.0, 30.0)]);
        assert_eq!(
            all,
            [
                (-2.0, -30.0),
                (-1.0, -10.0),
                (0.0, 0.0),
                (1.0, 10.0),
                (2.0, 30.0)
            ]
        );
    }
}
