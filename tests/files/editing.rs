//! Tests of text edits that change numbers, functions and statements of decks.

use std::collections::BTreeMap;

use admire_solver::model::{Function, Model, PairForce};
use admire_syntax::diagnostic::Code;
use admire_syntax::grammar::ValueKind;
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::{Address, Dataset, NewStatement, Value};

use super::lossless::{assert_dataset, real_files};
use super::lowering::dataset;

fn shown(text: &str, edits: &[Edit]) -> String {
    String::from_utf8(apply_edits(text.as_bytes(), edits).unwrap()).unwrap()
}

fn set(text: &str, address: &str, value: f64) -> String {
    let dataset = dataset(text).value;
    let address = Address::parse(address, &dataset).unwrap();
    let edits = dataset.set(&address, value).unwrap();
    let after = dataset.edited(&edits).unwrap().value;
    assert_eq!(after.value_at(&address), Some(value));
    assert_eq!(after.set(&address, value).unwrap(), [], "a second time");
    shown(text, &edits)
}

/// Returns the address of every number of a deck: argument values and function literals. The flag marks integers and object ids.
fn numbers(dataset: &Dataset) -> Vec<(Address, bool)> {
    let mut all = Vec::new();
    for statement in dataset.statements() {
        let Some(object) = Address::of(statement) else {
            continue;
        };
        let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
        for argument in &statement.arguments {
            let Some(def) = argument.def else {
                continue;
            };
            let count = match &argument.value {
                Value::Numbers(numbers) => numbers.len(),
                Value::Function(expression) => expression.literals.len(),
                _ => continue,
            };
            let ids: Vec<usize> = match &argument.value {
                Value::Function(expression) => {
                    let references = expression.references().into_iter();
                    references.map(|(_, literal)| literal).collect()
                }
                _ => Vec::new(),
            };
            let whole = matches!(def.kind, ValueKind::Integer | ValueKind::Reference(_));
            for k in 0..count {
                let index = seen.entry(def.name).or_insert(0);
                *index += 1;
                let address = Address {
                    argument: Some(def.name.to_string()),
                    index: Some(*index),
                    ..object.clone()
                };
                all.push((address, whole || ids.contains(&k)));
            }
        }
    }
    all
}

/// Returns a different value of the same kind, integer or real.
fn another(value: f64, whole: bool) -> f64 {
    if whole {
        value + 1.0
    } else {
        value + 0.375 * value.abs() + 0.125
    }
}

#[test]
fn any_number_of_any_real_deck_can_be_set_and_nothing_else_changes() {
    let mut count = 0;
    for (name, bytes) in real_files("adm") {
        let dataset = Dataset::parse(Source::new(name.as_str(), bytes.clone())).value;
        let numbers = numbers(&dataset);
        count += numbers.len();
        let mut all = Vec::new();
        let mut wanted = Vec::new();
        for (address, whole) in &numbers {
            let number = dataset.number_at(address).unwrap();
            assert_eq!(dataset.set(address, number.value).unwrap(), [], "{address}");
            let new = another(number.value, *whole);
            let edits = match dataset.set(address, new) {
                Ok(edits) => edits,
                Err(refused) => panic!("{name} {address} {new}: {refused:?}"),
            };
            let [edit, points @ ..] = edits.as_slice() else {
                panic!("{address}: {edits:?}");
            };
            assert_eq!(edit.span, number.span, "{address}");
            // Moving the origin of a marker also shifts the points that define its axes. Those further edits are dropped here, because each
            // point has its own test value.
            let moves = address.kind == "MARKER" && address.argument.as_deref() == Some("QP");
            let span = dataset
                .statement("MARKER", address.id)
                .map(|marker| marker.span);
            assert!(
                points.is_empty() || moves && points.len() <= 2,
                "{address}: {edits:?}"
            );
            assert!(points.iter().all(|point| span.is_some_and(|span| {
                span.start() < point.span.start() && point.span.end() <= span.end()
            })));
            wanted.push((address, new, number.degrees));
            all.push(edit.clone());
        }
        // All edits are applied together, and every number is read back.
        let after = dataset.edited(&all).unwrap().value;
        assert_dataset(&after, &apply_edits(&bytes, &all).unwrap());
        for (address, new, degrees) in &wanted {
            let read = after.number_at(address).unwrap();
            // A number keeps the suffix D only if some number of degrees converts to exactly the new value.
            assert!(*degrees || !read.degrees, "{address}");
            let tolerance = if *degrees && read.degrees {
                new.abs() * f64::EPSILON
            } else {
                0.0
            };
            assert!(
                (read.value - new).abs() <= tolerance,
                "{name} {address} {new} {read:?}"
            );
        }
        // The typed model is compared for real numbers only, because changed integers and ids would break the references of the deck.
        let reals: Vec<Edit> = numbers
            .iter()
            .filter(|(_, whole)| !whole)
            .filter_map(|(address, _)| {
                let number = dataset.number_at(address).unwrap();
                let edits = dataset.set(address, another(number.value, false));
                edits.unwrap().into_iter().next()
            })
            .collect();
        let model = Model::lower(&dataset.edited(&reals).unwrap().value).value;
        let whole: Vec<bool> = numbers.iter().map(|(_, whole)| *whole).collect();
        for ((address, new, _), whole) in wanted.iter().zip(whole) {
            if let Some(read) = typed(&model, address).filter(|_| !whole) {
                assert!(
                    (read - new).abs() <= new.abs() * f64::EPSILON,
                    "{name} {address}"
                );
            }
        }
    }
    println!("{count} numbers");
}

