//! The language server: the toolkit over the Language Server Protocol, on standard input and output.
//!
//! Diagnostics come from `admire-syntax` and from the checks of `admire-session`. The server is independent of any particular editor. One
//! thread answers requests, and another thread checks whole files.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
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

/// Serves one editor on standard input and output until the session ends.
///
/// # Errors
/// When the initial handshake violates the protocol, or messages cannot be read or written.
pub fn serve_stdio() -> std::io::Result<Ended> {
    let (connection, wire) = wire::stdio();
    let ended = serve(&connection).map_err(std::io::Error::other);
    drop(connection);
    wire.join()?;
    ended
}

/// Serves one editor over a connection until the session ends.
///
/// # Errors
/// When the initial handshake violates the protocol.
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
