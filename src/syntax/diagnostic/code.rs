/// Declares the enum of codes; the documentation of each variant is the text that explains its code.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// Stable code of a diagnostic, in kebab case. The command `admire explain CODE` prints its documentation.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
        pub enum Code { $($(#[doc = $doc])+ $variant,)+ }

        impl Code {
            /// All codes, in order of declaration.
            pub const ALL: &'static [Code] = &[$(Code::$variant,)+];

            /// Returns the code as shown to users, for example `undefined-id`.
            pub const fn as_str(self) -> &'static str {
                match self { $(Code::$variant => $name,)+ }
            }

            /// Returns the code with this name in kebab case, or `None` if there is no such code.
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.as_str() == name)
            }

            /// Returns the explanation of the code, which is the documentation of its variant.
            pub const fn explain(self) -> &'static str {
                match self { $(Code::$variant => concat!($($doc, "\n",)+),)+ }
            }
        }
    };
}

codes! {
    // Reading a dataset or a command file.
    /// The keyword of a statement or command is not in the grammar; both `admire check` and `mdi` report this.
    /// The statement is kept unchanged and otherwise ignored.
    UnknownStatement = "unknown-statement",
    /// The statement has no argument with this keyword.
    UnknownArgument = "unknown-argument",
    /// An abbreviated keyword is the beginning of several keywords.
    AmbiguousKeyword = "ambiguous-keyword",
    /// The text violates the syntax of its statement.
    SyntaxError = "syntax-error",
    /// A number is written in a form that cannot be read.
    BadNumber = "bad-number",
    /// A FUNCTION expression violates the grammar of expressions.
    BadExpression = "bad-expression",
    /// An argument has more or fewer values than the grammar allows.
    WrongCount = "wrong-count",
    /// A value has the wrong type, for example a word where a number is needed, or a real number where an id is needed.
    WrongType = "wrong-type",
    /// A number lies outside of the range that its argument allows.
    OutOfRange = "out-of-range",
    /// A required argument is missing.
    MissingArgument = "missing-argument",
    /// The dataset has no END statement.
    MissingEnd = "missing-end",
    // Errors in the meaning of a model.
    /// A statement refers to an id that no statement of the required kind defines.
    UndefinedId = "undefined-id",
    /// Two statements of one kind have the same id.
    DuplicateId = "duplicate-id",
    /// ADAMS supports this statement or function, but the built-in solver does not.
    NotSolvedNatively = "not-solved-natively",
    /// ADAMS includes this statement in statics, but the built-in solver includes it only in simulations over time.
    NotSolvedInStatics = "not-solved-in-statics",
    /// A statement has no effect on a static solution, or it is switched off in statics.
    InactiveInStatics = "inactive-in-statics",
    /// A user-written subroutine is used, which only real ADAMS can run.
    UserSubroutine = "user-subroutine",
    /// A FIELD with a user subroutine is read as a bushing of Adams/Car, or refers to objects of such a bushing but cannot be read as one.
    /// It is recognised by the curves `X.tx_spline` to `X.rz_spline` and the arrays `X.tx_data_array` to `X.rz_data_array` among its
    /// parameters. With q the displacement times its scale minus its offset: F = preload - scale C(q), C an Akima curve, linear
    /// beyond its ends. The radial axes x and y share r = sqrt(qx^2 + qy^2): Fx = preload - scale X(r) qx/r.
    CarBushing = "car-bushing",
    // Lint: problems of a dataset that was parsed without errors.
    /// Two arguments exclude each other, for example REULER and ZP of a MARKER, or two types of a JOINT.
    ConflictingArguments = "conflicting-arguments",
    /// A MARKER whose axes are given by the points ZP and XP was moved.
    /// An edit that sets only QP moves ZP and XP along, so that the marker keeps its orientation.
    /// If the edit sets ZP or XP too, the marker may rotate.
    MarkerPoints = "marker-points",
    /// An argument appears twice in one statement; the later occurrence counts.
    RepeatedArgument = "repeated-argument",
    /// A number that is not an angle has the degree suffix, or an angle without the suffix appears to be in degrees.
    /// The suffix D always multiplies by pi/180; an angle without the suffix is in radians.
    WrongDimension = "wrong-dimension",
    /// Both markers of a constraint or force are on the same part: such a constraint is singular, and such a force has no effect.
    MarkersOnOnePart = "markers-on-one-part",
    /// A FLOATING marker is used where a fixed marker is required, or a fixed marker where the solver must be able to move it (JFLOAT).
    FloatingMarker = "floating-marker",
    /// The dataset has no ground part (PART with GROUND), or more than one.
    NoGround = "no-ground",
    /// A part with mass has no CM marker, or its CM marker is on another part. Its centre of mass is then unknown.
    MassWithoutCm = "mass-without-cm",
    /// The moments of inertia are physically impossible: a principal moment is negative or exceeds the sum of the other two.
    ImpossibleInertia = "impossible-inertia",
    /// A part has neither mass nor constraints, so its acceleration is undefined.
    /// Only a note is given if forces act on the part, because statics does not need its mass.
    FreeWithoutMass = "free-without-mass",
    /// A force element exerts a torque on a POINT_MASS. A POINT_MASS does not rotate, so the torque has no effect.
    LostTorque = "lost-torque",
    /// A MOTION drives a degree of freedom that its joint does not have, or one that another MOTION already drives.
    WrongMotion = "wrong-motion",
    /// The stiffness matrix of a FIELD is not symmetric. ADAMS accepts it, but the elastic forces then do not conserve energy.
    UnsymmetricStiffness = "unsymmetric-stiffness",
    /// A STEP, STEP5 or HAVSIN begins and ends at the same x, so its value there is undefined.
    StepWithoutWidth = "step-without-width",
    /// KT of a BUSHING looks like a stiffness per degree. ADAMS reads KT per radian, which needs a number 57.3 times larger.
    /// The lever arm sqrt(KT/K) of rubber bushings is about 5 to 50 mm; values below 2.5 mm are reported.
    KtPerDegree = "kt-per-degree",
    /// The x (or z) values of a SPLINE do not increase.
    SplineNotIncreasing = "spline-not-increasing",
    /// A FUNCTION that depends on the positions of parts is not differentiable everywhere, so the search for equilibrium may fail.
    /// IF, ABS, MAX, MIN, MOD, SIGN and rounding have kinks or jumps. An IF that depends only on TIME or MODE is not reported.
    NoDerivative = "no-derivative",
    /// Nothing refers to a SPLINE, ARRAY, MATRIX, STRING or CURVE. This is not reported if user subroutines may read the object.
    Unreferenced = "unreferenced",
    /// A tab separates two words. The FORTRAN solver counts a tab as one column; `admire fix` replaces it by a blank.
    Tab = "tab",
    /// A line is longer than the 80 columns that the FORTRAN solver reads; this is reported only for decks of that solver.
    LineTooLong = "line-too-long",
    /// At the design position, the I and J markers of a BUSHING, BEAM or FIELD are rotated relative to each other by more than 10 degrees.
    /// The rotational deformation is measured by projected angles, which are valid only for small rotations.
    BushingAngle = "bushing-angle",
    /// At the design position, the markers of a JOINT or JPRIM violate its constraint: the origins are apart or the axes are not aligned.
    /// ADAMS moves the parts when it assembles the model.
    JointNotAligned = "joint-not-aligned",
    /// The mechanism is implausible in the units of the UNITS statement. Most often, its numbers are in other units.
    /// Examples: a size above a kilometre, a density above that of any material, gravity far from 9.81 m/s2, a bushing stiffer than a steel block.
    /// One implausible quantity gives a warning; several give an error.
    ImplausibleUnits = "implausible-units",
    // Files.
    /// A file does not exist or cannot be read.
    CannotRead = "cannot-read",
    /// Identification has no result: there are no unknown parameters, or no load case can be both solved and compared with readings.
    NoFit = "no-fit",
    /// A file cannot be written.
    CannotWrite = "cannot-write",
    /// A results file is incomplete because the run was killed or is still in progress; its complete steps are read.
    TruncatedResults = "truncated-results",
    /// A results file has a broken structure, or uses XML features that no results file needs (DTD, entities, deep nesting).
    MalformedResults = "malformed-results",
    /// A results file, or a part of it, has an unknown layout.
    UnsupportedResults = "unsupported-results",
    /// A file was found under a name that differs from the given name only in upper and lower case.
    FileNameCase = "file-name-case",
    /// A path comes from another computer; the file with this name was looked up in the local folders.
    ForeignPath = "foreign-path",
    /// A deck or command file names a file outside of the folders from which `admire` reads.
    /// It may name files in its own folder and in the working directory, with their subfolders.
    /// The variable ADMIRE_ALLOW_PATH and the option `--allow-path` of `admire solve` add folders.
    ReadOutside = "read-outside",
    /// A command file writes outside of the allowed folders.
    /// These are its own folder, the folder of its model and the working directory; the variable ADMIRE_ALLOW_PATH adds folders.
    WriteOutside = "write-outside",
    // Running a command file.
    /// An option of OUTPUT or RESULTS requests a file or a number format that only real ADAMS writes.
    OutputNotWritten = "output-not-written",
    /// A word of the launcher's command line is not understood and is skipped.
    LauncherWord = "launcher-word",
    /// The command line starts the launcher in a mode that only a full ADAMS installation can run.
    LauncherRefused = "launcher-refused",
    /// A command that ADAMS executes is not supported by this solver.
    CommandNotSupported = "command-not-supported",
    /// A command that needs a model came before any model was read.
    NoModel = "no-model",
    /// The solver found no static equilibrium.
    NoEquilibrium = "no-equilibrium",
    /// A simulation over time failed.
    /// Causes: inconsistent initial conditions, a singular mass matrix, a step size below HMIN, or a function without a value.
    NoMotion = "no-motion",
    /// The equilibrium is unstable: for at least one mode the stiffness is negative, so that the slightest disturbance leads away from it.
    /// The option `--stable` of `admire solve` makes the solver continue to a stable equilibrium.
    UnstableEquilibrium = "unstable-equilibrium",
    /// In one static solution, a part rotated by more than 60 degrees or moved by more than the size of the mechanism.
    /// The equilibrium found may differ from the intended one.
    LargeMotion = "large-motion",
    /// A command exceeds a limit of this program.
    LimitExceeded = "limit-exceeded",
    /// A study names a program that is started for every run.
    /// Only `study.toml` can name a program; decks and command files start nothing.
    RunsProgram = "runs-program",
    // Studies: study.toml and its CSV files.
    /// `study.toml` violates the syntax of TOML.
    StudySyntax = "study-syntax",
    /// A key of `study.toml` is unknown in its table. Most often the key is misspelt, and the intended setting keeps its default.
    UnknownKey = "unknown-key",
    /// A value of `study.toml` has the wrong type or is outside of its range; the default is used instead.
    BadSetting = "bad-setting",
    /// A required key of `study.toml` is missing.
    MissingSetting = "missing-setting",
    /// A path in `study.toml` leads out of the study folder; files outside of that folder are not read.
    OutsideStudy = "outside-study",
    /// A CSV file lacks a required column.
    MissingColumn = "missing-column",
    /// A study is implausible: a unit, the noise or the loads do not match the readings. The option `--force` fits it nevertheless.
    ImplausibleStudy = "implausible-study",
    /// A cell of a CSV file is not a finite number; the reading is left out.
    BadReading = "bad-reading",
    /// A CSV file uses decimal commas, or semicolons or tabs between its cells; the message says how the file was read.
    CsvDialect = "csv-dialect",
    /// A laboratory's table and its mapping do not say what a column holds: its unit, sign or side, or the test of its rows. Nothing is guessed;
    /// the message shows the lines of the mapping to fill in.
    UnclearColumn = "unclear-column",
    /// A note on the source of each curve of the `[kc]` table: the column of the rig's file, its unit and its sign.
    KcCurves = "kc-curves",
    /// A note on how many hardpoints and bushings of the subsystem of section `[car]` are in the deck; a warning if no hardpoint is.
    CarSubsystem = "car-subsystem",
    /// An address in `study.toml` refers to nothing in the deck, or to an object of another kind than required.
    UnknownTarget = "unknown-target",
    /// A CSV file names a part that is not in the deck.
    UnknownPart = "unknown-part",
    /// A reading names a mark (measured point) that was not measured on its part in the first session.
    UnknownMark = "unknown-mark",
    /// A setting names a load case that does not exist.
    UnknownCase = "unknown-case",
    /// Two load cases have the same label, or the readings of two load cases are identical copies.
    DuplicateCase = "duplicate-case",
    /// The same mark (measured point) is read twice in one load case.
    DuplicateReading = "duplicate-reading",
    /// A part has fewer than three marks (measured points) in a load case, so its position and orientation are undetermined.
    MissingMarks = "missing-marks",
    /// The marks (measured points) of a part are nearly collinear, so its rotation about their line cannot be determined.
    CollinearMarks = "collinear-marks",
    /// The labels of two marks (measured points) of one part are swapped.
    SwappedMarks = "swapped-marks",
    /// Coordinates are given in another length unit than the unit of the deck.
    WrongUnits = "wrong-units",
    /// The measured positions of the marks of a part deviate from a rigid-body motion by more than their noise.
    InconsistentMarks = "inconsistent-marks",
    /// An effect that is to be added to a virtual rig does not exist, has no location, or lacks a required parameter.
    BadEffect = "bad-effect",
    /// The solver finds no equilibrium for a load case.
    /// No fit uses the case; its loads still precede the loads of later cases.
    UnreachableCase = "unreachable-case",
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

impl serde::Serialize for Code {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> serde::Deserialize<'de> for Code {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = std::borrow::Cow::<str>::deserialize(deserializer)?;
        let unknown = || serde::de::Error::custom(format!("`{name}` is not a message code"));
        Self::parse(&name).ok_or_else(unknown)
    }
}
