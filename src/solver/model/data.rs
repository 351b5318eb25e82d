use super::{Function, Header, MarkerIx};
use admire_syntax::Expression;
use admire_syntax::diagnostic::Diagnostic;

/// VARIABLE statement: an algebraic variable that equals its FUNCTION. The FUNCTION may depend on the variable itself (implicit equation).
#[derive(Clone, PartialEq, Debug)]
pub struct Variable {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Initial guess, IC.
    pub ic: f64,
    /// FUNCTION: the value of the variable.
    pub function: Function,
}

/// DIFF statement: a first-order differential equation.
#[derive(Clone, PartialEq, Debug)]
pub struct Diff {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Initial value of the state, IC.
    pub ic: f64,
    /// IMPLICIT: the equation is FUNCTION = 0.
    pub implicit: bool,
    /// STATIC_HOLD: the state is constant in statics.
    pub static_hold: bool,
    /// DYNAMIC_HOLD: the state is constant in dynamics.
    pub dynamic_hold: bool,
    /// FUNCTION: the time derivative of the state, or the implicit equation.
    pub function: Function,
}

/// LSE or TFSISO statement, as linear state equations x' = A x + B u, y = C x + D u.
#[derive(Clone, PartialEq, Debug)]
pub struct LinearStates {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Statement kind: `LSE` or `TFSISO`.
    pub kind: &'static str,
    /// Id of the X array (states).
    pub x: u32,
    /// Id of the U array (inputs).
    pub u: u32,
    /// Id of the Y array (outputs).
    pub y: Option<u32>,
    /// Id of the IC array with the initial values of the states; zeros if absent. With STATIC_HOLD, the states keep these values in
    /// statics.
    pub ic: Option<u32>,
    /// Matrix A, row by row.
    pub a: Vec<Vec<f64>>,
    /// Matrix B, row by row.
    pub b: Vec<Vec<f64>>,
    /// Matrix C, row by row.
    pub c: Vec<Vec<f64>>,
    /// Matrix D, row by row.
    pub d: Vec<Vec<f64>>,
    /// STATIC_HOLD: the states are constant in statics.
    pub static_hold: bool,
}

/// Content of an ARRAY.
#[derive(Clone, PartialEq, Debug)]
pub enum ArrayKind {
    /// NUMBERS: plain values, for example initial conditions (IC).
    Numbers(Vec<f64>),
    /// U array: ids of the VARIABLEs that are inputs.
    Variables(Vec<u32>),
    /// X array: number of states.
    States(usize),
    /// Y array: number of outputs.
    Outputs(usize),
}

/// ARRAY statement.
#[derive(Clone, PartialEq, Debug)]
pub struct ArrayData {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Content of the array.
    pub kind: ArrayKind,
}

/// SPLINE: a curve (one row of y values) or a surface (one row per z).
#[derive(Clone, PartialEq, Debug)]
pub struct Spline {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// x values of the points.
    pub x: Vec<f64>,
    /// z value of each row of `y`; a single zero for a curve.
    pub z: Vec<f64>,
    /// y values, one row per z value.
    pub y: Vec<Vec<f64>>,
    /// Whether the spline is extrapolated linearly, LINEAR_EXTRAPOLATE.
    pub linear_extrapolate: bool,
    /// True if the points come from a property file (argument FILE), false if they come from the statement.
    pub is_of_file: bool,
}

impl Spline {
    /// Returns whether the spline is a surface: it has more than one row of y values.
    pub(crate) fn is_surface(&self) -> bool {
        self.y.len() > 1
    }
}

/// STRING statement.
#[derive(Clone, PartialEq, Debug)]
pub struct StringData {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Text of the string.
    pub text: String,
}

/// Comparison of a SENSOR's function with VALUE.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum SensorCompare {
    Eq,
    Ge,
    Le,
}

/// SENSOR statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Sensor {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Comparison of the function with VALUE.
    pub compare: SensorCompare,
    /// Threshold, VALUE.
    pub value: f64,
    /// Tolerance of the comparison, ERROR.
    pub error: f64,
    /// Monitored function, FUNCTION.
    pub function: Function,
    /// EVALUATE: function whose value SENVAL returns after the sensor has triggered.
    pub evaluate: Option<Function>,
    /// HALT or RETURN: the simulation ends when the sensor triggers.
    pub stops: bool,
    /// HALT: the whole command file ends when the sensor triggers.
    pub halts: bool,
    /// DT: time between output steps after the sensor has triggered.
    pub dt: Option<f64>,
    /// STEPSIZE: integration step after the sensor has triggered.
    pub stepsize: Option<f64>,
    /// PRINT: an output step is added where the sensor triggers.
    pub prints: bool,
    /// Actions in the statement that only ADAMS performs, such as CODGEN and YYDUMP. They have no effect here.
    pub without_effect: Vec<&'static str>,
}

impl Sensor {
    /// Returns whether the sensor triggers at a function value. For EQ, the value must equal VALUE within ERROR. For GE and LE, the value
    /// must lie on the stated side of VALUE, with a tolerance of ERROR.
    pub fn fires(&self, value: f64) -> bool {
        let beyond = value - self.value;
        match self.compare {
            SensorCompare::Eq => beyond.abs() <= self.error,
            SensorCompare::Ge => beyond >= -self.error,
            SensorCompare::Le => beyond <= self.error,
        }
    }
}

/// PINPUT, POUTPUT or PSTATE: list of the variables that are inputs, outputs or states of a plant.
#[derive(Clone, PartialEq, Debug)]
pub struct PlantPort {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Statement kind: `PINPUT`, `POUTPUT` or `PSTATE`.
    pub kind: &'static str,
    /// Ids of the VARIABLEs in the list.
    pub variables: Vec<u32>,
}

/// Quantity that a REQUEST reports. I, J and RM are the markers of the statement.
#[derive(Clone, PartialEq, Debug)]
#[allow(missing_docs)] // The fields are those of the manual.
pub enum RequestKind {
    /// DISPLACEMENT: displacement of I relative to J, in RM axes.
    Displacement {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// VELOCITY: velocity of I relative to J, in RM axes; zero in statics.
    Velocity {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// ACCELERATION: acceleration of I relative to J, in RM axes; zero in statics.
    Acceleration {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// FORCE: force on I exerted by the elements between I and J, in RM axes.
    Force {
        i: MarkerIx,
        j: Option<MarkerIx>,
        rm: Option<MarkerIx>,
    },
    /// F1 to F8: functions of the components.
    Functions(Box<[Option<Function>; 8]>),
    /// FUNCTION=USER(...): a user subroutine, with its text as written.
    User(String),
}

/// REQUEST statement.
#[derive(Clone, PartialEq, Debug)]
pub struct Request {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Reported quantity.
    pub kind: RequestKind,
    /// Comment text, COMMENT.
    pub comment: String,
    /// Component names, CNAMES or TITLE. An empty string suppresses a component.
    pub component_names: Option<Vec<String>>,
    /// Component units, CUNITS.
    pub component_units: Vec<String>,
    /// Name in the results file, RESULTS_NAME.
    pub results_name: Option<String>,
}

impl Request {
    /// Creates a request that is not part of a deck. Its component 2 evaluates the function given as text.
    ///
    /// # Errors
    /// Returns an error if the text is not an expression.
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
