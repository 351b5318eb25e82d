//! A large deck for benchmarks.

use std::fmt::Write;

/// Returns a deck of parts with markers, bushings and forces, in the layout of ADAMS/View.
pub fn deck(size: usize) -> Vec<u8> {
    let mut out = String::with_capacity(size + 4096);
    out += "large deck\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n";
    let mut id = 2u32;
    while out.len() < size {
        let x = (f64::from(id) * 0.37).sin() * 1000.0;
        let y = (f64::from(id) * 0.73).cos() * 500.0;
        let (cm, end) = (id * 10, id * 10 + 1);
        write!(
            out,
            "!\n!                             adams_view_name='part_{id}'\nPART/{id}\n, MASS = {:.6}\n, CM = {cm}\n\
             , IP = {:.4E}, {:.4E}, {:.4E}\n, QG = {x:.9}, {y:.9}, {:.9}\n, REULER = 90D, {:.3}D, 0D\n\
             !\n!                             adams_view_name='cm_{id}'\nMARKER/{cm}\n, PART = {id}\n, QP = {y:.9}, 0, {x:.9}\n\
             MARKER/{end}\n, PART = {id}\n, QP = {x:.9}, {y:.9}, -12.5\n, REULER = 0D, {:.3}D, -90D\n\
             !                             adams_view_name='bush_{id}'\nBUSHING/{id}\n, I = {end}\n, J = 1\n\
             , K = 1.0E+04, 1.2E+04, {:.3}\n, KT = 5.0E+05, 5.0E+05, 3.0E+05\n, C = 10, 10, 10\n, CT = 100, 100, 100\n\
             SFORCE/{id}\n, TRANSLATIONAL\n, I = {cm}\n, J = 1\n, FUNCTION = {:.5}*STEP(TIME, 0, 0, 1, 1) - 0.5*DM({cm}, 1)\n",
            1.0 + y.abs() / 100.0,
            2e4 + x,
            2e4 + y,
            3e4,
            x - y,
            y / 10.0,
            // Rotated back to the axes of the ground, because a rotated bushing gives a warning and this deck has no faults.
            -y / 10.0,
            1000.0 + y.abs(),
            x.abs(),
        )
        .expect("room");
        id += 1;
    }
    out += "ACCGRAV/\n, KGRAV = -9806.65\nEND\n";
    out.into_bytes()
}
