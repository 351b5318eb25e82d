//! Decks in which a BUSHING is replaced by the FIELD that Adams/Car writes for it.

#![allow(dead_code)] // Each test binary uses its own part.

/// Words of the axes in the names of curves and arrays.
const WORDS: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];
/// Number of lines of a BUSHING in the shipped decks.
const BUSHING_LINES: usize = 7;
/// Id of the FIELD. Its SPLINEs and ARRAYs have the ids 901 to 906.
pub const FIELD: u32 = 9;

/// Returns a deck with a FIELD of Adams/Car in place of a BUSHING, with the same stiffnesses. `name` is the name of the bushing. `radial` returns
/// the force along x and y at a deflection; `None` keeps the stiffnesses.
pub fn with_field(
    deck: &str,
    bushing: u32,
    name: &str,
    radial: Option<&dyn Fn(f64) -> f64>,
) -> String {
    let at = deck
        .find(&format!("BUSHING/{bushing}\n"))
        .expect("the bushing");
    let lines = deck[at..].split_inclusive('\n');
    let old: String = lines.take(BUSHING_LINES).collect();
    let rest = &deck[at + old.len()..];
    assert!(!rest.trim_start().starts_with(','), "{}", &rest[..80]);
    let numbers = |word: &str| -> Vec<f64> {
        let line = old
            .lines()
            .find_map(|line| line.strip_prefix(&format!(", {word} = ")));
        let items = line.expect("the argument").split(',');
        items
            .map(|item| item.trim().parse().expect("a number"))
            .collect()
    };
    let stiffness = [numbers("K"), numbers("KT")].concat();
    let (i, j) = (numbers("I")[0], numbers("J")[0]);
    let mut text = String::new();
    for (axis, word) in WORDS.into_iter().enumerate() {
        let unit = if axis < 3 { 0.5 } else { 0.05 };
        let x: Vec<f64> = (-16..=16).map(|k| f64::from(k) * unit).collect();
        let force = |x: &f64| match radial {
            Some(law) if axis < 2 => law(*x),
            _ => stiffness[axis] * x,
        };
        let id = 901 + axis;
        text += &format!(
            "! adams_view_name='{name}.{word}_spline'\nSPLINE/{id}, LINEAR_EXTRAPOLATE, X = {}\n, Y = {}\n\
             ! adams_view_name='{name}.{word}_data_array'\nARRAY/{id}, NUMBERS = 2, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1\n",
            list(&x),
            list(&x.iter().map(force).collect::<Vec<f64>>()),
        );
    }
    text += &format!(
        "! adams_view_name='{name}.field'\n\
         FIELD/{FIELD}, I = {i}, J = {j}, FUNCTION = USER(902, 901, 902, 903, 904, 905, 906)\\\n, ROUTINE = abgVDM::fie900\n"
    );
    format!("{}{text}{rest}", &deck[..at])
}

fn list(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    words.join(", ")
}
