//! Statements that the built-in solver cannot solve: their effects, and their omission on request.

use super::object::Object;
use super::{Function, Header, Model};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::{Role, find_statement};

/// Statement that the built-in solver cannot solve, with the reason.
#[derive(Clone, PartialEq, Debug)]
pub struct Unsolved {
    /// Id and name of the object, and index of its statement.
    pub header: Header,
    /// Keyword of the statement in capitals.
    pub kind: &'static str,
    /// Diagnostic code: `UserSubroutine` or `NotSolvedNatively`.
    pub code: Code,
    /// Reason why only real ADAMS can solve the statement.
    pub why: String,
}

impl Object for Unsolved {
    fn header(&self) -> &Header {
        &self.header
    }

    fn header_mut(&mut self) -> &mut Header {
        &mut self.header
    }

    fn is(&self, kind: &str) -> bool {
        self.kind == kind
    }
}

/// Returns the effect that an unsolved statement would have on an equilibrium. Returns `None` for statements that only measure, draw or
/// write. Also returns `None` for statements that act only through other statements, because those other statements are rejected
/// themselves.
pub(crate) fn effect_of(kind: &str) -> Option<&'static str> {
    Some(match kind {
        "CLEARANCE" | "CONTROL" | "CURVE" | "FEMDATA" | "FE_NODE" | "LINEAR" | "MREQUEST"
        | "SECTION" | "SURFACE" => return None,
        "CBKSUB" => "without it, the changes that its subroutine makes are missing",
        "CONTACT" => "without it, the contact forces are missing",
        "COUPLER" | "CVCV" | "GCON" | "PTCV" | "UCON" => "without it, a constraint is missing",
        "FE_LOAD" => "without it, a load on a flexible beam is missing",
        "FE_PART" | "FLEX_BODY" => "without it, a flexible body is missing",
        "FRICTION" => "without it, the friction in its joint is missing",
        "GSE" => "without it, functions that read its outputs have no value",
        "MARKER" => "without it, the objects attached to it have no position",
        "MFORCE" => "without it, a load on a flexible body is missing",
        "MOTION" => "without it, the driven motion is missing",
        "SPLINE" => "without it, functions that read it have no value",
        "TIRE" => "without it, the tyre force is missing",
        _ => "without it, a force is missing",
    })
}

/// Returns the warning that a statement is left out on request, with its effect.
pub fn left_out_warning(kind: &str, header: &Header) -> Diagnostic {
    let effect = effect_of(kind).unwrap_or_default();
    let name = &header.name;
    Diagnostic::warning(
        Code::NotSolvedNatively,
        format!(
            "{kind}/{} '{name}' is left out as requested: {effect}",
            header.id
        ),
    )
}

/// Statements that may be left out on request: forces and constraints. Bodies, markers and data are excluded, because other statements
/// depend on them.
const LEFT_OUT: [&str; 19] = [
    "BEAM", "CBKSUB", "CONTACT", "COUPLER", "CVCV", "FE_LOAD", "FIELD", "FRICTION", "GCON",
    "GFORCE", "GSE", "MFORCE", "MOTION", "PTCV", "SFORCE", "TIRE", "UCON", "VFORCE", "VTORQUE",
];

/// Returns whether a kind of statement may be left out on request.
pub(crate) fn may_be_ignored(kind: &str) -> bool {
    LEFT_OUT.contains(&kind)
}

/// Unsolved statements that the user allows the built-in solver to leave out: all statements of one kind, or a single statement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Ignore {
    kind: &'static str,
    id: Option<u32>,
}

impl Ignore {
    /// Parses a list such as `CONTACT, FRICTION/3`.
    ///
    /// # Errors
    /// Returns an error message that names the first word that is not a statement or cannot be left out, and lists the allowed statements.
    pub fn parse(list: &str) -> Result<Vec<Self>, String> {
        let words = list.split([',', ';', ' ']).filter(|word| !word.is_empty());
        words.map(Self::word).collect()
    }

    fn word(word: &str) -> Result<Self, String> {
        let (kind, id) = match word.split_once('/') {
            Some((kind, id)) => (kind, Some(id)),
            None => (word, None),
        };
        let found = find_statement(kind.as_bytes(), Role::Dataset).found();
        let number = id.map(str::parse).transpose();
        match (found, number) {
            (Some(def), Ok(id)) if may_be_ignored(def.name) => Ok(Self { kind: def.name, id }),
            _ => Err(format!(
                "`{word}` cannot be left out; only unsolved forces and constraints can be: {}",
                LEFT_OUT.join(", ")
            )),
        }
    }

    fn covers(self, kind: &str, header: &Header) -> bool {
        self.kind == kind && self.id.is_none_or(|id| id == header.id)
    }
}

impl Model {
    /// Deactivates the statements that `ignored` covers and that the built-in solver cannot solve. Returns the kind and header of each
    /// statement that was active before.
    pub fn leave_out(&mut self, ignored: &[Ignore]) -> Vec<(&'static str, Header)> {
        let mut out = Vec::new();
        let mut leave = |kind: &'static str, header: &mut Header| {
            if header.active && ignored.iter().any(|i| i.covers(kind, header)) {
                header.active = false;
                out.push((kind, header.clone()));
            }
        };
        for unsolved in &mut self.unsolved {
            leave(unsolved.kind, &mut unsolved.header);
        }
        let user = |function: &Function| matches!(function, Function::User(_));
        for friction in &mut self.frictions {
            leave("FRICTION", &mut friction.header);
        }
        for force in self.sforces.iter_mut().filter(|f| user(&f.function)) {
            leave("SFORCE", &mut force.header);
        }
        for motion in self.motions.iter_mut().filter(|m| user(&m.function)) {
            leave("MOTION", &mut motion.header);
        }
        for gcon in self.gcons.iter_mut().filter(|g| user(&g.function)) {
            leave("GCON", &mut gcon.header);
        }
        for force in &mut self.vector_forces {
            if force.components.iter().flatten().any(user) {
                let kind = LEFT_OUT.into_iter().find(|kind| force.is(kind));
                leave(kind.unwrap_or("GFORCE"), &mut force.header);
            }
        }
        out
    }

    /// Returns whether the object with this kind and id is inactive. Covers only kinds of objects that have a FUNCTION.
    pub(crate) fn is_off(&self, kind: &str, id: u32) -> bool {
        fn off<T: Object>(list: &[T], kind: &str, id: u32) -> bool {
            list.iter()
                .any(|o| !o.header().active && o.header().id == id && o.is(kind))
        }
        match kind {
            "FIELD" => off(&self.pair_forces, kind, id),
            "SFORCE" => off(&self.sforces, kind, id),
            "GFORCE" | "VFORCE" | "VTORQUE" => off(&self.vector_forces, kind, id),
            "MOTION" => off(&self.motions, kind, id),
            "GCON" => off(&self.gcons, kind, id),
            "VARIABLE" => off(&self.variables, kind, id),
            "DIFF" => off(&self.diffs, kind, id),
            "SENSOR" => off(&self.sensors, kind, id),
            _ => false,
        }
    }
}
