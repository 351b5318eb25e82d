/// Reason why a request is refused.
#[derive(Debug)]
pub(crate) enum Refused {
    /// The method is not supported.
    Unknown,
    /// The parameters are malformed.
    Parameters(String),
    /// The request cannot be carried out, for this reason.
    Request(String),
}
