//! A heavy arm that starts level, where its weight acts without any stiffness, and typical errors in decks of it.

use crate::run::{Ran, Results, folder, mdi};

/// Runs an arm of 2 kg, `length` mm from its pin, with an optional motion; the deck has the style of old decks.
fn arm(length: f64, motion: &str, commands: &str) -> (Option<Results>, Ran) {
    let deck = format!(
        "level arm\nunits/for=newton,mass=kilogram,len=millimeter,tim=second\npart/1,ground\nmar/1\nmar/10,reuler=0,90d,0\n\
         part/2,mass=2,cm=20,ip=2e4,2e4,2e4,\n,qg={length},0,0 ! the arm\nmar/20\n\tmar/21,qp=-{length},0,0,reuler=0,90d,0\n\
         jo/1,rev,i=21,j=10\n{motion}\naccg/kg=-9806.65\nresu/form,xrf\nend\n"
    );
    let acf = format!("\nfile/model=arm\n{commands}\nstop\n");
    let folder = folder(&[("arm.adm", &deck), ("run.acf", &acf)]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    let results = folder.path().join("arm.res").exists();
    let results = results.then(|| Results::read_all(folder.path(), "arm.res"));
    (results, ran)
}

fn hangs(results: Option<Results>, length: f64, ran: &Ran) {
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert!(!ran.stdout.contains("ERROR"), "{}", ran.stdout);
    let results = results.expect("a result");
    let last = |component| *results.column("PART_2_XFORM", component).last().unwrap();
    assert!(last("X").abs() < 1e-3, "{}", last("X"));
    assert!((last("Z") + length).abs() < 1e-6, "{}", last("Z"));
}

#[test]
fn its_equilibrium_is_found_from_there() {
    for length in [300.0, 299.9999, 1000.0, 8000.0] {
        let (results, ran) = arm(length, "", "sim/stat");
        hangs(results, length, &ran);
    }
}

/// Checks that reaching a stated MAXIT is reported, with the hint that the initial position may be the only problem.
#[test]
fn a_stated_limit_ends_its_way() {
    let (_, ran) = arm(1000.0, "equi/maxit=20", "sim/stat");
    for said in [
        "the iteration reached MAXIT=20",
        "this motion is driven by the weight of PART/2; if this is so only at the start, change the start positions",
    ] {
        assert!(ran.stdout.contains(said), "{}", ran.stdout);
    }
}

#[test]
fn a_motion_that_is_switched_off_is_no_redundant_equation() {
    let commands = "sim/stat\ndeact/motion,id=1\nsim/stat";
    let (results, ran) = arm(300.0, "motion/1,jo=1,rot,fu=0", commands);
    hangs(results, 300.0, &ran);
    assert!(
        !ran.stdout.contains("constraint equation"),
        "{}",
        ran.stdout
    );
}

#[test]
fn a_transfer_function_of_ids_says_that_it_wants_coefficients() {
    let control = "vari/1,fu=time\narray/1,u,var=1\narray/2,x\narray/3,y\narray/4,num=1\narray/5,num=1,0.02\n\
                   tfsiso/1,x=2,u=1,y=3,num=4,den=5";
    let (_, ran) = arm(300.0, control, "sim/stat");
    for said in [
        "TFSISO/1 has no states: the order of DENOMINATOR must be at least 1",
        "they are not ids of ARRAYs",
    ] {
        assert!(ran.stdout.contains(said), "{}", ran.stdout);
    }
    assert_ne!(ran.code, 0);
}
