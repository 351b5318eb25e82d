/// Declares the codes with their documentation in one place.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $variant:ident = $name:literal,)+) => {
        /// A stable kebab-case code. `admire explain CODE` prints its documentation.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
        pub enum Code { $($(#[doc = $doc])+ $variant,)+ }

        impl Code {
            /// Every code there is.
            pub const ALL: &'static [Code] = &[$(Code::$variant,)+];

            /// The code as shown, for example `undefined-id`.
            pub const fn as_str(self) -> &'static str {
                match self { $(Code::$variant => $name,)+ }
            }

            /// The code of this name.
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.as_str() == name)
            }

            /// What the code means: the documentation of its variant.
            pub const fn explain(self) -> &'static str {
                match self { $(Code::$variant => concat!($($doc, "\n",)+),)+ }
            }
        }
    };
}

codes! {
    // Reading a dataset or a command file.
    /// A statement or command whose keyword is not in the grammar, an error for `check` and `mdi` alike. It is kept as it is and takes part
    /// in nothing.
    UnknownStatement = "unknown-statement",
    /// An argument whose keyword the statement does not have.
    UnknownArgument = "unknown-argument",
    /// A keyword cut so short that several keywords begin with it.
    AmbiguousKeyword = "ambiguous-keyword",
    /// Text that does not follow the syntax of the statement it stands in.
    SyntaxError = "syntax-error",
    /// A number that cannot be read.
    BadNumber = "bad-number",
    /// A FUNCTION expression that does not follow the grammar of expressions.
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
    /// An id that no statement of the needed kind defines.
    UndefinedId = "undefined-id",
    /// Two statements of one kind with the same id.
    DuplicateId = "duplicate-id",
    /// A statement ADAMS accepts and the built-in solver does not solve.
    NotSolvedNatively = "not-solved-natively",
    /// A statement ADAMS takes into account in statics, and the built-in solver in motion alone.
    NotSolvedInStatics = "not-solved-in-statics",
    /// A statement that has no effect on a static answer, or is inactive in statics.
    InactiveInStatics = "inactive-in-statics",
    /// A user-written subroutine, which only real ADAMS can run.
    UserSubroutine = "user-subroutine",
    // Lint: what is wrong with a dataset that reads well.
    /// Arguments that cannot stand together, for example REULER and ZP of a MARKER, or two types of a JOINT.
    ConflictingArguments = "conflicting-arguments",
    /// A MARKER whose axes are given by ZP and XP was moved. An edit of QP moves these points along, so that the marker does not turn;
    /// where they are given values of their own the marker turns.
    MarkerPoints = "marker-points",
    /// An argument that is written twice in one statement. The later one counts.
    RepeatedArgument = "repeated-argument",
    /// A number with the degree suffix where no angle is meant, or an angle without it that looks like degrees. The suffix D always
    /// multiplies by pi/180; without it an angle is in radians.
    WrongDimension = "wrong-dimension",
    /// Both markers of a constraint or force are on one part: a constraint is singular, a force moves nothing.
    MarkersOnOnePart = "markers-on-one-part",
    /// A FLOATING marker where a fixed one is needed, or a fixed one where the solver must move it (JFLOAT).
    FloatingMarker = "floating-marker",
    /// The dataset has no PART with GROUND, or more than one.
    NoGround = "no-ground",
    /// A part has mass and no CM marker, or its CM marker is on another part: where its weight acts is unknown.
    MassWithoutCm = "mass-without-cm",
    /// Moments of inertia no body has: a principal moment below zero, or one larger than the sum of the two others.
    ImpossibleInertia = "impossible-inertia",
    /// A part has no mass and no constraint holds it: its acceleration is not defined. Where only forces act on it, which is enough
    /// for statics, this is a note.
    FreeWithoutMass = "free-without-mass",
    /// A force element exerts a torque on a POINT_MASS, which does not turn: the torque does nothing there.
    LostTorque = "lost-torque",
    /// A MOTION on a joint that has no such freedom, such as a FIXED one, or a second MOTION on the same freedom.
    WrongMotion = "wrong-motion",
    /// The stiffness matrix of a FIELD is not symmetric. ADAMS accepts it; elastic forces then give or take energy.
    UnsymmetricStiffness = "unsymmetric-stiffness",
    /// A STEP, STEP5 or HAVSIN that begins and ends at the same x: its value there is not defined.
    StepWithoutWidth = "step-without-width",
    /// KT of a BUSHING looks like a stiffness per degree; ADAMS takes it per radian, 57.3 times as much. The lever arm sqrt(KT/K)
    /// of rubber bushings is some 5 to 50 mm; below 2.5 mm this is asked.
    KtPerDegree = "kt-per-degree",
    /// The x (or z) values of a SPLINE do not increase.
    SplineNotIncreasing = "spline-not-increasing",
    /// A FUNCTION of the motion has no derivative everywhere: IF, ABS, MAX, MIN, MOD, SIGN and rounding bend or jump, and the search
    /// for equilibrium may stumble there. IF of TIME or MODE alone is not reported.
    NoDerivative = "no-derivative",
    /// A SPLINE, ARRAY, MATRIX, STRING or CURVE that nothing uses. Not reported where user subroutines may read it.
    Unreferenced = "unreferenced",
    /// A tab between words. The FORTRAN solver counts it as one column; `admire fix` writes a blank.
    Tab = "tab",
    /// A line longer than the 80 columns the FORTRAN solver reads. Reported only for decks of that solver.
    LineTooLong = "line-too-long",
    /// The I and J markers of a BUSHING, BEAM or FIELD are turned by more than 10 degrees against each other at the design position:
    /// its rotational deformation is measured by projected angles, which hold only for small ones.
    BushingAngle = "bushing-angle",
    /// The markers of a JOINT or JPRIM are not where the constraint needs them at the design position: origins apart or axes
    /// not aligned. ADAMS moves the parts when it assembles the model.
    JointNotAligned = "joint-not-aligned",
    /// In the units of UNITS the mechanism is unlike anything built: a kilometre long, denser than matter, in a gravity far from
    /// 9.81 m/s2, or stiffer than steel can be. Most often the numbers are in other units than UNITS says. An error where several
    /// quantities say so.
    ImplausibleUnits = "implausible-units",
    // Files.
    /// A file that does not exist or cannot be read.
    CannotRead = "cannot-read",
    /// No method of identification gives an answer: nothing is unknown, or no load case can be solved and compared.
    NoFit = "no-fit",
    /// A file that cannot be written.
    CannotWrite = "cannot-write",
    /// A results file that ends before its end: the run was killed or is still going. Whole steps are read.
    TruncatedResults = "truncated-results",
    /// A results file whose structure is broken, or that uses XML it has no business to use (DTD, entities, deep nesting).
    MalformedResults = "malformed-results",
    /// A results file, or a part of one, of a layout that is not known here.
    UnsupportedResults = "unsupported-results",
    /// A file that was found under a name that differs in upper and lower case.
    FileNameCase = "file-name-case",
    /// A path of another computer: the file was looked up by its base name here.
    ForeignPath = "foreign-path",
    /// `admire` reads what a deck or command file names only below the folder of that file and the working directory;
    /// ADMIRE_ALLOW_PATH, and `--allow-path` of `admire solve`, add folders.
    ReadOutside = "read-outside",
    /// A command file may write only beside itself, beside its model and in the working directory; ADMIRE_ALLOW_PATH adds folders.
    WriteOutside = "write-outside",
    // Running a command file.
    /// An option of OUTPUT or RESULTS that ADAMS follows and this solver does not: a file or a spelling that is not written.
    OutputNotWritten = "output-not-written",
    /// A word of the launcher's command line that means nothing here.
    LauncherWord = "launcher-word",
    /// A launch form only a full ADAMS installation can run.
    LauncherRefused = "launcher-refused",
    /// A command ADAMS executes and this solver does not.
    CommandNotSupported = "command-not-supported",
    /// A command that needs a model, before any was read.
    NoModel = "no-model",
    /// No static equilibrium was found.
    NoEquilibrium = "no-equilibrium",
    /// A simulation over time could not go on: inconsistent initial conditions, a singular mass matrix, a step below HMIN, a function
    /// without a value.
    NoMotion = "no-motion",
    /// An equilibrium that does not last: some motion is met by a negative stiffness, so that the slightest push leads away from it.
    /// `admire solve --stable` goes on to a stable one.
    UnstableEquilibrium = "unstable-equilibrium",
    /// A part turned by more than 60 degrees or moved by more than the mechanism's size in one static solution: the equilibrium may be
    /// another than the one that is meant.
    LargeMotion = "large-motion",
    /// A command asks for more than this program is willing to do.
    LimitExceeded = "limit-exceeded",
    /// A study names a program that is started for every run. Only `study.toml` can name one; decks and command files start nothing.
    RunsProgram = "runs-program",
    // Studies: study.toml and its CSV files.
    /// `study.toml` does not follow the syntax of TOML.
    StudySyntax = "study-syntax",
    /// A key of `study.toml` that means nothing there. Most are spelling mistakes, and the setting that was meant keeps its default.
    UnknownKey = "unknown-key",
    /// A value of `study.toml` of the wrong type or outside of its range. The default is taken.
    BadSetting = "bad-setting",
    /// A key of `study.toml` that must be given is missing.
    MissingSetting = "missing-setting",
    /// A path of `study.toml` leads out of the study folder. Nothing outside of it is read.
    OutsideStudy = "outside-study",
    /// A CSV file has no column of the needed name.
    MissingColumn = "missing-column",
    /// A study that cannot be meant: a unit, the noise or the loads are not those of the readings. `--force` fits it all the same.
    ImplausibleStudy = "implausible-study",
    /// A cell of a CSV file that is no finite number. The reading is left out.
    BadReading = "bad-reading",
    /// A CSV file with semicolons or tabs between its cells, or decimal commas. Says how it was read.
    CsvDialect = "csv-dialect",
    /// Which column of a rig's file each curve of `[kc]` is read from, in which unit and with which sign.
    KcCurves = "kc-curves",
    /// An address of `study.toml` that names nothing in the deck, or nothing of the needed kind.
    UnknownTarget = "unknown-target",
    /// A part named in a CSV file that the deck does not have.
    UnknownPart = "unknown-part",
    /// A reading of a mark that the first session did not measure on its part.
    UnknownMark = "unknown-mark",
    /// A case named somewhere that the load cases do not have.
    UnknownCase = "unknown-case",
    /// Two load cases share a label, or the readings of two cases are copies of each other.
    DuplicateCase = "duplicate-case",
    /// The same mark is read twice in one case.
    DuplicateReading = "duplicate-reading",
    /// A part has fewer than three marks in a load case: its pose there is unknown.
    MissingMarks = "missing-marks",
    /// The marks of a part lie so nearly on one line that its rotation about the line cannot be seen.
    CollinearMarks = "collinear-marks",
    /// Two marks of one part carry each other's label.
    SwappedMarks = "swapped-marks",
    /// Coordinates are in another length unit than the deck.
    WrongUnits = "wrong-units",
    /// The marks of a part do not fit a rigid body within their noise.
    InconsistentMarks = "inconsistent-marks",
    /// An effect to plant on a virtual rig that does not exist, sits nowhere, or lacks a number.
    BadEffect = "bad-effect",
    /// A load case the solver finds no equilibrium for. It is still applied in its order; no fit uses it.
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
