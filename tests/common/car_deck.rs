//! A part held by a bushing as Adams/Car writes it: a FIELD whose subroutine names six curves and six arrays.

#![allow(dead_code)] // Each test binary uses its own part.

/// Values of the arrays for each axis: scale, preload, offset and scale of the displacement.
pub type Axes = [[f64; 4]; 6];

pub const PLAIN: Axes = [[1.0, 0.0, 0.0, 1.0]; 6];

const WORDS: [&str; 6] = ["tx", "ty", "tz", "rx", "ry", "rz"];

/// Knots of the curves of translations and torsions.
pub fn knots(axis: usize) -> Vec<f64> {
    let unit = if axis < 3 { 2.0 } else { 0.1 };
    (-3..=3).map(|k| f64::from(k) * unit).collect()
}

/// Returns the value of an odd curve through the knots, which is exact at the knots.
pub fn curve(axis: usize, x: f64) -> f64 {
    let cubic = |k: f64, bend: f64| k * x + bend * x * x * x;
    match axis {
        0 => cubic(300.0, 20.0),
        1 => cubic(500.0, 5.0),
        2 => cubic(80.0, 7.0),
        3 => cubic(9e4, 1e6),
        4 => cubic(7e4, 2e5),
        _ => cubic(2e4, 3e6),
    }
}

fn list(values: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = values.into_iter().map(|v| format!("{v:?}")).collect();
    words.join(", ")
}

/// Returns the statements SPLINE/31 to 36, with their names.
pub fn splines() -> String {
    let mut text = String::new();
    for (axis, word) in WORDS.iter().enumerate() {
        let x = knots(axis);
        text += &format!(
            "! adams_view_name='axle.bkl_arm_outer.{word}_spline'\nSPLINE/{}, LINEAR_EXTRAPOLATE, X = {}\n, Y = {}\n",
            31 + axis,
            list(x.clone()),
            list(x.into_iter().map(|x| curve(axis, x))),
        );
    }
    text
}

/// Returns the statements ARRAY/31 to 36, with their names.
pub fn arrays(axes: &Axes) -> String {
    let mut text = String::new();
    for (axis, word) in WORDS.iter().enumerate() {
        let [scale, preload, offset, stretch] = axes[axis];
        let numbers = [
            2.0, 0.0, scale, 1.0, 0.5, 1.0, preload, offset, stretch, 0.0, 1.0,
        ];
        text += &format!(
            "! adams_view_name='axle.bkl_arm_outer.{word}_data_array'\nARRAY/{}, NUMBERS = {}\n",
            31 + axis,
            list(numbers),
        );
    }
    text
}

/// Returns the FIELD between MARKER/20 of a part and MARKER/1, with these parameters.
pub fn field(parameters: &str) -> String {
    format!(
        "! adams_view_name='axle.bkl_arm_outer.field'\nFIELD/1, I = 20, J = 1, FUNCTION = USER({parameters})\\\n, ROUTINE = abgVDM::fie900\n"
    )
}

pub const PARAMETERS: &str = "902, 31, 32, 33, 34, 35, 36";

/// Returns the same law as a GFORCE with AKISPL.
pub fn gforce(axes: &Axes) -> String {
    let q = |axis: usize| {
        let letter = ["X", "Y", "Z"][axis % 3];
        let [_, _, offset, stretch] = axes[axis];
        let measure = match axis {
            0..3 => format!("D{letter}(20,1,1)"),
            _ => format!("A{letter}(20,1)"),
        };
        format!("({stretch:?}*{measure}-({offset:?}))")
    };
    let r = format!("SQRT({}**2+{}**2+1E-18)", q(0), q(1));
    let names = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
    let components: Vec<String> = (0..6)
        .map(|axis| {
            let [scale, preload, ..] = axes[axis];
            let spline = 31 + axis;
            let law = match axis {
                0..2 => format!("AKISPL({r},0,{spline})*{}/{r}", q(axis)),
                _ => format!("AKISPL({},0,{spline})", q(axis)),
            };
            format!(", {} = {preload:?}-{scale:?}*{law}", names[axis])
        })
        .collect();
    format!(
        "MARKER/9, PART=1, FLOATING\nGFORCE/1, I=20, JFLOAT=9, RM=1\n{}\n",
        components.join("\\\n")
    )
}

/// Returns a part at MARKER/20, with a force and a torque on it along the axes of ground.
pub fn part(load: [f64; 6]) -> String {
    let [fx, fy, fz, tx, ty, tz] = load;
    format!(
        "PART/2, MASS=1, CM=20, IP=100,100,100\nMARKER/20, PART=2\nMARKER/8, PART=1, FLOATING\n\
         GFORCE/2, I=20, JFLOAT=8, RM=1, FX={fx:?}\\, FY={fy:?}\\, FZ={fz:?}\\, TX={tx:?}\\, TY={ty:?}\\, TZ={tz:?}\n"
    )
}