/// Returns the number of the typed model at an address, for the kinds of statement that this test covers.
fn typed(model: &Model, address: &Address) -> Option<f64> {
    let id = address.id?;
    let at = address.index? - 1;
    Some(
        match (address.kind.as_str(), address.argument.as_deref()?) {
            ("PART", "MASS") => model.parts.iter().find(|p| p.header.id == id)?.mass,
            ("PART", "QG") => model.parts.iter().find(|p| p.header.id == id)?.pose.p[at],
            ("MARKER", "QP") => model.markers.iter().find(|m| m.header.id == id)?.qp[at],
            ("BUSHING", "K") => model.bushings.iter().find(|b| b.header.id == id)?.k[at],
            ("BUSHING", "KT") => model.bushings.iter().find(|b| b.header.id == id)?.kt[at],
            ("BUSHING", "FORCE") => model.bushings.iter().find(|b| b.header.id == id)?.force[at],
            (kind @ ("FIELD" | "BEAM"), argument) => {
                let is_it = |f: &&PairForce| f.def.name == kind && f.header.id == id;
                model.pair_forces.iter().find(is_it)?.argument(argument)?[at]
            }
            ("SPLINE", "X") => model.splines.iter().find(|s| s.header.id == id)?.x[at],
            ("SFORCE", "FUNCTION") => {
                match &model.sforces.iter().find(|s| s.header.id == id)?.function {
                    Function::Expression(expression) => expression.literals[at].value,
                    Function::User(_) => return None,
                }
            }
            ("VARIABLE", "FUNCTION") => {
                match &model.variables.iter().find(|s| s.header.id == id)?.function {
                    Function::Expression(expression) => expression.literals[at].value,
                    Function::User(_) => return None,
                }
            }
            _ => return None,
        },
    )
}

const DECK: &str = "deck\r
!\r
!                         adams_view_name='front.bush'\r
BUSHING/7, I=1, J=2, K=1.0E+04, 2000.0,30 ! stiff\r
!  adams_view_name='load'\r
SFORCE/3\r
, I = 1, J = 2\r
, TRANSLATIONAL\r
, FUNCTION = -4000.0\r
SFORCE/4, I=1, J=2, ROT, FUNCTION=2*DX(1,2)+3\\\r
MARKER/9, PART=1, REULER=90D, 0, 45D; MARKER/10, PART=1\r
ACCGRAV/\r
END\r
after";

