//! A digest by which two copies of the clay are compared.
//!
//! For finding differences, not for security: whoever forges clay must already be let in.
//! Invariant: the digest depends on the words and their order, and on no target.

/// Running 64-bit digest of 32-bit words: FNV-1a taken a word at a time, finished with an avalanche.
///
/// ```
/// use pottery_shared::clay::Digest;
/// let (mut one, mut other) = (Digest::default(), Digest::default());
/// one.add(1);
/// one.add(2);
/// other.add(2);
/// other.add(1);
/// assert_ne!(one.finish(), other.finish());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// Takes in one word.
    pub const fn add(&mut self, word: u32) {
        self.0 = (self.0 ^ word as u64).wrapping_mul(0x0000_0100_0000_01b3);
    }

    /// The digest of all words so far.
    #[must_use]
    pub const fn finish(self) -> u64 {
        // the avalanche of MurmurHash3, so that sums of digests do not cancel
        let mut bits = self.0;
        bits = (bits ^ (bits >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        bits = (bits ^ (bits >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        bits ^ (bits >> 33)
    }
}
