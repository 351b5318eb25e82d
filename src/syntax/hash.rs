//! A fast hash for the short keys of a deck: ids and keywords.

use std::hash::{BuildHasher, Hasher, RandomState};

/// Builder of hashers. Each hash table gets a random seed, so that no deck can be crafted to make its ids collide.
#[derive(Clone, Copy, Debug)]
pub struct QuickState(u64);

impl Default for QuickState {
    fn default() -> Self {
        Self(RandomState::new().hash_one(0u8) | 1)
    }
}

impl BuildHasher for QuickState {
    type Hasher = QuickHasher;

    fn build_hasher(&self) -> QuickHasher {
        QuickHasher {
            state: self.0,
            seed: self.0,
        }
    }
}

/// Hasher that multiplies to a 128-bit product and combines the two halves of the product by exclusive or.
#[derive(Clone, Copy, Debug)]
pub struct QuickHasher {
    state: u64,
    seed: u64,
}

const fn fold(a: u64, b: u64) -> u64 {
    let product = (a as u128).wrapping_mul(b as u128);
    (product as u64) ^ ((product >> 64) as u64)
}

impl Hasher for QuickHasher {
    fn finish(&self) -> u64 {
        fold(self.state, self.seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
        self.write_u64(bytes.len() as u64);
    }

    fn write_u8(&mut self, value: u8) {
        self.write_u64(u64::from(value));
    }

    fn write_u32(&mut self, value: u32) {
        self.write_u64(u64::from(value));
    }

    fn write_u64(&mut self, value: u64) {
        self.state = fold(
            self.state ^ value ^ 0xa076_1d64_78bd_642f,
            self.seed | 0xe703_7ed1_a0b4_28db,
        );
    }

    fn write_usize(&mut self, value: usize) {
        self.write_u64(value as u64);
    }
}

/// A hash map with the fast hash.
pub type QuickMap<K, V> = std::collections::HashMap<K, V, QuickState>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_fall_far_apart() {
        let state = QuickState::default();
        let mut slots = vec![0u32; 1024];
        for id in 0..4096u32 {
            slots[(state.hash_one(id * 1000) >> 54) as usize] += 1;
        }
        assert!(slots.iter().all(|count| *count < 20), "{slots:?}");
    }
}
