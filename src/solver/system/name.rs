use std::fmt;

use admire_syntax::diagnostic::Object;

/// Name of an object in messages: `BUSHING/12 'front_arm_bushing'`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Name {
    /// Keyword of the statement in capitals.
    pub kind: &'static str,
    /// Id of the object.
    pub id: u32,
    /// Adams/View name.
    pub view: String,
}

impl Name {
    /// Returns the View name, or `None` if the View name only repeats kind and id.
    fn telling(&self) -> Option<&str> {
        let tells = !self.view.is_empty() && self.view != format!("{}_{}", self.kind, self.id);
        tells.then_some(&*self.view)
    }

    /// Returns the View name, or kind and id if the View name only repeats these.
    pub fn short(&self) -> String {
        let own = self.telling().map(str::to_string);
        own.unwrap_or_else(|| format!("{}/{}", self.kind, self.id))
    }

    /// Returns the object in the form used by diagnostics.
    pub fn object(&self) -> Object {
        Object {
            kind: self.kind,
            id: self.id,
            called: self.to_string(),
            view: self.telling().map(str::to_string),
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.kind, self.id)?;
        match self.telling() {
            Some(view) => write!(f, " '{view}'"),
            None => Ok(()),
        }
    }
}

/// Name of a constraint equation in messages: `Zi.Xj in JOINT/2 'crank_pin'`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EquationName {
    /// Expression that the equation sets to zero. `None` for COUPLER, GEAR and GCON, whose name alone identifies the equation.
    pub what: Option<&'static str>,
    /// Statement to which the equation belongs.
    pub object: Name,
}

impl fmt::Display for EquationName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.what {
            Some(what) => write!(f, "{what} in {}", self.object),
            None => self.object.fmt(f),
        }
    }
}
