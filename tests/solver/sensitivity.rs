//! Derivatives of forces and measures with respect to every parameter: direct against adjoint, and both against differences of equilibria.

use admire_solver::model::PartIx;
use admire_solver::statics::{Sensitivity, Solver, StaticSettings};
use admire_solver::system::{Parameters, Quantity, Scratch, Slot, State, System};

use crate::deck;
use crate::differences::{richardson, step};
use crate::reference::{AXLES, load};

/// Returns the forces of all elements and the reactions of all joints, each with a weight that makes torques comparable to forces.
fn forces(system: &System) -> Vec<(Quantity, f64)> {
    let mut out = Vec::new();
    for (element, _) in system.elements() {
        out.extend((0..6).map(|c| Quantity::Element(element, c)));
    }
    for (constraint, _) in system.constraints() {
        out.extend((0..6).map(|c| Quantity::Constraint(constraint, c)));
    }
    out.into_iter()
        .map(|q| match q {
            Quantity::Element(_, c) | Quantity::Constraint(_, c) if c > 2 => (q, 0.01),
            q => (q, 1.0),
        })
        .collect()
}

fn values(
    system: &System,
    solver: &mut Solver,
    parameters: &Parameters,
    state: &State,
    quantities: &[(Quantity, f64)],
) -> Vec<f64> {
    let mut state = state.clone();
    solver
        .solve(system, parameters, &mut state, &StaticSettings::tight())
        .unwrap();
    let mut scratch = Scratch::new(system);
    quantities
        .iter()
        .map(|(q, w)| {
            let mut here = system.evaluate(parameters, &state, &mut scratch).unwrap();
            w * here.quantity(*q).unwrap()
        })
        .collect()
}

fn norm(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|x| x * x).sum::<f64>().sqrt()
}

/// Checks the derivatives with respect to all parameters. Returns the ratios by which the errors of plain central differences fall if the step
/// is halved.
fn check(
    system: &System,
    parameters: &Parameters,
    state: &State,
    quantities: &[(Quantity, f64)],
) -> Vec<f64> {
    let mut solver = Solver::new(system);
    let mut sensitivity = Sensitivity::new(system, parameters, state).unwrap();
    let slots: Vec<Slot> = system
        .catalogue()
        .slots()
        .filter(|slot| !parameters.get(*slot).is_nan())
        .collect();
    let adjoint: Vec<Vec<f64>> = quantities
        .iter()
        .map(|(q, w)| {
            let row = sensitivity.adjoint(*q, &slots).unwrap();
            row.into_iter().map(|d| d * w).collect()
        })
        .collect();
    let all: Vec<Quantity> = quantities.iter().map(|q| q.0).collect();
    let mut moved = parameters.clone();
    let mut falls = Vec::new();
    let mut worst = (0.0, String::new());
    for (at, &slot) in slots.iter().enumerate() {
        let address = system.catalogue().info(slot).address.to_string();
        let direct = sensitivity.direct(&all, slot).unwrap();
        let direct: Vec<f64> = direct
            .iter()
            .zip(quantities)
            .map(|(d, (_, w))| d * w)
            .collect();
        let size = norm(direct.iter().copied());
        let apart = norm(direct.iter().zip(&adjoint).map(|(d, a)| d - a[at]));
        assert!(apart <= 1e-9 * size + 1e-9, "{address}: {apart} of {size}");
        let here = parameters.get(slot);
        let h = step(system, slot, here);
        let mut difference = |h: f64| -> Vec<f64> {
            moved.set(slot, here + h);
            let plus = values(system, &mut solver, &moved, state, quantities);
            moved.set(slot, here - h);
            let minus = values(system, &mut solver, &moved, state, quantities);
            moved.set(slot, here);
            let pairs = plus.iter().zip(&minus);
            pairs.map(|(p, m)| (p - m) / (2.0 * h)).collect()
        };
        let (coarse, fine) = (difference(h), difference(h / 2.0));
        let error = |d: &[f64]| {
            norm(
                d.iter()
                    .zip(&direct)
                    .map(|(difference, exact)| difference - exact),
            )
        };
        // Forces contain stiffness times the round-off of positions: 1e4 N/mm times 1e-12 mm.
        let noise = 3e-8 / h;
        let relative = error(&richardson(&coarse, &fine)) / (size + 1e5 * noise);
        if relative > worst.0 {
            worst = (relative, address.clone());
        }
        if error(&coarse) > 100.0 * noise {
            falls.push(error(&coarse) / error(&fine));
        }
    }
    println!(
        "{} numbers, {} quantities, worst {worst:?}",
        slots.len(),
        quantities.len()
    );
    assert!(worst.0 < 1e-5, "{worst:?}");
    falls
}

