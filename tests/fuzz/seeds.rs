//! Seeds of the fuzz tests: files of the project, shared real files if available, and a small results file of each format.

use std::path::Path;

use admire_results::{
    Catalogue, Component, Entity, GraphicsHead, GraphicsJoint, GraphicsShape, GraphicsWriter,
    Header, RequestEntry, RequestWriter, StepKind, Style, Timestamp, XrfWriter,
};
use admire_syntax::units::Units;

use crate::common::tiling::real_files;
use crate::common::{files_below, shared};

/// Returns the files of the corpus and the real files with this extension.
pub fn all(ending: &str) -> Vec<Vec<u8>> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let own = files_below(&corpus, ending).into_iter();
    let own = own.map(|path| std::fs::read(path).expect("readable file"));
    own.chain(real_files(ending).into_iter().map(|(_, bytes)| bytes))
        .collect()
}

/// Returns files that once caused a fault.
pub fn faults(ending: &str) -> Vec<Vec<u8>> {
    let Some(folder) = shared("reference/faults") else {
        return Vec::new();
    };
    let ending = format!(".{ending}.txt");
    files_below(&folder, "txt")
        .into_iter()
        .filter(|path| path.to_string_lossy().ends_with(&ending))
        .map(|path| std::fs::read(path).expect("readable file"))
        .collect()
}

/// Returns a results file of two steps, with names that need escaping in XML.
pub fn xrf() -> Vec<u8> {
    let component = |id, name: &str| Component {
        name: name.to_string(),
        units: Some("no_units".to_string()),
        plot_label: None,
        id,
    };
    let time = Entity {
        name: "time".to_string(),
        components: vec![component(1, "TIME")],
        ..Entity::default()
    };
    let part = Entity {
        name: "arm_XFORM".to_string(),
        entity: Some("arm <left> & \"right\"".to_string()),
        ent_type: Some("Part".to_string()),
        object_id: Some(2),
        comment: None,
        components: vec![component(2, "X"), component(3, "Y"), component(4, "Z")],
    };
    let header = Header {
        title: "a < b & c".to_string(),
        ..Header::default()
    };
    let catalogue = Catalogue::new(vec![time, part]);
    let mut writer = XrfWriter::create(Vec::new(), &header, &catalogue, Style::default()).unwrap();
    writer
        .step(StepKind::QuasiStatic, &[0.0, 1.5, -2e-300, 3.25])
        .unwrap();
    writer
        .step(StepKind::Dynamic, &[0.1, 1.0 / 3.0, -0.0, 1e300])
        .unwrap();
    writer.finish("Successful").unwrap()
}

pub fn req() -> Vec<u8> {
    let entry = |id, name: &str| RequestEntry {
        id,
        name: name.to_string(),
        numbers: vec![1, 20, 1],
    };
    let requests = [entry(1, "toe"), entry(7, "camber angle")];
    let when = Timestamp::from_unix(1_600_000_000);
    let mut writer =
        RequestWriter::create(Vec::new(), "a title", &Units::default(), when, &requests).unwrap();
    writer
        .step(0.0, &[[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.0; 6]])
        .unwrap();
    writer.step(0.5, &[[-1e-10; 6], [1e20; 6]]).unwrap();
    writer.finish()
}

pub fn gra() -> Vec<u8> {
    let head = GraphicsHead {
        title: "a title".to_string(),
        ground: 1,
        parts: vec![2, 3],
        joints: vec![GraphicsJoint {
            id: 4,
            markers: [1, 2],
        }],
        shapes: vec![
            GraphicsShape::Force { id: 70, marker: 1 },
            GraphicsShape::Spring {
                id: 74,
                markers: [1, 2],
                counts: [20, 10],
                sizes: [1.0; 7],
            },
        ],
        input: vec![[0.0; 6]; 2],
        ..GraphicsHead::default()
    };
    let when = Timestamp::from_unix(1_600_000_000);
    let mut writer = GraphicsWriter::create(Vec::new(), when, &head).unwrap();
    for (kind, time) in [(StepKind::Static, 0.0), (StepKind::Dynamic, 0.5)] {
        let poses = [[1.0, -2.0, 3.0, -0.5, 0.25, time], [0.0; 6]];
        writer.frame(kind, time, &poses, &[[-6.0; 6]]).unwrap();
    }
    writer.finish()
}

