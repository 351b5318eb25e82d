//! Conversion of a dataset to other units.

use super::Model;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::expression::Node;
use admire_syntax::grammar::{ArgumentDef, FunctionDef, Solved, ValueKind};
use admire_syntax::text::{Edit, Span};
use admire_syntax::units::{Dimension, Unit, Units};
use admire_syntax::{Address, Argument, Dataset, Expression, Number, Statement, Value, spell_like};

/// Returns the edits that convert a dataset to other units.
///
/// Numbers with a dimension are scaled. The literals inside functions stay: the quantities that a function measures are converted back to
/// the old units, and its result is scaled. Variables, splines and arrays stay unchanged, because functions use them. The diagnostics are
/// warnings about tolerances that stay unchanged because they apply to lengths and angles alike.
///
/// # Errors
/// Returns a diagnostic, with its position, for every statement and function that cannot be converted.
pub fn convert_units(
    dataset: &Dataset,
    model: &Model,
    new: [Unit; 4],
) -> Result<Checked<Vec<Edit>>, Vec<Diagnostic>> {
    let mut conversion = Conversion {
        dataset,
        model,
        old: model.units,
        new,
        edits: Vec::new(),
        stays: Vec::new(),
        refused: Vec::new(),
    };
    conversion.units();
    for statement in dataset.statements() {
        conversion.statement(statement);
    }
    if conversion.refused.is_empty() {
        Ok(Checked {
            value: conversion.edits,
            diagnostics: conversion.stays,
        })
    } else {
        Err(conversion.refused)
    }
}

const VELOCITY: Dimension = Dimension::new(0, 0, 1, -1, 0);
const ACCELERATION: Dimension = Dimension::new(0, 0, 1, -2, 0);
const RATE: Dimension = Dimension::new(0, 0, 0, -1, 0);
const RATE2: Dimension = Dimension::new(0, 0, 0, -2, 0);

struct Conversion<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
    old: Units,
    new: [Unit; 4],
    edits: Vec<Edit>,
    /// Warnings about numbers that stay unchanged although they depend on units.
    stays: Vec<Diagnostic>,
    refused: Vec<Diagnostic>,
}

