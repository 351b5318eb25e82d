use std::fmt;

use admire_syntax::diagnostic::Object;

/// How a person knows an object: `BUSHING/12 'front_arm_bushing'`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Name {
    /// Keyword in capitals.
    pub kind: &'static str,
    /// Id.
    pub id: u32,
    /// View name.
    pub view: String,
}

impl Name {
    /// The view name; none if it says nothing new, made up of kind and id.
    fn telling(&self) -> Option<&str> {
        let tells = !self.view.is_empty() && self.view != format!("{}_{}", self.kind, self.id);
        tells.then_some(&*self.view)
    }

    /// The view name alone where it tells something, else kind and id.
    pub fn short(&self) -> String {
        let own = self.telling().map(str::to_string);
        own.unwrap_or_else(|| format!("{}/{}", self.kind, self.id))
    }

    /// For a complaint about it.
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

/// A constraint equation as a person knows it: `Zi.Xj in JOINT/2 'crank_pin'`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EquationName {
    /// What is zero, of those that have several or a form of their own.
    pub what: Option<&'static str>,
    /// The statement it belongs to.
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
