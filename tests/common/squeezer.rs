//! Andrews' squeezer mechanism and its state after 0.03 s.

use std::fmt::Write as _;

/// Returns the deck of Andrews' squeezer mechanism, with data and initial state as printed in Hairer, Wanner, Solving Ordinary Differential
/// Equations II, VII.7.
///
/// Angles are in the order beta, Theta, gamma, Phi, delta, Omega, epsilon.
pub fn squeezer() -> String {
    const START: [f64; 7] = [
        -0.061_713_890_014_276_45,
        0.0,
        0.455_279_819_163_070_4,
        0.222_668_390_165_885_88,
        0.487_364_979_543_842_55,
        -0.222_668_390_165_885_88,
        1.230_547_444_549_821_2,
    ];
    let [beta, theta, gamma, phi, delta, omega, epsilon] = START;
    let a = [-0.06934, -0.00227];
    let b = [-0.03635, 0.03273];
    let (rr, zt, u) = (7e-3, 4e-2, 4e-2);
    let point = |p: [f64; 2], angle: f64, local: [f64; 2]| {
        let (s, c) = angle.sin_cos();
        [
            p[0] + c * local[0] - s * local[1],
            p[1] + s * local[0] + c * local[1],
        ]
    };
    let one = point([0.0; 2], beta, [rr, 0.0]);
    let five = point(a, delta, [zt, 0.0]);
    let seven = point(a, epsilon, [0.0, -u]);
    // Origin, angle, mass, inertia about z, centre of mass.
    let bodies = [
        ([0.0; 2], beta, 0.04325, 2.194e-6, [92e-5, 0.0]),
        (one, beta + theta, 0.00365, 4.410e-7, [-115e-4, 0.0]),
        (b, gamma, 0.02373, 5.255e-6, [1043e-5, -1874e-5]),
        (
            five,
            phi + delta,
            0.00706,
            5.667e-7,
            [0.0, -(2e-2 - 1421e-5)],
        ),
        (a, delta, 0.07050, 1.169e-5, [2308e-5, 916e-5]),
        (
            seven,
            omega + epsilon,
            0.00706,
            5.667e-7,
            [2e-2 - 1421e-5, 0.0],
        ),
        (a, epsilon, 0.05498, 1.912e-5, [-449e-5, -1228e-5]),
    ];
    let mut deck = String::from(
        "squeezer\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n",
    );
    _ = writeln!(deck, "MARKER/2, PART=1, QP={:.17},{:.17},0", a[0], a[1]);
    _ = writeln!(deck, "MARKER/3, PART=1, QP={:.17},{:.17},0", b[0], b[1]);
    deck += "MARKER/4, PART=1, QP=0.014,0.072,0\n";
    for (k, (origin, angle, mass, inertia, cm)) in bodies.into_iter().enumerate() {
        let id = 10 * (k + 1);
        // The body is a lamina; its other moments of inertia have no effect in the plane.
        _ = writeln!(
            deck,
            "PART/{id}, MASS={mass:e}, CM={}, IP={h:e},{h:e},{inertia:e}, QG={:.17},{:.17},0, REULER={angle:.17},0,0",
            id + 1,
            origin[0],
            origin[1],
            h = 0.5 * inertia
        );
        _ = writeln!(
            deck,
            "MARKER/{}, PART={id}, QP={:e},{:e},0",
            id + 1,
            cm[0],
            cm[1]
        );
        _ = writeln!(deck, "MARKER/{}, PART={id}", id + 2);
    }
    let points = [
        (13, 10, [rr, 0.0]),
        (23, 20, [-28e-3, 0.0]),
        (33, 30, [0.0, -35e-3]),
        (34, 30, [2e-2, -18e-3]),
        (43, 40, [0.0, -2e-2]),
        (53, 50, [zt, 0.0]),
        (63, 60, [2e-2, 0.0]),
        (73, 70, [0.0, -u]),
    ];
    for (marker, part, p) in points {
        _ = writeln!(
            deck,
            "MARKER/{marker}, PART={part}, QP={:e},{:e},0",
            p[0], p[1]
        );
    }
    let joints = [
        (12, 1),
        (22, 13),
        (32, 3),
        (52, 2),
        (42, 53),
        (72, 2),
        (62, 73),
        (33, 23),
        (43, 23),
        (63, 23),
    ];
    for (k, (i, j)) in joints.into_iter().enumerate() {
        _ = writeln!(deck, "JOINT/{}, REVOLUTE, I={i}, J={j}", k + 1);
    }
    deck + "SPRINGDAMPER/1, TRANSLATIONAL, I=34, J=4, K=4530, LENGTH=0.07785
SFORCE/1, ROTATIONAL, ACTIONONLY, I=12, J=1, FUNCTION=0.033
INTEGRATOR/GSTIFF, ERROR=1E-6
RESULTS/FORMATTED, XRF
END
"
}

/// Returns the angles of the seven bodies at 0.03 s in radians, from the test set for initial value problems, which gives sixteen digits.
pub fn expected() -> [f64; 7] {
    const END: [f64; 7] = [
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        -0.5347301163226948,
        0.5244099658805304,
        0.5347301163226948,
        1.048080741042263,
    ];
    let [beta, theta, gamma, phi, delta, omega, epsilon] = END;
    [
        beta,
        beta + theta,
        gamma,
        phi + delta,
        delta,
        omega + epsilon,
        epsilon,
    ]
}
