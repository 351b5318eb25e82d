use super::{Function, Header, MarkerIx};
use admire_syntax::Expression;
use admire_syntax::diagnostic::Diagnostic;

/// VARIABLE: v = e, possibly implicit.
#[derive(Clone, PartialEq, Debug)]
pub struct Variable {
    /// Id, name, origin.
    pub header: Header,
    /// IC: the starting guess.
    pub ic: f64,
    /// FUNCTION.
    pub function: Function,
}

/// DIFF.
#[derive(Clone, PartialEq, Debug)]
pub struct Diff {
    /// Id, name, origin.
    pub header: Header,
    /// IC.
    pub ic: f64,
    /// IMPLICIT: the function itself is zero.
    pub implicit: bool,
    /// STATIC_HOLD: the state keeps its value in statics.
    pub static_hold: bool,
    /// DYNAMIC_HOLD: the state keeps its value in motion.
    pub dynamic_hold: bool,
    /// FUNCTION.
    pub function: Function,
}

/// LSE, GSE or TFSISO, as linear state equations x' = A x + B u, y = C x + D u.
#[derive(Clone, PartialEq, Debug)]
pub struct LinearStates {
    /// Id, name, origin.
    pub header: Header,
    /// Which statement it was: `LSE`, `GSE` or `TFSISO`.
    pub kind: &'static str,
    /// Ids of the X, U and Y arrays.
    pub x: u32,
    /// U array.
    pub u: u32,
    /// Y array.
    pub y: Option<u32>,
    /// IC array: the states at the start, kept by STATIC_HOLD. Zeros if absent.
    pub ic: Option<u32>,
    /// A, row by row.
    pub a: Vec<Vec<f64>>,
    /// B, row by row.
    pub b: Vec<Vec<f64>>,
    /// C, row by row.
    pub c: Vec<Vec<f64>>,
    /// D, row by row.
    pub d: Vec<Vec<f64>>,
    /// STATIC_HOLD.
    pub static_hold: bool,
}

/// What an ARRAY holds.
#[derive(Clone, PartialEq, Debug)]
pub enum ArrayKind {
    /// NUMBERS (IC arrays).
    Numbers(Vec<f64>),
    /// U: ids of variables.
    Variables(Vec<u32>),
    /// X: states of the given size.
    States(usize),
    /// Y: outputs of the given size.
    Outputs(usize),
}

/// ARRAY.
#[derive(Clone, PartialEq, Debug)]
pub struct ArrayData {
    /// Id, name, origin.
    pub header: Header,
    /// What it holds.
    pub kind: ArrayKind,
}

/// SPLINE: a curve (one row) or a surface (one row per z).
#[derive(Clone, PartialEq, Debug)]
pub struct Spline {
    /// Id, name, origin.
    pub header: Header,
    /// X values.
    pub x: Vec<f64>,
    /// z of each row; one zero for a curve.
    pub z: Vec<f64>,
    /// y values, one row per z.
    pub y: Vec<Vec<f64>>,
    /// LINEAR_EXTRAPOLATE.
    pub linear_extrapolate: bool,
}

/// STRING.
#[derive(Clone, PartialEq, Debug)]
pub struct StringData {
    /// Id, name, origin.
    pub header: Header,
    /// Its text.
    pub text: String,
}

/// The comparison of a SENSOR.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub enum SensorCompare {
    Eq,
    Ge,
    Le,
}

/// SENSOR.
#[derive(Clone, PartialEq, Debug)]
pub struct Sensor {
    /// Id, name, origin.
    pub header: Header,
    /// Comparison.
    pub compare: SensorCompare,
    /// VALUE.
    pub value: f64,
    /// ERROR.
    pub error: f64,
    /// FUNCTION.
    pub function: Function,
    /// EVALUATE: what SENVAL gives after it fired.
    pub evaluate: Option<Function>,
    /// HALT or RETURN: the simulation ends when it fires.
    pub stops: bool,
    /// HALT: the whole command file ends.
    pub halts: bool,
    /// DT: time between output steps once it fired.
    pub dt: Option<f64>,
    /// STEPSIZE: the integration step after it fired.
    pub stepsize: Option<f64>,
    /// PRINT: an output step where it fired.
    pub prints: bool,
    /// What it also asks for, which only ADAMS does: CODGEN, YYDUMP.
    pub without_effect: Vec<&'static str>,
}

impl Sensor {
    /// True if the event is there: the function equals VALUE within ERROR, or is beyond it (GE, LE).
    pub fn fires(&self, value: f64) -> bool {
        let beyond = value - self.value;
        match self.compare {
            SensorCompare::Eq => beyond.abs() <= self.error,
            SensorCompare::Ge => beyond >= -self.error,
            SensorCompare::Le => beyond <= self.error,
        }
    }
}

/// PINPUT, POUTPUT or PSTATE: variables a plant is driven by, that are read of it, or that its states are.
#[derive(Clone, PartialEq, Debug)]
pub struct PlantPort {
    /// Id, name, origin.
    pub header: Header,
    /// Which statement it was: `PINPUT`, `POUTPUT` or `PSTATE`.
    pub kind: &'static str,
    /// Ids of VARIABLEs.
    pub variables: Vec<u32>,
}

/// What a REQUEST asks for. I, J and RM are the statement's markers.
#[derive(Clone, PartialEq, Debug)]
#[allow(missing_docs)] // The fields are the manual's.
pub enum RequestKind {
    /// DISPLACEMENT of I from J in RM axes.
    Displacement {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// VELOCITY: zero in statics.
    Velocity {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// ACCELERATION: zero in statics.
    Acceleration {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// FORCE on I by what acts between I and J, in RM axes.
    Force {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// F1 to F8.
    Functions(Box<[Option<Function>; 8]>),
    /// FUNCTION=USER(...).
    User(String),
}

/// REQUEST.
#[derive(Clone, PartialEq, Debug)]
pub struct Request {
    /// Id, name, origin.
    pub header: Header,
    /// What it asks for.
    pub kind: RequestKind,
    /// COMMENT.
    pub comment: String,
    /// CNAMES or TITLE; empty strings suppress a component.
    pub component_names: Option<Vec<String>>,
    /// CUNITS.
    pub component_units: Vec<String>,
    /// RESULTS_NAME.
    pub results_name: Option<String>,
}

impl Request {
    /// A request that no deck has: its component 2 evaluates the text of a function.
    ///
    /// # Errors
    /// When the text is no expression.
    pub fn of_function(name: &str, function: &str) -> Result<Self, Diagnostic> {
        let mut functions: [Option<Function>; 8] = Default::default();
        let expression = Expression::parse_str(function)?;
        functions[1] = Some(Function::Expression(expression.into()));
        Ok(Self {
            header: Header {
                id: 0,
                name: name.to_string(),
                origin: usize::MAX,
                active: true,
            },
            kind: RequestKind::Functions(Box::new(functions)),
            comment: String::new(),
            component_names: None,
            component_units: Vec::new(),
            results_name: None,
        })
    }
}
