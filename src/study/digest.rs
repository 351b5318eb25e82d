use sha2::{Digest, Sha256};

/// Returns the SHA-256 of the contents of several files, in hexadecimal. The length of each file is hashed before its bytes, so moving a
/// boundary between files changes the digest.
pub fn digest<'a>(files: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    for bytes in files {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    let digits =
        |byte: u8| [byte >> 4, byte & 15].map(|d| char::from(b"0123456789abcdef"[d as usize]));
    hash.finalize()
        .iter()
        .flat_map(|byte| digits(*byte))
        .collect()
}
