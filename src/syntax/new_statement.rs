/// A statement to be added. Arguments are written in the given order, with their values unchanged.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct NewStatement {
    /// Full keyword in capitals.
    pub kind: String,
    /// Id; `None` for a kind without ids.
    pub id: Option<u32>,
    /// Name for the `adams_view_name` comment.
    pub view_name: Option<String>,
    /// Keyword and value of each argument; the value of a flag is `None`.
    pub arguments: Vec<(String, Option<String>)>,
}