#[test]
fn a_number_is_spelled_like_the_old_one() {
    for (address, value, new) in [
        ("BUSHING/7.K.1", 2.5e6, "K=2.5E+06, 2000.0,30 !"),
        ("BUSHING/7.K.2", 2100.5, "K=1.0E+04, 2100.5,30 !"),
        ("bush/7.k.3", 31.0, "K=1.0E+04, 2000.0,31 !"),
        ("front.bush.K.3", 31.0, "K=1.0E+04, 2000.0,31 !"),
        ("BUSHING_7.K.3", 31.0, "K=1.0E+04, 2000.0,31 !"),
        (
            "MARKER/9.REULER.1",
            30f64.to_radians(),
            "REULER=30D, 0, 45D",
        ),
        ("MARKER/9.REULER.2", 1.5, "REULER=90D, 1.5, 45D"),
        ("SFORCE/3", 250.0, "FUNCTION = 250.0\r\n"),
        ("load", 250.0, "FUNCTION = 250.0\r\n"),
        ("SFORCE/4.FUNCTION.4", 3.5, "2*DX(1,2)+3.5\\"),
        ("SFORCE/4.FUNCTION.4", -3.5, "2*DX(1,2)+(-3.5)\\"),
        ("SFORCE/4.FUNCTION.1", -1.0, "=(-1)*DX(1,2)+3\\"),
        ("BUSHING/7.KT.2", 5e5, "30, KT=0.0, 500000.0, 0.0 !"),
        ("SFORCE/3.FUNCTION.1", 1.0, "FUNCTION = -1.0\r\n"),
        (
            "ACCGRAV.KGRAV",
            -9806.65,
            "ACCGRAV/\r\n, KGRAV = -9806.65\r\nEND",
        ),
        ("MARKER/10.QP.3", 7.0, "PART=1, QP=0.0, 0.0, 7.0\r\n"),
    ] {
        let after = set(DECK, address, value);
        assert!(after.contains(new), "{address}: {after}");
    }
    let dataset = dataset(DECK).value;
    let inside = Address::parse("SFORCE/4.FUNCTION.1", &dataset).unwrap();
    let id = Address::parse("SFORCE/4.FUNCTION.2", &dataset).unwrap();
    assert!(dataset.set(&id, -1.0).is_err() && dataset.set(&id, 1.5).is_err());
    let marker = Address::parse("BUSHING/7.I", &dataset).unwrap();
    assert!(dataset.set(&marker, 1.5).is_err());
    assert!(dataset.set(&inside, f64::NAN).is_err());
}

/// Checks that a negative number of a function is set in parentheses, and that the parentheses stay when it becomes positive again.
#[test]
fn numbers_of_functions_change_sign_and_back() {
    let negative = shown(DECK, &{
        let dataset = dataset(DECK).value;
        let at = Address::parse("SFORCE/4.FUNCTION.4", &dataset).unwrap();
        dataset.set(&at, -3.0).unwrap()
    });
    assert!(negative.contains("2*DX(1,2)+(-3)\\"), "{negative}");
    let more = set(&negative, "SFORCE/4.FUNCTION.4", -4.5);
    assert!(more.contains("2*DX(1,2)+(-4.5)\\"), "{more}");
    let back = set(&negative, "SFORCE/4.FUNCTION.4", 3.0);
    assert!(back.contains("2*DX(1,2)+(3)\\"), "{back}");
}

#[test]
fn functions_are_replaced_whole() {
    let dataset = dataset(DECK).value;
    let at = |text: &str| Address::parse(text, &dataset).unwrap();
    let edits = dataset
        .set_text(&at("SFORCE/4"), "STEP(TIME,0,0,1,5)")
        .unwrap();
    assert!(shown(DECK, &edits).contains("ROT, FUNCTION=STEP(TIME,0,0,1,5)\\\r\nMARKER"));
    assert_eq!(
        dataset.set_text(&at("SFORCE/4"), "2*DX(1,2)+3").unwrap(),
        []
    );
    assert!(dataset.set_text(&at("SFORCE/4"), "2*DX(1,2").is_err());
    // A backslash ends a function that another argument follows. A function at the end of its statement has none.
    let edits = dataset.set_text(&at("SFORCE/4.ROUTINE"), "lib::f").unwrap();
    assert!(shown(DECK, &edits).contains("+3\\, ROUTINE=lib::f\r\n"));
    let edits = dataset.set_text(&at("SFORCE/3.ROUTINE"), "lib::f").unwrap();
    assert!(shown(DECK, &edits).contains("-4000.0\\\r\n, ROUTINE = lib::f\r\n"));
}