/// Returns a results file in the format that ADAMS wrote before XRF.
pub fn formatted() -> Vec<u8> {
    let mut text = String::new();
    for (name, lines) in [
        (
            "FILE TYPE AND SOURCE",
            &["ADAMS RESULTS FILE       MMKGS_N_RACA 0.100000000000000E+01"][..],
        ),
        ("DATA SET TITLE", &["a model", ""]),
        ("NUMBER OF ANALYSIS BLOCKS", &["       1       6"]),
        (
            "RIGID PARTS MAP",
            &[
                "       1YESNO NO ",
                "                   2       5       0       0",
            ],
        ),
        ("JOINTS MAP", &["       0YES"]),
        ("BUSHINGS MAP", &["       1YES", "  1  6"]),
        (
            "NAME MAP",
            &[
                "       1YES",
                "                   2RIGID PART                 1",
                ".m.arm",
            ],
        ),
        (
            "ANALYSIS OUTPUT BLOCK",
            &[
                "       1STATIC              1",
                " 0.00000E+00",
                "",
                "",
                " 1.0 2.0 3.0 0.7071067811865476 0.0 0.0 0.7071067811865476",
            ],
        ),
    ] {
        text += &format!("{name:<40}{:>8}\n", lines.len() + 1);
        text += &(lines.join("\n") + "\n!\n");
    }
    text.into_bytes()
}

pub const MSG: &str = "\n-----\n|   A d a m s   C++   S o l v e r   |\n|  Version: Adams 2019.2  |\n-----\n command: file/model=a\n---\n\
    |   Model Title  |\n|====|\n|    |\n|  the car  |\n|    |\n---\n---- START: WARNING ----\nfirst\n second\n---- END: WARNING ----\n\
    \x20 Begin Static Solution\n\n  Static Solution converged in 41 iterations\n  End Static Solution\n  Begin Simulation\n\n\
    \x20 ****** Performing Dynamic Simulation using HHT I3 Integrator ******\n\
    Degree-of-freedom analysis identified redundant constraints in the model:\n  ------\n\
    \x20  -  deactivating constraint equation  Zi.Xj in model.JOINT_1\n\n   0.00000E+00  1.0E-02  3  4\n   2.50000E-01  1.0E-02  3  4\n\
    \x20 End Simulation\n                    Finished -----\nElapsed time = 1.18s,  CPU time = 0.89s,  75.30%\n";

pub const PROPERTIES: [&str; 2] = [
    "$---MDI_HEADER\n[MDI_HEADER]\n FILE_TYPE     =  'bus'\n FILE_VERSION  =  4.0\n FILE_FORMAT = 'ASCII'\n[UNITS]\n LENGTH = 'mm'\n\
     FORCE = 'newton'\n ANGLE = 'degrees'\n MASS = 'kg'\n TIME = 'second'\n[DAMPING]\n FX_DAMPING = 10\n FY_DAMPING = 1.5E1\n TX_DAMPING = 20\n\
     [FX_CURVE]\n{ x  fx }\n-1 -100\n 0 0\n 1 100\n[TX_CURVE]\n{ax tx}\n-10 -200 $ a comment\n0 0\n10 200\n",
    "[MDI_HEADER]\nFILE_TYPE='spr'\n(COMMENTS)\n{comment_string}\n'a spring'\n[UNITS]\n LENGTH  =  'meter'\n FORCE   =  'pound_force'\n\
     [SPRING_DATA]\n FREE_LENGTH  =  210.5\n[CURVE]\n{ disp  force}\n-100.0 -12500.0\n 0.0 0.0\n 100.0 12500.0\n",
];

pub const EXPRESSIONS: [&str; 14] = [
    "10*TIME",
    "STEP(TIME, 0.0, 0D0, 1.0, 30D) - IMPACT(DZ(20,1,1), VZ(20,1,1,1), 1.5, 1E5, 2.2, 10, 0.1)",
    "IF(DX(20,1)-5: -1, 0, SQRT(ABS(DM(20,1))))**2**0.5",
    "AKISPL(DM(20,1),0,1,1)+CUBSPL(TIME,0,1)",
    "-2**-2*(3+4)/5-(-6)",
    "BISTOP(DY(20,1), VY(20,1), -1, 1, 1E4, 1.5, 100, 0.01)",
    "SHF(TIME, 0, 1, 2*PI, 0, 0) + HAVSIN(TIME,0,1,2,3)",
    "POLY(TIME, 0, 1, 2, 3) + CHEBY(TIME, 0, 1, 1, 2) + FORCOS(TIME, 0, 1, 1, 2) + FORSIN(TIME,0,1,1,2)",
    "MAX(MIN(AX(20,1), AY(20,1)), AZ(20,1)*RTOD)",
    "ATAN2(SIN(PSI(20,1)), COS(THETA(20,1))) + MOD(7, 3) + SIGN(1, -1) + DIM(3, 5)",
    "VARVAL(1) + ARYVAL(1,1) + BUSH(1,0,4,20)",
    "EXP(LOG(10)) + LOG10(100) + TANH(0.1) + SINH(1) + COSH(1) + ASIN(0.3) + ACOS(.3) + ATAN(1.) + AINT(2.5) + ANINT(2.5)",
    "STEP5(TIME,0,0,1,1)+SWEEP(TIME,1,0,1,1,2,0.1)+UNITVECTOR(1,2)%2",
    "INVPSD(TIME, 1, 1, 10, 10, 0, 0, 1)",
];
