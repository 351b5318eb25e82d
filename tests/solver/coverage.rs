//! The column "solved natively" of the coverage table must agree with the solver: every statement with its deck in `corpus/statements`, and
//! every function with a call. Every file with a force law must state the law.

use std::fs;
use std::path::Path;

use admire_solver::function::ExpressionCompiler;
use admire_solver::model::Model;
use admire_solver::system::{Scratch, System};
use admire_syntax::diagnostic::{Diagnostic, Severity};
use admire_syntax::grammar::{FUNCTIONS, FunctionDef, Role, STATEMENTS, Solved, StatementDef};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::{Dataset, Value};

use crate::common::files_below;
use crate::deck::HEAD;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn dataset(bytes: &[u8]) -> Dataset {
    Dataset::parse(Source::new("deck.adm", bytes)).value
}

/// Returns the deck of a statement, and the same deck without the statement.
fn decks(def: &StatementDef) -> Option<(Dataset, Dataset)> {
    // The first line is a title, whatever its content, so no statement can be removed.
    if def.name == "TITLE" {
        return None;
    }
    let name = def.name.to_ascii_lowercase();
    let path = root().join(format!("corpus/statements/{name}.adm"));
    let with = dataset(&fs::read(path).ok()?);
    let edits: Vec<Edit> = with
        .statements()
        .iter()
        .filter(|s| s.kind() == Some(def.name))
        .map(|s| Edit::new(s.span, ""))
        .collect();
    assert!(!edits.is_empty(), "{name}.adm does not hold a {}", def.name);
    let without = dataset(&apply_edits(with.source().bytes(), &edits).unwrap());
    Some((with, without))
}

/// Forces and constraints. They count as solved if they act on parts.
const ACTING: [&str; 15] = [
    "BEAM",
    "BUSHING",
    "COUPLER",
    "FIELD",
    "GCON",
    "GEAR",
    "GFORCE",
    "JOINT",
    "JPRIM",
    "MOTION",
    "NFORCE",
    "SFORCE",
    "SPRINGDAMPER",
    "VFORCE",
    "VTORQUE",
];
/// Data. They count as solved if they are unknowns.
const UNKNOWN: [&str; 4] = ["VARIABLE", "DIFF", "LSE", "TFSISO"];
/// Statements that concern only assembly, kinematics or the file itself, or numbers for other statements (MATRIX, for LSE and NFORCE).
const BESIDE: [&str; 3] = ["END", "IC", "MATRIX"];

fn acts(system: &System, kind: &str) -> bool {
    let (parameters, mut state) = (system.parameters(), system.state());
    // The values of the multipliers are arbitrary, because a reaction of zero is a reaction, too.
    state.multipliers.fill(1.0);
    let mut scratch = Scratch::new(system);
    let mut here = system.evaluate(&parameters, &state, &mut scratch).unwrap();
    let loads = here.loads().unwrap();
    loads
        .iter()
        .any(|l| l.by.as_ref().is_some_and(|n| n.kind == kind))
}

#[test]
fn statements_are_solved_as_the_table_says() {
    let mut seen = [0, 0];
    for def in STATEMENTS.iter().filter(|d| d.role != Role::Command) {
        let Some((with, without)) = decks(def) else {
            continue;
        };
        let (model, bare) = (Model::lower(&with).value, Model::lower(&without).value);
        let (compiled, bare_system) = (System::compile(&model), System::compile(&bare).value);
        let refused = model.unsolved.iter().any(|u| u.kind == def.name);
        let about = |d: &&Diagnostic| {
            d.message.starts_with(def.name) || d.message.contains("flexible body")
        };
        let said = compiled.diagnostics.iter().find(about);
        let told = said.is_some();
        let wrong = said.is_some_and(|d| d.severity == Severity::Error);
        match def.solved {
            Solved::Native(_) => {
                assert!(
                    !refused && !wrong,
                    "{}: {:?}",
                    def.name,
                    compiled.diagnostics
                );
                seen[0] += 1;
                let system = compiled.value;
                if ACTING.contains(&def.name) {
                    assert!(acts(&system, def.name), "{} does not act", def.name);
                } else if UNKNOWN.contains(&def.name) {
                    assert!(system.unknowns() > bare_system.unknowns(), "{}", def.name);
                } else if !BESIDE.contains(&def.name) {
                    assert!(model != bare, "{} makes no difference", def.name);
                }
            }
            Solved::External(_) | Solved::Subroutine(_) => {
                seen[1] += 1;
                // A statement that acts must be refused or reported. A statement that only affects output or graphics is listed.
                assert!(refused || told, "{} is passed over in silence", def.name);
            }
            Solved::NoEffect(_) => {
                assert!(!ACTING.contains(&def.name) && !UNKNOWN.contains(&def.name));
                assert_eq!(
                    compiled.value.unknowns(),
                    bare_system.unknowns(),
                    "{} has an effect",
                    def.name
                );
            }
        }
    }
    println!("{} native, {} external statements", seen[0], seen[1]);
    assert!(seen[0] >= 25 && seen[1] >= 10, "{seen:?}");
    for kind in ACTING.iter().chain(&UNKNOWN) {
        let def = STATEMENTS.iter().find(|d| d.name == *kind).unwrap();
        assert!(matches!(def.solved, Solved::Native(_)), "{kind}");
    }
}

