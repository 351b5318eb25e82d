use super::*;
use crate::bushing::{OddLaw, OddTerm};
use admire_syntax::diff::{DiffKind, DiffTolerance};

const FRONT: &str = "$---MDI_HEADER\r\n[MDI_HEADER]\r\n FILE_TYPE  =  'sub'\r\n$---UNITS\r\n[UNITS]\r\n LENGTH  =  'mm'\r\n FORCE   =  'newton'\r\n ANGLE   =  'deg'\r\n\
    $---HARDPOINT\r\n[HARDPOINT]\r\n{hardpoint_name  symmetry  x_value  y_value  z_value}\r\n\
    \x20'lca_outer   '  'left/right'   -512.0   -716.0   27.4  ! ball joint\r\n 'rack        '  'single    '   10.0   0.0   80.0\r\n\
    $---BUSHING_ASSEMBLY\r\n[BUSHING_ASSEMBLY]\r\n USAGE              =  'lca_front'\r\n SYMMETRY           =  'left/right'\r\n\
    \x20PROPERTY_FILE      =  'mdids://car/bushings.tbl/soft.bus'\r\n FX_SCALING_FACTOR  =  1.5\r\n\
    $---BUSHING_ASSEMBLY\r\n[BUSHING_ASSEMBLY]\r\n USAGE  =  'mount'\r\n SYMMETRY  =  'single'\r\n\
    $---PARAMETER\r\n[PARAMETER]\r\n{parameter_name  symmetry  type  value}\r\n 'flag'  'single'  'integer'  0\r\n";

fn subsystem(text: &str) -> Subsystem {
    let read = Subsystem::parse(Source::new("front.sub", text));
    assert_eq!(read.diagnostics, []);
    read.value
}

fn moved(hardpoint: usize, side: Side, by: [f64; 3]) -> HardpointMove {
    HardpointMove {
        hardpoint,
        side,
        by,
        std_error: [Some(0.1); 3],
        because: "hardpoint-error MARKER/7".to_string(),
    }
}

fn change(usage: &str, side: Side) -> BushingChange {
    BushingChange {
        name: BushingName {
            side,
            usage: usage.to_string(),
        },
        scale: [None; 6],
        preload: [None; 6],
        offset: [None; 6],
        learned: None,
        because: "identified BUSHING/1".to_string(),
    }
}

/// Writes results into the file FRONT. Returns the lines that are only in the old file, then the lines that are only in the new file.
fn written(
    in_deck: &[(usize, Side)],
    moves: &[HardpointMove],
    bushings: &[(&str, Side)],
    changes: &[BushingChange],
) -> (WriteBack, [Vec<String>; 2]) {
    let old = subsystem(FRONT);
    let in_deck = in_deck.iter().copied().collect();
    let bushings = bushings
        .iter()
        .map(|(usage, side)| ((*usage).to_string(), *side))
        .collect();
    let out = WriteBack::new(&old, &Units::default(), &in_deck, moves, &bushings, changes);
    let new = String::from_utf8(out.bytes.clone()).expect("text");
    let only = |a: &str, b: &str| -> Vec<String> {
        let mut rest: Vec<&str> = b.split("\r\n").collect();
        let gone = a.split("\r\n").filter(|line| {
            let same = rest.iter().position(|other| other == line);
            same.map(|at| rest.remove(at)).is_none()
        });
        gone.map(str::to_string).collect()
    };
    let lines = [only(FRONT, &new), only(&new, FRONT)];
    let again = Subsystem::parse(Source::new("front.sub", new));
    assert_eq!(again.diagnostics, []);
    (out, lines)
}

#[test]
fn one_line_changes_for_a_hardpoint_and_all_other_bytes_stay() {
    let (out, [old, new]) = written(
        &[(0, Side::Left)],
        &[moved(0, Side::Left, [0.0, -1.25, 1e-12])],
        &[],
        &[],
    );
    assert_eq!(
        old,
        [" 'lca_outer   '  'left/right'   -512.0   -716.0   27.4  ! ball joint"]
    );
    assert_eq!(
        new,
        [" 'lca_outer   '  'left/right'   -512.0   -717.25   27.4  ! ball joint"]
    );
    assert_eq!(out.bytes.len(), FRONT.len() + 1);
    let word = &out.changes[0];
    assert_eq!(
        (
            word.element.as_str(),
            word.factor.as_str(),
            word.unit.as_str()
        ),
        ("hpl_lca_outer", "y", "mm")
    );
    // If the deck contains only the right side, its mirror image is written.
    let (_, [_, new]) = written(
        &[(0, Side::Right)],
        &[moved(0, Side::Right, [0.5, 1.25, 0.0])],
        &[],
        &[],
    );
    assert_eq!(
        new,
        [" 'lca_outer   '  'left/right'   -511.5   -717.25   27.4  ! ball joint"]
    );
    // Both sides move as mirror images.
    let both = [(0, Side::Left), (0, Side::Right)];
    let moves = [
        moved(0, Side::Left, [0.0, -1.25, 0.0]),
        moved(0, Side::Right, [0.0, 1.25, 0.0]),
    ];
    let (out, [_, new]) = written(&both, &moves, &[], &[]);
    assert_eq!((new.len(), out.changes.len()), (1, 1));
    let (_, [old, new]) = written(&[], &[moved(1, Side::Single, [0.0, 0.0, 0.75])], &[], &[]);
    assert_eq!((old.len(), new.len()), (1, 1));
    assert!(new[0].ends_with("   80.75"));
}

