/// Declares all codes with their names and documentation.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// Stable code of a diagnostic, spelled in kebab case. `admire explain CODE` prints its documentation.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
        pub enum Code { $($(#[doc = $doc])+ $variant,)+ }

        impl Code {
            /// All codes.
            pub const ALL: &'static [Code] = &[$(Code::$variant,)+];

            /// Returns the code as shown to users, for example `undefined-id`.
            pub const fn as_str(self) -> &'static str {
                match self { $(Code::$variant => $name,)+ }
            }

            /// Returns the code with this name.
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.as_str() == name)
            }

            /// Returns the meaning of the code: the documentation of its variant.
            pub const fn explain(self) -> &'static str {
                match self { $(Code::$variant => concat!($($doc, "\n",)+),)+ }
            }
        }
    };
}

codes! {
    // Reading a dataset or a command file.
    /// The keyword of a statement or command is not in the grammar; an error for both `check` and `mdi`.
    /// The statement is kept unchanged and otherwise ignored.
    UnknownStatement = "unknown-statement",
    /// The statement has no argument with this keyword.
    UnknownArgument = "unknown-argument",
    /// An abbreviated keyword matches several keywords.
    AmbiguousKeyword = "ambiguous-keyword",
    /// The text violates the syntax of its statement.
    SyntaxError = "syntax-error",
    /// A number that cannot be read.
    BadNumber = "bad-number",
    /// A FUNCTION expression violates the grammar of expressions.
    BadExpression = "bad-expression",
    /// An argument has more or fewer values than the grammar allows.
    WrongCount = "wrong-count",
    /// A value of the wrong type: a word where a number is needed, a real where an id is needed.
    WrongType = "wrong-type",
    /// A number outside of the range the argument allows.
    OutOfRange = "out-of-range",
    /// A required argument is missing.
    MissingArgument = "missing-argument",
    /// The dataset has no END statement.
    MissingEnd = "missing-end",
    // Meaning of a model.
    /// An id that no statement of the required kind defines.
    UndefinedId = "undefined-id",
    /// Two statements of one kind with the same id.
    DuplicateId = "duplicate-id",
    /// A statement that ADAMS accepts but the built-in solver does not support.
    NotSolvedNatively = "not-solved-natively",
    /// A statement that ADAMS includes in statics, but the built-in solver includes in motion only.
    NotSolvedInStatics = "not-solved-in-statics",
    /// A statement that has no effect on a static solution, or is inactive in statics.
    InactiveInStatics = "inactive-in-statics",
    /// A user-written subroutine, which only real ADAMS can run.
    UserSubroutine = "user-subroutine",
    // Lint: problems of a dataset that was read without errors.
    /// Arguments that exclude each other, for example REULER and ZP of a MARKER, or two types of a JOINT.
    ConflictingArguments = "conflicting-arguments",
    /// A MARKER whose axes are given by the points ZP and XP was moved.
    /// An edit of QP alone moves ZP and XP along, so that the marker keeps its orientation. If ZP or XP get values of their own, the marker
    /// turns.
    MarkerPoints = "marker-points",
    /// An argument appears twice in one statement; the later one counts.
    RepeatedArgument = "repeated-argument",
    /// A number that is not an angle has the degree suffix, or an angle without the suffix looks like degrees.
    /// The suffix D always multiplies by pi/180; an angle without it is in radians.
    WrongDimension = "wrong-dimension",
    /// Both markers of a constraint or force are on the same part: the constraint is singular, or the force has no effect.
    MarkersOnOnePart = "markers-on-one-part",
    /// A FLOATING marker where a fixed one is required, or a fixed one where the solver must be able to move it (JFLOAT).
    FloatingMarker = "floating-marker",
    /// The dataset has no PART with GROUND, or more than one.
    NoGround = "no-ground",
    /// A part with mass has no CM marker, or its CM marker is on another part: the point where its weight acts is unknown.
    MassWithoutCm = "mass-without-cm",
    /// Physically impossible moments of inertia: a principal moment is negative or exceeds the sum of the other two.
    ImpossibleInertia = "impossible-inertia",
    /// A part has neither mass nor constraints, so its acceleration is undefined.
    /// Only a note if forces act on the part, because this is enough for statics.
    FreeWithoutMass = "free-without-mass",
    /// A force element exerts a torque on a POINT_MASS; a POINT_MASS does not rotate, so the torque has no effect.
    LostTorque = "lost-torque",
    /// A MOTION acts on a freedom that its joint lacks, such as one of a FIXED joint, or on a freedom that already has a MOTION.
    WrongMotion = "wrong-motion",
    /// The stiffness matrix of a FIELD is not symmetric; ADAMS accepts it, but the elastic forces then do not conserve energy.
    UnsymmetricStiffness = "unsymmetric-stiffness",
    /// A STEP, STEP5 or HAVSIN begins and ends at the same x, so its value there is undefined.
    StepWithoutWidth = "step-without-width",
    /// KT of a BUSHING looks like a stiffness per degree; ADAMS reads it per radian, where the same stiffness has a 57.3 times larger value.
    /// The lever arm sqrt(KT/K) of rubber bushings is about 5 to 50 mm; values below 2.5 mm are reported.
    KtPerDegree = "kt-per-degree",
    /// The x (or z) values of a SPLINE do not increase.
    SplineNotIncreasing = "spline-not-increasing",
    /// A FUNCTION of the motion is not differentiable everywhere, so the search for equilibrium may fail there.
    /// IF, ABS, MAX, MIN, MOD, SIGN and rounding have kinks or jumps. An IF that depends only on TIME or MODE is not reported.
    NoDerivative = "no-derivative",
    /// A SPLINE, ARRAY, MATRIX, STRING or CURVE that nothing refers to; not reported if user subroutines may read it.
    Unreferenced = "unreferenced",
    /// A tab between words; the FORTRAN solver counts it as one column, and `admire fix` replaces it by a blank.
    Tab = "tab",
    /// A line longer than the 80 columns that the FORTRAN solver reads; reported only for decks of that solver.
    LineTooLong = "line-too-long",
    /// The I and J markers of a BUSHING, BEAM or FIELD are rotated by more than 10 degrees relative to each other at the design position.
    /// The rotational deformation is measured by projected angles, which are valid only for small rotations.
    BushingAngle = "bushing-angle",
    /// The markers of a JOINT or JPRIM do not meet its constraint at the design position: origins apart or axes not aligned.
    /// ADAMS moves the parts when it assembles the model.
    JointNotAligned = "joint-not-aligned",
    /// In the units of UNITS the mechanism is implausible; most often the numbers are in other units than UNITS states.
    /// Examples: a size of a kilometre, a density above any material, a gravity far from 9.81 m/s2, a stiffness above
    /// steel. An error if several quantities are implausible.
    ImplausibleUnits = "implausible-units",
    // Files.
    /// A file that does not exist or cannot be read.
    CannotRead = "cannot-read",
    /// Identification has no result: there are no unknowns, or no load case can be solved and compared.
    NoFit = "no-fit",
    /// A file that cannot be written.
    CannotWrite = "cannot-write",
    /// A results file is incomplete because the run was killed or is still in progress; its complete steps are read.
    TruncatedResults = "truncated-results",
    /// A results file has a broken structure, or uses XML features that no results file needs (DTD, entities, deep nesting).
    MalformedResults = "malformed-results",
    /// A results file, or a part of it, has an unknown layout.
    UnsupportedResults = "unsupported-results",
    /// A file was found under a name that differs in upper and lower case.
    FileNameCase = "file-name-case",
    /// A path from another computer; the file was looked up here by its base name.
    ForeignPath = "foreign-path",
    /// A deck or command file names a file outside of the folders from which `admire` reads.
    /// The folder of the deck or command file and the working directory are allowed, with their subfolders. ADMIRE_ALLOW_PATH, and
    /// `--allow-path` of `admire solve`, add folders.
    ReadOutside = "read-outside",
    /// A command file writes outside of its own folder, the folder of its model and the working directory; ADMIRE_ALLOW_PATH adds folders.
    WriteOutside = "write-outside",
    // Running a command file.
    /// An option of OUTPUT or RESULTS that ADAMS supports and this solver does not: a file or a number format that is not written.
    OutputNotWritten = "output-not-written",
    /// A word of the launcher's command line that has no meaning here.
    LauncherWord = "launcher-word",
    /// A launch form that only a full ADAMS installation can run.
    LauncherRefused = "launcher-refused",
    /// A command that ADAMS executes and this solver does not.
    CommandNotSupported = "command-not-supported",
    /// A command that needs a model came before any model was read.
    NoModel = "no-model",
    /// No static equilibrium was found.
    NoEquilibrium = "no-equilibrium",
    /// A simulation over time failed.
    /// Causes: inconsistent initial conditions, a singular mass matrix, a step size below HMIN, or a function without a value.
    NoMotion = "no-motion",
    /// The equilibrium is unstable: some motion has a negative stiffness, so that the slightest disturbance leads away from it.
    /// `admire solve --stable` continues to a stable equilibrium.
    UnstableEquilibrium = "unstable-equilibrium",
    /// A part rotated by more than 60 degrees or moved by more than the size of the mechanism in one static solution.
    /// The equilibrium found may differ from the intended one.
    LargeMotion = "large-motion",
    /// A command exceeds a limit of this program.
    LimitExceeded = "limit-exceeded",
    /// A study names a program that is started for every run; only `study.toml` can name one, decks and command files start nothing.
    RunsProgram = "runs-program",
    // Studies: study.toml and its CSV files.
    /// `study.toml` violates the syntax of TOML.
    StudySyntax = "study-syntax",
    /// A key of `study.toml` is unknown in its place; most often it is misspelt, and the intended setting keeps its default.
    UnknownKey = "unknown-key",
    /// A value of `study.toml` has the wrong type or is outside of its range; the default is used instead.
    BadSetting = "bad-setting",
    /// A required key of `study.toml` is missing.
    MissingSetting = "missing-setting",
    /// A path in `study.toml` leads out of the study folder; nothing outside of it is read.
    OutsideStudy = "outside-study",
    /// A CSV file lacks a required column.
    MissingColumn = "missing-column",
    /// An implausible study: a unit, the noise or the loads do not match the readings. `--force` fits it nevertheless.
    ImplausibleStudy = "implausible-study",
    /// A cell of a CSV file is not a finite number; the reading is left out.
    BadReading = "bad-reading",
    /// A CSV file uses semicolons or tabs between its cells, or decimal commas; the message says how it was read.
    CsvDialect = "csv-dialect",
    /// Source of each curve of `[kc]`: the column of the rig's file, its unit and its sign.
    KcCurves = "kc-curves",
    /// An address in `study.toml` names nothing in the deck, or nothing of the required kind.
    UnknownTarget = "unknown-target",
    /// A CSV file names a part that is not in the deck.
    UnknownPart = "unknown-part",
    /// A reading of a mark that was not measured on its part in the first session.
    UnknownMark = "unknown-mark",
    /// A named case is not among the load cases.
    UnknownCase = "unknown-case",
    /// Two load cases share a label, or the readings of two cases are identical copies.
    DuplicateCase = "duplicate-case",
    /// The same mark is read twice in one case.
    DuplicateReading = "duplicate-reading",
    /// A part has fewer than three marks in a load case, so its pose is undetermined.
    MissingMarks = "missing-marks",
    /// The marks of a part are nearly collinear, so its rotation about their line cannot be determined.
    CollinearMarks = "collinear-marks",
    /// The labels of two marks of one part are swapped.
    SwappedMarks = "swapped-marks",
    /// Coordinates have another length unit than the deck.
    WrongUnits = "wrong-units",
    /// The marks of a part are inconsistent with a rigid body, beyond their noise.
    InconsistentMarks = "inconsistent-marks",
    /// An effect to be added to a virtual rig does not exist, has no location, or lacks a number.
    BadEffect = "bad-effect",
    /// The solver finds no equilibrium for a load case; the case is still applied in its order, but no fit uses it.
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
        let unknown = || serde::de::Error::custom(format!("`{name}` is not a code"));
        Self::parse(&name).ok_or_else(unknown)
    }
}
