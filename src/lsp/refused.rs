/// Why a request has no answer.
#[derive(Debug)]
pub(crate) enum Refused {
    /// Nobody answers such a request.
    Unknown,
    /// Its parameters cannot be read.
    Parameters(String),
    /// What it asks for cannot be done, and why.
    Request(String),
}