impl Conversion<'_> {
    /// Returns the factor that converts a quantity of this dimension from the old units to the new ones.
    fn factor(&self, dimension: Dimension) -> f64 {
        let [force, mass, length, time] = self.new;
        (self.old.force.si / force.si).powi(i32::from(dimension.force))
            * (self.old.mass.si / mass.si).powi(i32::from(dimension.mass))
            * (self.old.length.si / length.si).powi(i32::from(dimension.length))
            * (self.old.time.si / time.si).powi(i32::from(dimension.time))
    }

    fn refuse(&mut self, span: Span, message: String) {
        self.refused
            .push(Diagnostic::error(Code::WrongUnits, message).label(
                self.dataset.source().name(),
                span,
                "",
            ));
    }

    fn title(&self, statement: &Statement) -> String {
        Address::of(statement).map_or_else(String::new, |address| address.to_string())
    }

    /// Converts the UNITS statement itself.
    fn units(&mut self) {
        let dataset = self.dataset;
        let Some(units) = dataset.statement("UNITS", None) else {
            let span = dataset.title_span();
            self.refuse(
                span,
                "the dataset has no UNITS statement, so its units cannot be converted".to_string(),
            );
            return;
        };
        if units.has("SYSTEM") || units.has("UCF") {
            let span = units.span;
            let message = "UNITS with SYSTEM or UCF is not converted: use FORCE, MASS, LENGTH and TIME instead";
            self.refuse(span, message.to_string());
            return;
        }
        let words = ["FORCE", "MASS", "LENGTH", "TIME"];
        let old = [
            self.old.force,
            self.old.mass,
            self.old.length,
            self.old.time,
        ];
        for ((word, unit), old) in words.into_iter().zip(self.new).zip(old) {
            if let Some(argument) = units.argument(word).filter(|_| unit != old) {
                self.edits
                    .push(Edit::new(argument.value_span(), unit.keyword));
            }
        }
    }

    fn statement(&mut self, statement: &Statement) {
        let Some(kind) = statement.kind() else { return };
        let refused = match kind {
            "FLEX_BODY" | "FE_PART" | "FE_NODE" | "FE_LOAD" | "TIRE" | "MFORCE" | "NFORCE"
            | "CONTACT" | "CURVE" | "SURFACE" | "PTCV" | "CVCV" | "SECTION" => true,
            "SPLINE" => statement.has("FILE"),
            "COUPLER" => self.is_mixed(statement),
            // The coefficients of these statements depend on the unit of time.
            "DIFF" | "LSE" | "GSE" | "TFSISO" => self.factor(Dimension::TIME) != 1.0,
            _ => false,
        };
        if refused {
            let message = format!(
                "{} is not converted: the units of its values are unknown",
                self.title(statement)
            );
            self.refuse(statement.keyword, message);
            return;
        }
        if kind == "UNITS" {
            return;
        }
        self.tolerances(statement, kind);
        if kind == "FRICTION" {
            self.defaults_of_friction(statement);
        }
        for argument in &statement.arguments {
            let Some(def) = argument.def else { continue };
            match &argument.value {
                Value::Numbers(numbers) if def.kind == ValueKind::Real => {
                    for (k, number) in numbers.iter().enumerate() {
                        let dimension = self.dimension(statement, def, k);
                        self.scale(number, dimension);
                    }
                }
                Value::Function(expression) if kind != "REQUEST" => {
                    self.function(statement, argument, expression);
                }
                Value::User(span) => {
                    let message = format!(
                        "{} is not converted: the meaning of its USER parameters is unknown",
                        self.title(statement)
                    );
                    self.refuse(*span, message);
                }
                _ => {}
            }
        }
    }

    /// Warns about tolerances whose values stay unchanged although the units change.
    fn tolerances(&mut self, statement: &Statement, kind: &str) {
        let names = match kind {
            "IC" | "KINEMATICS" => &["AERROR", "ERROR", "VERROR"][..],
            "INTEGRATOR" => &["ERROR", "MAXERR"],
            "EQUILIBRIUM" => &["ATOL", "GLOBAL_DAMPING"],
            _ => return,
        };
        if self.factor(Dimension::LENGTH) == 1.0 && self.factor(Dimension::TIME) == 1.0 {
            return;
        }
        for argument in names.iter().filter_map(|name| statement.argument(name)) {
            let name = argument.kind().unwrap_or_default();
            let message =
                format!("{name} of {kind} keeps its value: it applies to lengths and angles alike");
            let file = self.dataset.source().name();
            self.stays.push(
                Diagnostic::warning(Code::WrongUnits, message)
                    .label(file, argument.value_span(), "")
                    .help("choose a value that suits the new units"),
            );
        }
    }

    /// Adds to a FRICTION statement the default values that depend on the units, converted to the new units.
    fn defaults_of_friction(&mut self, statement: &Statement) {
        let joint = statement.first("JOINT").map(|id| id as u32);
        let joint = joint.and_then(|id| self.dataset.statement("JOINT", Some(id)));
        let Some((def, joint)) = statement.def.zip(joint) else {
            return;
        };
        // Arguments that belong to each joint type: `state_friction`.
        let of_pins = &["PIN_RADIUS", "FRICTION_ARM", "BENDING_REACTION_ARM"][..];
        let own = [
            ("SPHERICAL", &["BALL_RADIUS"][..]),
            ("REVOLUTE", of_pins),
            ("HOOKE", of_pins),
            ("UNIVERSAL", of_pins),
            ("CYLINDRICAL", &["PIN_RADIUS", "INITIAL_OVERLAP"]),
            ("TRANSLATIONAL", &["REACTION_ARM", "INITIAL_OVERLAP"]),
        ];
        let own = own.iter().filter(|(kind, _)| joint.has(kind));
        let all = ["STICTION_TRANSITION_VELOCITY", "MAX_STICTION_DEFORMATION"];
        for name in own.flat_map(|(_, names)| names.iter()).chain(&all) {
            let Some(argument) = def.argument(name).filter(|_| !statement.has(name)) else {
                continue;
            };
            let factor = self.factor(argument.dimension);
            let (Some(default), Some(mut address)) =
                (argument.default.first(), Address::of(statement))
            else {
                continue;
            };
            address.argument = Some((*name).to_string());
            if factor != 1.0
                && let Ok(edits) = self.dataset.set(&address, rounded(default * factor))
            {
                self.edits.extend(edits);
            }
        }
    }

    /// Returns the dimension of the number at index `at` of an argument. Some arguments mix dimensions within one list.
    fn dimension(&self, statement: &Statement, def: &ArgumentDef, at: usize) -> Dimension {
        let angular = |k: usize| k % 6 >= 3;
        let of_wrench = |torque| {
            if torque {
                Dimension::TORQUE
            } else {
                Dimension::FORCE
            }
        };
        let rate = |at: usize| i8::from(at > 0);
        let per = |a: Dimension, length: i8, time: i8| Dimension {
            length: a.length + length,
            time: a.time + time,
            ..a
        };
        match (statement.kind(), def.name) {
            (Some("FIELD"), "FORCE") => of_wrench(angular(at)),
            (Some("FIELD"), "LENGTH") if !angular(at) => Dimension::LENGTH,
            // The row determines force or torque; the column determines whether it is per length or per angle.
            (Some("FIELD"), "KMATRIX") => per(
                of_wrench(angular(at % 6)),
                if at / 6 < 3 { -1 } else { 0 },
                0,
            ),
            (Some("FIELD"), "CMATRIX") => per(
                of_wrench(angular(at % 6)),
                if at / 6 < 3 { -1 } else { 0 },
                1,
            ),
            (Some("BEAM"), "CMATRIX") => {
                // Upper half by columns: entry k is in column c, row k - c (c + 1) / 2.
                let column = (0..6).find(|c| at < (c + 1) * (c + 2) / 2).unwrap_or(5);
                let row = at - column * (column + 1) / 2;
                per(of_wrench(row >= 3), if column < 3 { -1 } else { 0 }, 1)
            }
            // A displacement followed by its rate.
            (Some("JOINT"), "IC") => {
                Dimension::new(0, 0, i8::from(statement.has("TRANSLATIONAL")), -rate(at), 0)
            }
            (Some("JOINT"), "ICTRAN") => Dimension::new(0, 0, 1, -rate(at), 0),
            (Some("JOINT"), "ICROT") => Dimension::new(0, 0, 0, -rate(at), 0),
            (Some("MOTION"), "ICDISP") => self.of_motion(statement, 0),
            (Some("MOTION"), "ICVEL") => self.of_motion(statement, 1),
            _ => def.dimension,
        }
    }

    fn scale(&mut self, number: &Number, dimension: Dimension) {
        let factor = self.factor(dimension);
        if factor != 1.0 && number.value != 0.0 {
            let old = self.dataset.source().slice(number.span);
            let new = spell_like(rounded(number.value * factor), old);
            self.edits.push(Edit::new(number.span, new));
        }
    }

    /// Returns the dimension of the result of a FUNCTION argument.
    fn yielded(&self, statement: &Statement, argument: &Argument) -> Dimension {
        match (statement.kind(), argument.kind()) {
            (Some("SFORCE"), _) if statement.has("ROTATIONAL") => Dimension::TORQUE,
            (Some("SFORCE" | "VFORCE"), _) | (Some("GFORCE"), Some("FX" | "FY" | "FZ")) => {
                Dimension::FORCE
            }
            (Some("VTORQUE" | "GFORCE"), _) => Dimension::TORQUE,
            (Some("MOTION"), _) => {
                let order = i8::from(statement.has("VELOCITY"))
                    + 2 * i8::from(statement.has("ACCELERATION"));
                self.of_motion(statement, order)
            }
            _ => Dimension::NONE,
        }
    }

    /// Returns the dimension of a motion's displacement, or of its first or second time derivative.
    fn of_motion(&self, motion: &Statement, order: i8) -> Dimension {
        let joint = motion.numbers("JOINT").first().map(|id| id.value as u32);
        let joint = joint.and_then(|id| self.dataset.statement("JOINT", Some(id)));
        let along = ["TRANSLATIONAL", "X", "Y", "Z"]
            .iter()
            .any(|word| motion.has(word))
            || !["ROTATIONAL", "B1", "B2", "B3"]
                .iter()
                .any(|word| motion.has(word))
                && joint.is_some_and(|joint| joint.has("TRANSLATIONAL"));
        Dimension::new(0, 0, i8::from(along), -order, 0)
    }

    fn function(&mut self, statement: &Statement, argument: &Argument, expression: &Expression) {
        let factor = self.factor(self.yielded(statement, argument));
        let lone = Address::of(statement).and_then(|mut address| {
            address.argument = argument.kind().map(str::to_string);
            self.dataset.number_at(&address)
        });
        if let Some(number) = lone {
            if factor != 1.0 && number.value != 0.0 {
                let text = format!("{}", rounded(number.value * factor));
                self.edits.push(Edit::new(expression.span, text));
            }
            return;
        }
        let reads_time = |node: &Node| matches!(node, Node::Name(name) if name.name == "TIME");
        if self.factor(Dimension::TIME) != 1.0 && expression.root.walk().any(reads_time) {
            let message = format!(
                "{} reads TIME and is not converted to another time unit",
                self.title(statement)
            );
            self.refuse(expression.span, message);
            return;
        }
        for node in expression.root.walk() {
            if let Node::Call {
                function,
                arguments,
                span,
            } = node
            {
                match measured(function, arguments, expression) {
                    Ok(dimension) => {
                        let back = 1.0 / self.factor(dimension);
                        if back != 1.0 {
                            self.edits.push(Edit::new(Span::at(span.start()), "("));
                            self.edits.push(Edit::new(
                                Span::at(span.end()),
                                format!("*{})", rounded(back)),
                            ));
                        }
                    }
                    Err(why) => {
                        let message = format!("{} is not converted: {why}", self.title(statement));
                        self.refuse(*span, message);
                    }
                }
            }
        }
        if factor != 1.0 {
            let span = expression.span;
            self.edits.push(Edit::new(
                Span::at(span.start()),
                format!("{}*(", rounded(factor)),
            ));
            self.edits.push(Edit::new(Span::at(span.end()), ")"));
        }
    }

    /// Returns whether a COUPLER mixes translations and rotations. A change of the length unit cannot be applied to such a COUPLER, because
    /// only the ratio of its scales has a unit.
    fn is_mixed(&self, coupler: &Statement) -> bool {
        let translate: Vec<bool> = coupler
            .numbers("JOINTS")
            .iter()
            .filter_map(|id| self.dataset.statement("JOINT", Some(id.value as u32)))
            .map(|joint| joint.has("TRANSLATIONAL"))
            .collect();
        let cylindrical = coupler.numbers("JOINTS").iter().any(|id| {
            let joint = self.dataset.statement("JOINT", Some(id.value as u32));
            joint.is_some_and(|joint| joint.has("CYLINDRICAL"))
        });
        let mixed = translate.iter().any(|t| *t) && translate.iter().any(|t| !*t);
        (mixed || cylindrical)
            && self.factor(Dimension::LENGTH) != 1.0
            && !self.model.couplers.is_empty()
    }
}

