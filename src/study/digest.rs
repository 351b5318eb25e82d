use sha2::{Digest, Sha256};

/// SHA-256 over the bytes of several files, each with its length before it, in hexadecimal: the same digest means the same bytes.
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
