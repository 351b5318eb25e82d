/// A statement to add. Values are written as they are, in the order given.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct NewStatement {
    /// Whole keyword in capitals.
    pub kind: String,
    /// Id, if the kind has ids.
    pub id: Option<u32>,
    /// Name for the `adams_view_name` comment.
    pub view_name: Option<String>,
    /// Keyword and value of each argument; flags have no value.
    pub arguments: Vec<(String, Option<String>)>,
}