#[test]
fn forces_of_the_axles() {
    for stem in AXLES {
        let Some((model, _)) = load(stem) else { return };
        let system = System::compile(&model).value;
        let (mut parameters, mut state) = (system.parameters(), system.state());
        for (id, force) in [(1, -300.0), (2, 500.0), (3, 3500.0)] {
            let slot = system
                .catalogue()
                .slot(&crate::reference::address("SFORCE", id));
            parameters.set(slot.unwrap(), force);
        }
        Solver::new(&system)
            .solve(&system, &parameters, &mut state, &StaticSettings::tight())
            .unwrap();
        let mut falls = check(&system, &parameters, &state, &forces(&system));
        falls.sort_by(f64::total_cmp);
        let middle = falls[falls.len() / 2];
        println!(
            "{stem}: error falls by {middle} over {} numbers",
            falls.len()
        );
        // The error is of second order: a quarter at half the step.
        assert!((middle - 4.0).abs() < 0.1 && falls.len() >= 10, "{middle}");
    }
}

/// Checks that results are bitwise equal with one thread and with several, by both methods.
#[test]
fn any_number_of_threads() {
    let Some((model, _)) = load("reference/multilink/ocp_ref") else {
        return;
    };
    let system = System::compile(&model).value;
    let (parameters, mut state) = (system.parameters(), system.state());
    Solver::new(&system)
        .solve(&system, &parameters, &mut state, &StaticSettings::tight())
        .unwrap();
    let sensitivity = Sensitivity::new(&system, &parameters, &state).unwrap();
    let quantities: Vec<Quantity> = forces(&system).into_iter().map(|q| q.0).collect();
    let slots: Vec<Slot> = system.catalogue().slots().collect();
    for (quantities, slots) in [
        (&quantities[..], &slots[..20]),
        (&quantities[..9], &slots[..]),
    ] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let table = || sensitivity.table(quantities, slots).unwrap();
            let rows = pool.build().unwrap().install(table);
            let bits = rows.iter().flatten().map(|d| d.to_bits());
            bits.collect::<Vec<u64>>()
        };
        let alone = with(1);
        assert!(alone.iter().any(|bits| *bits != 0));
        assert!([2, 3, 8].into_iter().all(|n| with(n) == alone));
    }
}

/// Checks measures: functions of a REQUEST that read displacements and forces, in a deck whose force depends on a measure.
#[test]
fn measures() {
    let solved = deck::solve(
        "PART/2, MASS=1, CM=20, IP=100,100,100\nMARKER/20, PART=2, QP=3,4,5\nMARKER/21, PART=2, QP=10,-5,2\n\
         MARKER/2, PART=1, QP=8,-9,4, REULER=20D,30D,10D\nMARKER/9, PART=1, FLOATING\n\
         BUSHING/1, I=21, J=2, K=100,200,300, KT=4E3,5E3,6E3, FORCE=10,20,30\n\
         GFORCE/1, I=20, JFLOAT=9, RM=2, FX=50+2*DX(20,2,2)\\, TZ=300\nSPRINGDAMPER/1, I=20, J=1, TRANSLATIONAL, K=15, LENGTH=3\n\
         REQUEST/1, F2=DM(20,1)\\, F3=BUSH(1,0,3,2)\\, F4=SPDP(1,1,2,0)*2\\, F6=AZ(21,2)\\, F7=GFORCE(1,0,2,0)+TIME",
    );
    let mut quantities: Vec<(Quantity, f64)> = [(1, 1.0), (2, 1.0), (3, 1.0), (5, 10.0), (6, 1.0)]
        .map(|(c, w)| (Quantity::Request(0, c), w))
        .to_vec();
    quantities.extend((0..6).map(|c| (Quantity::Motion(PartIx(1), c), 1.0)));
    let motion = quantities.split_off(5);
    check(
        &solved.system,
        &solved.parameters,
        &solved.state,
        &quantities,
    );
    // Motions are the unknowns themselves, so their derivatives are those of the tangent.
    let mut sensitivity =
        Sensitivity::new(&solved.system, &solved.parameters, &solved.state).unwrap();
    let address = admire_syntax::Address {
        argument: Some("K".to_string()),
        index: Some(2),
        ..crate::reference::address("BUSHING", 1)
    };
    let slot = solved.system.catalogue().slot(&address).unwrap();
    for (quantity, _) in motion {
        let direct = sensitivity.direct(&[quantity], slot).unwrap()[0];
        let adjoint = sensitivity.adjoint(quantity, &[slot]).unwrap()[0];
        assert!((direct - adjoint).abs() < 1e-12 * direct.abs().max(1e-6));
        assert!(direct != 0.0);
    }
}

