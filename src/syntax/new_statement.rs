/// A statement to be added to a dataset. Its arguments are written in the given order, and their values are not changed.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct NewStatement {
    /// Full keyword in capitals.
    pub kind: String,
    /// Id of the statement; `None` if statements of this kind have no id.
    pub id: Option<u32>,
    /// ADAMS/View name, which is written in an `adams_view_name` comment.
    pub view_name: Option<String>,
    /// Keyword and value of each argument; the value of a flag is `None`.
    pub arguments: Vec<(String, Option<String>)>,
}
