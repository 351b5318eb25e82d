//! Tests of moved markers: markers with axes from points, and markers placed in the frame of another marker.

use admire::Deck;
use admire_solver::model::Model;
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

use super::folder::Folder;

/// A block on bushings. MARKER/1 and MARKER/3 take their axes from points. MARKER/1, MARKER/6 and MARKER/7 are placed in the frame of
/// another marker.
const DECK: &str = "block
UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND
!                      adams_view_name='ground'
PART/1, GROUND
!                      adams_view_name='block'
PART/2, QG=10,20,30, MASS=10, CM=20, IP=1E4,2E4,3E4
MARKER/20, PART=2, QP=5,0,0
MARKER/21, PART=2, QP=100,0,0
MARKER/22, PART=2, RM=21, QP=0,100,0, REULER=20D,10D,0
MARKER/5, PART=1, QP=1,2,3, REULER=30D,20D,10D
MARKER/1, PART=1, RM=5, QP=10,20,25, ZP=110,20,125, XP=110,40,25
MARKER/3, PART=1, QP=110,20,30, ZP=110,120,130
MARKER/6, PART=1, RM=5, QP=0,100,0, REULER=0.1,0.2,0.3
MARKER/7, PART=1, RM=6, QP=100,20,30
BUSHING/1, I=20, J=1, K=1E3,2E3,500, KT=1E6,2E6,3E6
BUSHING/2, I=21, J=3, K=3E2,2E2,400, KT=1E6,1E6,1E6
BUSHING/3, I=22, J=7, K=1E2,2E2,500, KT=1E6,1E6,1E6
ACCGRAV/KGRAV=-9806.65
EQUILIBRIUM/ERROR=1E-12, IMBALANCE=1E-9, MAXIT=100
RESULTS/FORMATTED, XRF
END
";

fn model(text: &[u8]) -> Model {
    let dataset = Dataset::parse(Source::new("d.adm", text));
    assert!(!dataset.has_errors(), "{:?}", dataset.diagnostics);
    Model::lower(&dataset.value).value
}

/// Returns the position and the rotation matrix of a marker on its part.
fn frame(model: &Model, id: u32) -> ([f64; 3], Vec<f64>) {
    let marker = &model.markers[model.marker(id).unwrap().0];
    (marker.qp.into(), marker.R.iter().copied().collect())
}

fn near(a: &[f64], b: &[f64]) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn a_marker_that_is_moved_keeps_its_axes() {
    let before = frame(&model(DECK.as_bytes()), 3);
    let mut of_library = Deck::parse("d.adm", DECK.as_bytes());
    for (k, value) in [(1, 111.5), (2, 18.25), (3, 31.0)] {
        of_library.set(&format!("MARKER/3.QP.{k}"), value).unwrap();
    }
    let dataset = Dataset::parse(Source::new("d.adm", DECK.as_bytes())).value;
    let address = |text: &str| Address::parse(text, &dataset).unwrap();
    let edits = dataset.set(&address("MARKER/3.QP.1"), 111.5).unwrap();
    let of_edits = dataset.edited(&edits).unwrap().value.bytes().to_vec();
    let folder = Folder::with(DECK);
    let (code, whole, said) = folder.run(&["set", "d.adm", "MARKER/3.QP=111.5, 18.25, 31"]);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("MARKER/3 keeps its orientation"), "{said}");
    let (code, one, _) = folder.run(&["set", "d.adm", "MARKER/3.QP.1+=1.5"]);
    assert_eq!(code, 0);
    for (text, place) in [
        (of_library.bytes(), [111.5, 18.25, 31.0]),
        (whole.as_bytes(), [111.5, 18.25, 31.0]),
        (of_edits.as_slice(), [111.5, 20.0, 30.0]),
        (one.as_bytes(), [111.5, 20.0, 30.0]),
    ] {
        let (found, axes) = frame(&model(text), 3);
        assert_eq!(found, place);
        near(&axes, &before.1);
    }
    assert!(whole.contains("ZP=111.5,118.25,131"), "{whole}");
}

#[test]
fn a_point_with_a_value_of_its_own_stays_and_the_marker_turns() {
    let folder = Folder::with(DECK);
    for order in [
        ["MARKER/3.ZP.1=120", "MARKER/3.QP.1=115"],
        ["MARKER/3.QP.1=115", "MARKER/3.ZP.1=120"],
    ] {
        let (code, deck, said) = folder.run(&["set", "d.adm", order[0], order[1]]);
        assert_eq!(code, 0, "{said}");
        assert!(deck.contains("QP=115,20,30, ZP=120,120,130"), "{deck}");
        assert!(said.contains("MARKER/3 rotates"), "{said}");
    }
    let json = folder.run(&["export", "d.adm", "--json"]).1;
    folder.write("d.json", &json.replace("110,", "112,"));
    let (code, deck, said) = folder.run(&["import", "d.adm", "d.json"]);
    assert_eq!(code, 0, "{said}");
    assert!(deck != DECK && !said.contains("rotates"), "{said}");
}

/// Checks sensitivities to numbers of the deck against central differences of edited and solved decks.
#[test]
fn sensitivities_are_what_edits_give() {
    let deck = Deck::parse("d.adm", DECK.as_bytes());
    let by: Vec<String> = [
        "MARKER/5",
        "MARKER/1.QP",
        "MARKER/3.QP",
        "MARKER/6",
        "MARKER/7",
    ]
    .map(str::to_string)
    .to_vec();
    let table = deck.sensitivity(&["block".to_string()], &by, 0.0).unwrap();
    assert!(table.by.len() >= 20, "{:?}", table.by);
    let place = |deck: &Deck| {
        let run = deck.solve().unwrap();
        run.succeeded().unwrap();
        ["X", "Y", "Z"].map(|axis| {
            *run.column(&format!("block.{axis}"))
                .unwrap()
                .last()
                .unwrap()
        })
    };
    let mut largest = 0.0_f64;
    for row in &table.by {
        let h = if row.address.contains("REULER") {
            1e-5
        } else {
            1e-3
        };
        let at = |step: f64| {
            let mut moved = deck.clone();
            moved.set(&row.address, row.value + step).unwrap();
            place(&moved)
        };
        let (plus, minus) = (at(h), at(-h));
        for k in 0..3 {
            let difference = (plus[k] - minus[k]) / (2.0 * h);
            let size = 1.0 + difference.abs();
            assert!(
                (difference - row.derivatives[k]).abs() < 1e-4 * size,
                "{} {k}: {difference} {}",
                row.address,
                row.derivatives[k]
            );
            largest = largest.max(difference.abs());
        }
    }
    assert!(largest > 0.1);
    // A marker with axes from points has no REULER value, so no sensitivity to it exists.
    let refused = deck.sensitivity(
        &["block".to_string()],
        &["MARKER/3.REULER".to_string()],
        0.0,
    );
    assert!(refused.is_err());
}
