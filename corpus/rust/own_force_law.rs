//! A user-defined force law, checked against its closed form: `cargo run --example own_force_law`.
//!
//! A deck accepts any force law as an expression. The law here is a rubber buffer whose force grows as tan(x). It becomes stiff near its
//! end in a way that no polynomial does.

use admire::{Deck, Error};

/// Force in newtons of a buffer that is compressed by `x` millimetres. The buffer becomes solid at `free` millimetres.
fn law(x: f64, free: f64) -> f64 {
    800.0 * (std::f64::consts::FRAC_PI_2 * x / free).tan()
}

fn main() -> Result<(), Error> {
    let free = 30.0;
    let text = format!(
        "A mass on a rubber buffer
UNITS/FORCE=NEWTON,MASS=KILOGRAM,LENGTH=MILLIMETER,TIME=SECOND
PART/1,GROUND
MARKER/1,PART=1
PART/2,MASS=100,CM=20,IP=1,1,1
MARKER/20,PART=2
JOINT/1,TRANSLATIONAL,I=20,J=1
SFORCE/1,TRANSLATIONAL,ACTIONONLY,I=20,J=1,FUNCTION=-800*TAN({}*DZ(20,1,1)/{free})
ACCGRAV/KGRAV=9806.65
RESULTS/XRF
END
",
        std::f64::consts::FRAC_PI_2
    );
    let run = Deck::parse("buffer.adm", text).solve()?;
    let place = run.column("PART_2_XFORM.Z")?;
    let pressed = place[place.len() - 1];
    let weight = 100.0 * 9.80665;
    println!(
        "pressed by {pressed:.6} mm: the law gives {:.6} N for a weight of {weight:.6} N",
        law(pressed, free)
    );
    assert!((law(pressed, free) - weight).abs() < 1e-6 * weight);
    Ok(())
}