/// Returns a call with arguments that match their names.
fn call(def: &FunctionDef) -> String {
    if def.name == "IF" {
        return "IF(1: 2, 3, 4)".to_string();
    }
    if def.count.max == Some(0) {
        return def.name.to_string();
    }
    let names = def
        .arguments
        .split([',', '[', ']'])
        .filter(|n| !n.is_empty());
    let arguments: Vec<String> = names
        .enumerate()
        .map(|(k, name)| match name {
            "i" | "marker" => "20".to_string(),
            "j" | "k" | "l" | "rm" => "10".to_string(),
            "id" | "method" | "component" => "1".to_string(),
            "comp" | "index" => "2".to_string(),
            "jflag" | "iord" => "0".to_string(),
            "type" => "27".to_string(),
            _ => format!("{}", 0.5 * (k + 1) as f64),
        })
        .collect();
    let count = arguments.len().max(def.count.min);
    format!(
        "{}({})",
        def.name,
        arguments[..count.min(arguments.len())].join(",")
    )
}

#[test]
fn functions_are_evaluated_as_the_grammar_says() {
    let every = "MARKER/10, PART=1\nPART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\nMARKER/11, PART=1, FLOATING\n\
        BEAM/1, I=20, J=10, LENGTH=1, AREA=1, IXX=1, IYY=1, IZZ=1, EMODULUS=1, GMODULUS=1\n\
        BUSHING/1, I=20, J=10\nFIELD/1, I=20, J=10, LENGTH=0,0,0,0,0,0, KMATRIX=1,0,0,0,0,0,0,1,0,0,0,0,0,0,1,0,0,0\n, 0,0,0,1,0,0,0,0,0,0,1,0,0,0,0,0,0,1\n\
        SPRINGDAMPER/1, I=20, J=10, ROTATIONAL, KT=1\nSFORCE/1, I=20, J=10, ROTATIONAL, FUNCTION=1\n\
        GFORCE/1, I=20, JFLOAT=11, RM=10, FX=1\nVFORCE/1, I=20, JFLOAT=11, RM=10, FX=1\nVTORQUE/1, I=20, JFLOAT=11, RM=10, TX=1\n\
        MATRIX/1, FULL=RORDER, ROWS=6, COLUMNS=6, VALUES=1,0,0,0,0,0,0,1,0,0,0,0,0,0,1,0,0,0\n, 0,0,0,1,0,0,0,0,0,0,1,0,0,0,0,0,0,1\n\
        NFORCE/1, I=20, J=10, KMATRIX=1\nJOINT/1, REVOLUTE, I=20, J=10\nJPRIM/1, INPLANE, I=20, J=10\nMOTION/1, JOINT=1, FUNCTION=0\n\
        FRICTION/1, JOINT=1, MU_STATIC=0.3, MU_DYNAMIC=0.2\n\
        SPLINE/1, X=0,1,2,3, Y=0,1,4,9\nVARIABLE/1, FUNCTION=1\nARRAY/1, IC, SIZE=1, NUMBERS=4\nDIFF/1, FUNCTION=-DIF(1)\n\
        PINPUT/1, VARIABLES=1\nPOUTPUT/1, VARIABLES=1\nSENSOR/1, GE, VALUE=1, ERROR=0.1, FUNCTION=TIME\n";
    let mut seen = [0, 0];
    for def in FUNCTIONS {
        if matches!(def.name, "USER") {
            continue;
        }
        let call = call(def);
        let text = format!("{HEAD}{every}VARIABLE/99, FUNCTION={call}\nEND\n");
        let dataset = dataset(text.as_bytes());
        let statement = dataset.statement("VARIABLE", Some(99)).unwrap();
        let Some(Value::Function(expression)) = statement.argument("FUNCTION").map(|a| &a.value)
        else {
            panic!("{call} is not read");
        };
        let model = Model::lower(&dataset).value;
        let compiled = ExpressionCompiler::new(&model).compile(expression);
        match def.solved {
            Solved::Native(_) => {
                assert!(compiled.is_ok(), "{call}: {:?}", compiled.err());
                seen[0] += 1;
            }
            Solved::NoEffect(_) | Solved::External(_) | Solved::Subroutine(_) => {
                let refusal = compiled.expect_err(def.name);
                assert!(refusal.message.contains(def.name), "{}", refusal.message);
                seen[1] += 1;
            }
        }
    }
    println!("{} native, {} external functions", seen[0], seen[1]);
    assert!(seen[0] > 90 && seen[1] > 20, "{seen:?}");
}

/// Checks that the file of each law and constraint states the law or its equations, the frame, the range of validity, and the source.
#[test]
fn every_element_file_states_its_law() {
    let mut checked = 0;
    for folder in ["src/solver/element", "src/solver/constraint"] {
        for path in files_below(&root().join(folder), "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let law = text.contains("\nimpl Law for ") || text.contains("\nimpl Constraint for ");
            // Files that only select a law have no law of their own.
            let registry = ["pair_constraint.rs", "registry.rs"];
            if !law || registry.iter().any(|name| path.ends_with(name)) {
                continue;
            }
            let docs: String = text
                .lines()
                .filter(|line| line.trim_start().starts_with("//"))
                .collect::<Vec<_>>()
                .join("\n");
            let name = path.display();
            assert!(
                docs.contains('=') && docs.contains('`'),
                "{name}: no formula"
            );
            for (what, words) in [
                ("frame", &["axes", "axis of J", "zj"][..]),
                (
                    "validity",
                    &["Valid", "valid", "Undefined", "undefined", "Exact for"][..],
                ),
                ("source", &["Source: "][..]),
            ] {
                let found = words.iter().any(|word| docs.contains(word));
                assert!(found, "{name} does not state its {what}");
            }
            checked += 1;
        }
    }
    println!("{checked} files");
    assert!(checked >= 10);
}
