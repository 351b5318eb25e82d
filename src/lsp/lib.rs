//! The language server: the toolkit over the Language Server Protocol, on standard input and output.
//!
//! What is said of files comes from `admire-syntax` and the checks of `admire-session`. Knows no editor. One thread answers, a second one
//! checks whole files.
#![warn(unreachable_pub)]
// Modules that are private link to what is private with them.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod capabilities;
mod complaint;
mod completion;
mod convert;
mod cursor;
mod definition;
mod definitions;
mod document;
mod excerpt;
mod fixes;
mod folding;
mod format;
mod highlight;
mod hover;
mod position;
mod references;
mod refused;
mod rename;
mod requests;
mod server;
mod signature;
mod snippets;
mod symbols;
mod typing;
mod wire;
mod worker;
mod workspace;

use lsp_server::{Connection, ProtocolError};

pub use document::Document;
pub use server::Ended;

/// Answers one editor on standard input and output until it goes away.
///
/// # Errors
/// When the first messages are not those of the protocol, or cannot be read or written.
pub fn serve_stdio() -> std::io::Result<Ended> {
    let (connection, wire) = wire::stdio();
    let ended = serve(&connection).map_err(std::io::Error::other);
    drop(connection);
    wire.join()?;
    ended
}

/// Answers one editor until it goes away.
///
/// # Errors
/// When the first messages are not those of the protocol.
pub fn serve(connection: &Connection) -> Result<Ended, ProtocolError> {
    let (id, params) = connection.initialize_start()?;
    let folders = capabilities::folders(params);
    connection.initialize_finish(id, capabilities::answer())?;
    Ok(server::Server::run(
        connection,
        folders,
        requests::Routes::all(),
    ))
}