#[test]
fn statements_come_and_go_in_the_style_of_the_file() {
    let dataset = dataset(DECK).value;
    let new = NewStatement {
        kind: "SPRINGDAMPER".into(),
        id: Some(5),
        view_name: Some("spring".into()),
        arguments: vec![
            ("I".into(), Some("1".into())),
            ("TRANSLATIONAL".into(), None),
        ],
    };
    let edits = dataset.add(&new);
    let after = shown(DECK, &edits);
    assert!(
        after.contains("ACCGRAV/\r\n!\r\n!                            adams_view_name='spring'\r\nSPRINGDAMPER/5, I=1, TRANSLATIONAL\r\nEND"),
        "{after}"
    );
    let with = dataset.edited(&edits).unwrap().value;
    let address = Address::parse("spring", &with).unwrap();
    assert_eq!(address.to_string(), "SPRINGDAMPER/5");
    // Removing the added statement restores the original file.
    assert_eq!(shown(&after, &with.remove(&address).unwrap()), DECK);
    let marker = Address::parse("MARKER/10", &dataset).unwrap();
    let left = shown(DECK, &dataset.remove(&marker).unwrap());
    assert!(left.contains("45D; \r\nACCGRAV"), "{left}");
    let bushing = Address::parse("front.bush", &dataset).unwrap();
    let left = shown(DECK, &dataset.remove(&bushing).unwrap());
    assert!(
        left.starts_with("deck\r\n!  adams_view_name='load'"),
        "{left}"
    );
}

#[test]
fn what_is_no_address_is_refused_with_a_suggestion() {
    let dataset = dataset(DECK).value;
    let refused = |text: &str| {
        let diagnostic = Address::parse(text, &dataset).unwrap_err();
        format!(
            "{}: {}; {}",
            diagnostic.code,
            diagnostic.message,
            diagnostic.help.unwrap_or_default()
        )
    };
    assert_eq!(
        refused("BUSHING/8.K.1"),
        "undefined-id: BUSHING/8 is not in this dataset; did you mean BUSHING/7?"
    );
    assert_eq!(
        refused("laod.FUNCTION"),
        "undefined-id: this dataset has no object laod; did you mean LOAD?"
    );
    assert_eq!(
        refused("BUSHING/7.KK"),
        "unknown-argument: BUSHING has no argument KK; did you mean K?"
    );
    assert_eq!(
        refused("BUSHING/7.K.0"),
        "bad-number: 0 is not a valid index; values are counted from 1"
    );
    assert_eq!(
        refused("BEAM/1"),
        "undefined-id: BEAM/1 is not in this dataset; this dataset has no BEAM"
    );
}

/// Checks that edits keep implicit markers on their bodies. A marker without a body argument belongs to the body statement before it.
#[test]
fn a_body_comes_and_goes_without_taking_others_markers() {
    let text = "deck\nPART/1, GROUND\nMARKER/1\nPART/2, MASS=1, CM=20\nMARKER/20\nMARKER/10, PART=1\nMARKER/21\nEND\n";
    let dataset = dataset(text).value;
    let new = NewStatement {
        kind: "PART".into(),
        id: Some(3),
        view_name: None,
        arguments: vec![("MASS".into(), Some("1".into()))],
    };
    let after = shown(text, &dataset.add(&new));
    assert!(after.contains("MARKER/21\nPART/3, MASS=1\nEND"), "{after}");
    let part = Address::parse("PART/2", &dataset).unwrap();
    let refused = dataset.remove(&part).unwrap_err();
    assert_eq!(refused.code, Code::MissingArgument);
    assert!(
        refused.message.starts_with("MARKER/20 "),
        "{}",
        refused.message
    );
}
