//! Roll centre and roll steer, compared with finite differences of the statics: vertical loads at the contact patches move the patches and steer
//! the wheels.

use admire_kc::{Inputs, Observation, Side, Variant, given, wheel};
use admire_solver::mechanics::Vec3;

use crate::axles::{Axle, DOUBLE_WISHBONE, MCPHERSON, corpus, double_wishbone};

const LOADED: Variant = Variant {
    height_held: false,
    steering_locked: true,
};

/// Returns the axles. On a rigid tyre, the lever arm of a load is constant, so the moment of the load is that of the compliance at the patch.
fn axles() -> [(&'static str, Axle); 2] {
    let rigid = |toml: &str, stiffness: &str| {
        assert!(toml.contains(stiffness));
        toml.replace(stiffness, "")
    };
    [
        (
            "mcpherson",
            Axle::new(
                &corpus("pseudo-mcpherson/model.adm"),
                &rigid(MCPHERSON, "stiffness = 220.0\n"),
            ),
        ),
        (
            "wishbone",
            Axle::new(
                &double_wishbone(),
                &rigid(DOUBLE_WISHBONE, "stiffness = 200.0\n"),
            ),
        ),
    ]
}

/// Returns the lever arm from the wheel centre to the patch, by the law of the contact point.
fn lever(seen: &Observation, side: Side) -> Vec3 {
    let centre = seen.axle.wheels[side.index()].unwrap().wheel.centre;
    seen.axle.contacts().unwrap()[side.index()] - centre
}

#[test]
fn roll_centre_and_roll_steer_are_differences_of_the_statics() {
    for (name, axle) in axles() {
        let mut bench = axle.bench();
        // Unequal loads in the road plane: the wheels tilt and steer, and one patch is higher.
        let base = Inputs {
            loads: [[600.0, 900.0, 5000.0, 0.0], [200.0, 1500.0, 3500.0, 0.0]],
            vertical_at_patch: true,
            plane_at_patch: true,
            ..Inputs::default()
        };
        let mut chain = bench.chain(LOADED).unwrap();
        let middle = bench
            .observe(LOADED, &mut chain, &base, None, name)
            .unwrap();
        let mut at = |on: [f64; 2], h: f64| {
            let mut inputs = base;
            for k in 0..2 {
                inputs.loads[k][2] += on[k] * h;
            }
            bench
                .observe(LOADED, &mut chain.clone(), &inputs, None, name)
                .unwrap()
        };
        let mut slope = |on: [f64; 2], of: &dyn Fn(&Observation) -> f64| {
            let mut one = |h: f64| (of(&at(on, h)) - of(&at(on, -h))) / (2.0 * h);
            (4.0 * one(20.0) - one(40.0)) / 3.0
        };
        // Returns the point of the carrier that coincides with the patch.
        let point = |side: Side| {
            let then = middle.axle.wheels[side.index()].unwrap().wheel;
            let local = then.turn.transpose() * lever(&middle, side);
            move |seen: &Observation| {
                let now = seen.axle.wheels[side.index()].unwrap().wheel;
                now.centre + now.turn * local
            }
        };
        let readings = middle
            .axle
            .readings(&given(&axle.config, &axle.model.units));
        let read = |path: &str| readings.iter().find(|r| r.path() == path).unwrap().value;
        let contacts = middle.axle.contacts().unwrap();
        assert!((contacts[0].z - contacts[1].z).abs() > 1.0);
        let [sl, sr] = Side::BOTH.map(|side| {
            let mut on = [0.0; 2];
            on[side.index()] = 1.0;
            let point = point(side);
            let [dy, dz] = [1, 2].map(|k| slope(on, &|seen| point(seen)[k]));
            side.outboard_sign() * dy / dz
        });
        let y = (sl * contacts[0].y + sr * contacts[1].y) / (sl + sr);
        let found = read("roll_center_location.lateral_from_half_track");
        assert!((found - y).abs() < 1e-4, "{name}: {found} {y}");
        let height = sl * (y - contacts[0].y);
        let found = read("roll_center_location.vertical");
        assert!((found - height).abs() < 1e-5, "{name}: {found} {height}");
        // Left up and right down: heights of the contact points themselves.
        let opposed = [1.0, -1.0];
        let across = slope(opposed, &|seen| {
            let [l, r] = seen.axle.contacts().unwrap();
            l.z - r.z
        });
        let track = contacts[1].y - contacts[0].y;
        for side in Side::BOTH {
            let steer = slope(opposed, &|seen| {
                let spin = seen.axle.wheels[side.index()].unwrap().wheel.spin;
                wheel::steer(&spin, &Vec3::z())
            });
            let expected = -steer * track / across;
            let found = read(&format!("roll_steer.{}", side.word()));
            println!("{name} {side:?}: {found} {expected}");
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
    }
}

/// Checks the anti effects. Both columns of a pair hold the value of the axle in the deck, and `vehicle.axle` states which axle this is. A front
/// brake share f acts on the front axle, 1 - f on the rear one, where the load transfer has the opposite sign.
#[test]
fn anti_effects_are_those_of_the_axle_at_hand() {
    let read = |toml: &str| {
        let axle = Axle::new(&double_wishbone(), toml);
        let mut bench = axle.bench();
        let inputs = Inputs {
            loads: [[0.0, 0.0, 4000.0, 0.0]; 2],
            vertical_at_patch: true,
            ..Inputs::default()
        };
        let mut chain = bench.chain(LOADED).unwrap();
        let seen = bench
            .observe(LOADED, &mut chain, &inputs, None, "axle")
            .unwrap();
        let readings = seen.axle.readings(&given(&axle.config, &axle.model.units));
        [
            "anti_dive_braking.left",
            "anti_lift_braking.left",
            "dive_braking.left",
            "lift_braking.left",
            "anti_lift_acceleration.left",
            "anti_squat_acceleration.left",
            "lift_acceleration.left",
            "squat_acceleration.left",
        ]
        .map(|path| readings.iter().find(|r| r.path() == path).unwrap().value)
    };
    let driven = DOUBLE_WISHBONE.replace("front_drive = 0.0", "front_drive = 0.25");
    // Because of the steering, it is the front axle.
    let front = read(&driven);
    let said = |place: &str| driven.replace("[vehicle]", &format!("[vehicle]\naxle = '{place}'"));
    assert_eq!(read(&said("front")), front);
    let rear = read(&said("rear"));
    for pair in [0, 2, 4, 6] {
        assert_eq!(front[pair], front[pair + 1]);
        assert_eq!(rear[pair], rear[pair + 1]);
    }
    let (braking, driving) = (-front[0] * 0.3 / 0.7, -front[4] * 0.75 / 0.25);
    assert!((rear[0] - braking).abs() < 1e-9 * braking.abs());
    assert!((rear[4] - driving).abs() < 1e-9 * driving.abs());
}