/// Returns the dimension of the quantity that a function call measures. Returns `NONE` for purely arithmetic functions.
fn measured(
    function: &FunctionDef,
    arguments: &[Node],
    expression: &Expression,
) -> Result<Dimension, String> {
    Ok(match function.name {
        "DX" | "DY" | "DZ" | "DM" => Dimension::LENGTH,
        "VX" | "VY" | "VZ" | "VM" | "VR" => VELOCITY,
        "ACCX" | "ACCY" | "ACCZ" | "ACCM" => ACCELERATION,
        "WX" | "WY" | "WZ" | "WM" => RATE,
        "WDTX" | "WDTY" | "WDTZ" | "WDTM" => RATE2,
        "AX" | "AY" | "AZ" | "PSI" | "THETA" | "PHI" | "YAW" | "PITCH" | "ROLL" | "INCANG" => {
            Dimension::NONE
        }
        "FX" | "FY" | "FZ" | "FM" => Dimension::FORCE,
        "TX" | "TY" | "TZ" | "TM" => Dimension::TORQUE,
        "BEAM" | "BUSH" | "FIELD" | "SFORCE" | "VFORCE" | "JPRIM" | "GFORCE" | "VTORQ"
        | "NFORCE" | "JOINT" | "MOTION" | "SPDP" => match arguments.get(2) {
            Some(Node::Literal(at)) if expression.literals[*at].value <= 4.0 => Dimension::FORCE,
            Some(Node::Literal(_)) => Dimension::TORQUE,
            _ => {
                return Err(format!(
                    "the component in {} is not written as a number",
                    function.name
                ));
            }
        },
        name => match function.solved {
            Solved::Native("measure" | "force measure")
            | Solved::External(_)
            | Solved::Subroutine(_) => {
                return Err(format!("the dimension of {name} is unknown"));
            }
            _ => Dimension::NONE,
        },
    })
}

/// Rounds to fifteen significant digits, because unit factors are not exact in binary.
fn rounded(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}