#[test]
fn a_pair_with_one_side_moved_becomes_two_rows() {
    let both = [(0, Side::Left), (0, Side::Right)];
    let (out, [old, new]) = written(&both, &[moved(0, Side::Right, [0.0, 0.0, 2.0])], &[], &[]);
    assert_eq!(old.len(), 1);
    assert_eq!(
        new,
        [
            " 'lca_outer   '  'left      '   -512.0   -716.0   27.4  ! ball joint",
            " 'lca_outer   '  'right     '   -512.0   716.0   29.4  ! ball joint",
        ]
    );
    assert_eq!(out.changes[0].element, "hpr_lca_outer");
}

#[test]
fn a_scale_factor_is_multiplied_and_a_missing_one_is_added() {
    let mut one = change("lca_front", Side::Left);
    one.scale[0] = Some((1.2, Some(0.01)));
    one.scale[5] = Some((0.5, None));
    one.preload[2] = Some(-30.0);
    one.offset[0] = Some(0.25);
    one.offset[5] = Some(0.5_f64.to_radians());
    let (out, [old, new]) = written(&[], &[], &[("lca_front", Side::Left)], &[one]);
    assert_eq!(old, [" FX_SCALING_FACTOR  =  1.5"]);
    assert_eq!(
        new,
        [
            " FX_SCALING_FACTOR  =  1.8",
            " TZ_SCALING_FACTOR  =  0.5",
            " T_OFFSET_X         =  0.25",
            " T_PRELOAD_Z        =  -30.0",
            " R_OFFSET_Z         =  0.5",
        ]
    );
    let errors: Vec<Option<f64>> = out.changes.iter().map(|word| word.std_error).collect();
    assert_eq!(errors, [Some(0.015), None, None, None, None]);
    let units: Vec<&str> = out.changes.iter().map(|word| word.unit.as_str()).collect();
    assert_eq!(units, ["", "", "mm", "newton", "deg"]);
    let mut other = change("missing", Side::Left);
    other.scale[0] = Some((2.0, None));
    let (out, [old, new]) = written(&[], &[], &[], &[other]);
    assert!(old.is_empty() && new.is_empty());
    assert_eq!(out.not_written.len(), 1);
}

#[test]
fn two_sides_of_a_bushing_that_differ_become_two_blocks() {
    let there = [("lca_front", Side::Left), ("lca_front", Side::Right)];
    let mut left = change("lca_front", Side::Left);
    left.scale[0] = Some((2.0, None));
    let mut right = change("lca_front", Side::Right);
    right.scale[0] = Some((2.0, None));
    let (_, [_, new]) = written(&[], &[], &there, &[left.clone(), right.clone()]);
    assert_eq!(new, [" FX_SCALING_FACTOR  =  3.0"]);
    right.scale[1] = Some((0.5, None));
    let mut mount = change("mount", Side::Single);
    mount.scale[2] = Some((1.1, None));
    let (out, _) = written(&[], &[], &there, &[left, right, mount]);
    let before = subsystem(FRONT).file;
    let after = PropertyFile::parse(Source::new("new.sub", out.bytes)).value;
    let found: Vec<String> = crate::diff(&before, &after, DiffTolerance::default())
        .iter()
        .map(|d| match &d.change {
            DiffKind::Number { written, .. } => format!("{}={}", d.address, written[1]),
            DiffKind::Text { after, .. } => format!("{}={after:?}", d.address),
            _ => d.address.clone(),
        })
        .collect();
    assert_eq!(
        found,
        [
            "BUSHING_ASSEMBLY/lca_front.SYMMETRY=Some(\"left\")",
            "BUSHING_ASSEMBLY/lca_front.FX_SCALING_FACTOR=3.0",
            "BUSHING_ASSEMBLY/lca_front#2.USAGE=Some(\"lca_front\")",
            "BUSHING_ASSEMBLY/lca_front#2.SYMMETRY=Some(\"right\")",
            "BUSHING_ASSEMBLY/lca_front#2.PROPERTY_FILE=Some(\"mdids://car/bushings.tbl/soft.bus\")",
            "BUSHING_ASSEMBLY/lca_front#2.FX_SCALING_FACTOR=Some(\"3.0\")",
            "BUSHING_ASSEMBLY/lca_front#2.FY_SCALING_FACTOR=Some(\"0.5\")",
            "BUSHING_ASSEMBLY/mount.FZ_SCALING_FACTOR=Some(\"1.1\")",
        ]
    );
}

#[test]
fn a_learned_curve_is_a_file_that_the_subsystem_names() {
    let law = OddLaw {
        stiffness: 900.0,
        terms: vec![OddTerm::power(3, 120.0)],
    };
    let mut property = BushingProperty::default();
    property.curves[0] = Some(law.curve(2.0));
    let mut one = change("lca_front", Side::Left);
    one.scale[0] = Some((7.0, None));
    one.learned = Some(property.clone());
    let (out, [_, new]) = written(&[], &[], &[("lca_front", Side::Left)], &[one]);
    assert_eq!(
        new,
        [
            " PROPERTY_FILE      =  'mdids://car/bushings.tbl/lca_front_learned.bus'",
            " FX_SCALING_FACTOR  =  1.0",
        ]
    );
    let [file] = out.files.as_slice() else {
        panic!("one file: {:?}", out.files);
    };
    assert_eq!(file.name, "lca_front_learned.bus");
    let read = PropertyFile::parse(Source::new("a.bus", file.text.as_str()));
    assert_eq!(read.diagnostics, []);
    assert_eq!(
        BushingProperty::of(&read.value, &Units::default()).curves,
        property.curves
    );
}
