use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use serde::de::DeserializeOwned;

/// Reads a settings file in TOML.
///
/// # Errors
/// Returns a diagnostic with `code` at the first fault: bytes that are not UTF-8, a syntax error, an unknown key or a value of the wrong
/// type.
pub fn read_toml<T: DeserializeOwned>(source: &Source, code: Code) -> Result<T, Diagnostic> {
    let wrong =
        |message: &str, span| Diagnostic::error(code, message).label(source.name(), span, "");
    let text = source
        .utf8()
        .map_err(|span| wrong("this is not UTF-8 text", span))?;
    toml::from_str(text).map_err(|error| {
        let span = error.span().map_or(Span::at(0), Span::from);
        wrong(error.message(), span)
    })
}