/// Checks parameters of VARIABLEs, which act through everything that reads them: other variables, loops, and measured forces.
#[test]
fn variables_of_variables() {
    let solved = deck::solve(
        "PART/2, MASS=1, CM=20, IP=100,100,100\nMARKER/20, PART=2, QP=3,4,5\nMARKER/21, PART=2, QP=10,-5,2\n\
         MARKER/2, PART=1, QP=8,-9,4, REULER=20D,30D,10D\nMARKER/9, PART=1, FLOATING\n\
         BUSHING/1, I=21, J=2, K=100,200,300, KT=4E3,5E3,6E3, FORCE=10,20,30\n\
         VARIABLE/1, FUNCTION=40+0.2*DX(20,2,2)*VARVAL(2)/VARVAL(3)\nVARIABLE/2, FUNCTION=1.5+0.01*DM(20,1)\n\
         VARIABLE/3, FUNCTION=SQRT(4+0.001*BUSH(1,0,3,2)*BUSH(1,0,3,2))+0.1*VARVAL(2)\nVARIABLE/4, FUNCTION=0.3*VARVAL(4)+5*VARVAL(3)\n\
         VARIABLE/5, FUNCTION=2*VARVAL(1)+VARVAL(4)\nVARIABLE/6, FUNCTION=12\n\
         ARRAY/1, X, SIZE=1\nARRAY/2, U, SIZE=1, VARIABLES=6\nARRAY/3, Y, SIZE=1\n\
         MATRIX/1, FULL=RORDER, ROWS=1, COLUMNS=1, VALUES=-2\nLSE/1, X=1, U=2, Y=3, A=1, B=1, C=1\n\
         GFORCE/1, I=20, JFLOAT=9, RM=2, FX=VARVAL(1)\\, FY=0.3*VARVAL(4)\\, TX=20*ARYVAL(3,1)\\, TZ=10*VARVAL(2)\n\
         REQUEST/1, F2=VARVAL(1)\\, F3=VARVAL(5)\\, F4=GFORCE(1,0,2,0)+VARVAL(4)\\, F6=10*AZ(21,2)",
    );
    let quantities: Vec<(Quantity, f64)> = [1, 2, 3, 5]
        .map(|c| (Quantity::Request(0, c), 1.0))
        .to_vec();
    check(
        &solved.system,
        &solved.parameters,
        &solved.state,
        &quantities,
    );
}

/// Checks a GEAR whose first joint is cylindrical. Its reaction there has two components, a torque and a force, which both change with every
/// parameter.
#[test]
fn reaction_of_a_gear_at_a_cylindrical_joint() {
    let solved = deck::solve(
        "MARKER/2, PART=1, REULER=10D,70D,-20D\nMARKER/3, PART=1, QP=60,5,0, REULER=30D,50D,0D\nMARKER/4, PART=1, QP=25,10,5, REULER=40D,80D,10D\n\
         PART/2, MASS=1, CM=20, IP=100,100,100\nMARKER/20, PART=2, REULER=10D,70D,-20D\nMARKER/21, PART=2, QP=10,-5,20\n\
         PART/3, MASS=1, CM=30, IP=100,100,100\nMARKER/30, PART=3, QP=60,5,0, REULER=30D,50D,0D\nMARKER/31, PART=3, QP=70,20,3\n\
         JOINT/1, CYLINDRICAL, I=20, J=2\nJOINT/2, REVOLUTE, I=30, J=3\nGEAR/1, JOINTS=1,2, CV=4\n\
         BUSHING/1, I=21, J=1, K=10,20,30, KT=4E3,5E3,6E3, FORCE=10,20,30\n\
         SPRINGDAMPER/1, TRANSLATIONAL, I=31, J=1, K=5, LENGTH=40",
    );
    let quantities = forces(&solved.system);
    let (gear, _) = solved.system.constraints().last().unwrap();
    let mut scratch = Scratch::new(&solved.system);
    let mut here = solved
        .system
        .evaluate(&solved.parameters, &solved.state, &mut scratch)
        .unwrap();
    let told = here.read_constraint(gear);
    let whole = [told.force.x, told.force.y, told.force.z, told.torque.x];
    for (component, told) in whole.into_iter().enumerate() {
        let value = here.quantity(Quantity::Constraint(gear, component));
        assert!((value.unwrap() - told).abs() < 1e-12 * told.abs());
    }
    // A force along the axis and a torque about it.
    let axis = solved.state.poses[1].R
        * admire_solver::mechanics::euler313(
            10_f64.to_radians(),
            70_f64.to_radians(),
            -20_f64.to_radians(),
        )
        .column(2);
    assert!(told.force.dot(&axis).abs() > 1.0 && told.torque.dot(&axis).abs() > 1.0);
    check(
        &solved.system,
        &solved.parameters,
        &solved.state,
        &quantities,
    );
}
