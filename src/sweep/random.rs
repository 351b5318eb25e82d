//! Counter-based random numbers: the value at `index` of a stream depends only on seed, stream and index.
//!
//! The generator is ChaCha8 (Bernstein 2008), which allows random access. Its bits are converted without the platform's mathematics
//! library, so that every machine produces the same numbers.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use sha2::{Digest, Sha256};

/// Stream of random numbers.
#[derive(Clone, Debug)]
pub struct Stream {
    key: [u8; 32],
    stream: u64,
}

impl Stream {
    /// Returns the stream with this name. The stream of a variation is unchanged if other variations are added to a sweep.
    pub fn named(seed: u64, name: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let digest = Sha256::digest(name.as_bytes());
        let mut first = [0; 8];
        first.copy_from_slice(&digest[..8]);
        Self {
            key,
            stream: u64::from_le_bytes(first),
        }
    }

    /// Returns the 64 random bits at `index` of the stream.
    pub(crate) fn bits(&self, index: u64) -> u64 {
        let mut generator = ChaCha8Rng::from_seed(self.key);
        generator.set_stream(self.stream);
        // Each value of 64 bits consists of two words of 32 bits.
        generator.set_word_pos(u128::from(index) * 2);
        generator.next_u64()
    }

    /// Returns the uniform random number at `index`, strictly between 0 and 1.
    pub fn uniform(&self, index: u64) -> f64 {
        to_unit(self.bits(index))
    }

    /// Returns the uniform random integer at `index`, from 0 to `bound - 1`.
    pub(crate) fn below(&self, index: u64, bound: u64) -> u64 {
        // The bias is below bound / 2^64, which is negligible.
        ((u128::from(self.bits(index)) * u128::from(bound)) >> 64) as u64
    }

    /// Returns the position of `index` in a random permutation of the integers below `count`, without storing the permutation. Four rounds
    /// of a Feistel cipher are repeated while the result is out of range (Black and Rogaway 2002).
    pub(crate) fn shuffled(&self, index: u64, count: u64) -> u64 {
        let half = (64 - count.saturating_sub(1).leading_zeros())
            .div_ceil(2)
            .max(1);
        let mask = (1_u64 << half) - 1;
        let keys: [u64; 4] = std::array::from_fn(|round| self.bits(u64::MAX - round as u64));
        let mut at = index;
        loop {
            let (mut left, mut right) = (at >> half, at & mask);
            for key in keys {
                (left, right) = (right, left ^ (mixed(right ^ key) & mask));
            }
            at = left << half | right;
            if at < count {
                return at;
            }
        }
    }
}

/// Converts the upper 53 of 64 bits to a number strictly between 0 and 1.
pub(crate) fn to_unit(bits: u64) -> f64 {
    ((bits >> 11) as f64 + 0.5) * (0.5_f64).powi(53)
}

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_depends_on_seed_name_and_index_alone() {
        let a = Stream::named(1, "a");
        let forward: Vec<u64> = (0..100).map(|k| a.bits(k)).collect();
        let backward: Vec<u64> = (0..100)
            .rev()
            .map(|k| Stream::named(1, "a").bits(k))
            .collect();
        assert!(forward.iter().eq(backward.iter().rev()));
        assert_ne!(a.bits(0), Stream::named(1, "b").bits(0));
        assert_ne!(a.bits(0), Stream::named(2, "a").bits(0));
    }

    #[test]
    fn the_key_stream_is_chacha8() {
        // First words of ChaCha8 with a key and nonce of zeros (draft-strombergson-chacha-test-vectors-01, TC1).
        let zero = Stream {
            key: [0; 32],
            stream: 0,
        };
        assert_eq!(
            zero.bits(0).to_le_bytes(),
            [0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]
        );
    }

    #[test]
    fn shuffling_is_a_permutation() {
        for count in [1, 2, 3, 10, 64, 65, 1000] {
            let stream = Stream::named(7, "order");
            let mut all: Vec<u64> = (0..count).map(|k| stream.shuffled(k, count)).collect();
            let moved = all
                .iter()
                .enumerate()
                .filter(|(k, to)| *k as u64 != **to)
                .count();
            assert!(count < 10 || moved > count as usize / 2);
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count));
        }
    }
}
