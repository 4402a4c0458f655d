//! What the symbols of a chain are worth: how few bits a coder could make of them that knew how often each occurs.
//!
//! Reads deltas as a replica does and counts; codes nothing, and no clay is made.
//! Invariant: every symbol that was coded with a model is counted once, in that model's context.

use alloc::collections::BTreeMap;

use super::TileLayout;
use super::chain::Chain;
use super::motion::Motion;
use crate::clay::{Pot, Surface};
use crate::coding::{BitModel, Decoder, KindModel, Symbols};

/// The account of a chain of deltas, read from its first one on.
///
/// The bound is the empirical conditional entropy `H = Σ_c Σ_s n_cs·log₂(n_c/n_cs)`: c the contexts of the coder's own models, n_c the symbols that were
/// coded in one, n_cs those of them that were s. It is what a coder would take that were told all n_cs beforehand for nothing; bits that are not modelled count as themselves (Cover and Thomas 2006, section 2.2).
///
/// ```
/// use pottery_shared::clay::{Pot, PotSpec};
/// use pottery_shared::snapshot::Ledger;
///
/// let ledger = Ledger::new(&Pot::new(PotSpec::default())?);
/// assert_eq!(ledger.entropy_bits(), 0.0);
/// # Ok::<(), pottery_shared::clay::PotError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ledger {
    chain: Chain,
    /// How often each symbol was coded, by where the model lies within the chain.
    counts: BTreeMap<usize, Counts>,
    plain_bits: u64,
    coded_bits: u64,
}

impl Ledger {
    /// Nothing read yet of the chain of a pot, whose grids are those of `pot`.
    #[must_use]
    pub fn new(pot: &Pot) -> Self {
        let layouts = pot.surfaces().iter().map(Surface::shape).map(TileLayout::new);
        Self { chain: Chain::new(layouts), counts: BTreeMap::new(), plain_bits: 0, coded_bits: 0 }
    }

    /// Reads the next delta; false when it is none, and then nothing more can be read.
    pub fn read(&mut self, delta: &[u8]) -> bool {
        let base = core::ptr::from_ref(&self.chain).addr();
        let counted =
            Counted { decoder: Decoder::new(delta), base, counts: &mut self.counts, plain_bits: &mut self.plain_bits };
        if self.chain.code(counted, Motion::default()).is_err() {
            return false;
        }
        self.chain.advance();
        self.coded_bits += 8 * delta.len() as u64;
        true
    }

    /// Bits that the deltas had.
    #[must_use]
    pub const fn coded_bits(&self) -> u64 {
        self.coded_bits
    }

    /// The bound, in bits.
    #[must_use]
    pub fn entropy_bits(&self) -> f64 {
        let of = |counts: &Counts| -> f64 {
            let all = counts.iter().sum::<u64>() as f64;
            counts.iter().filter(|&&n| n > 0).map(|&n| n as f64 * libm::log2(all / n as f64)).sum()
        };
        self.plain_bits as f64 + self.counts.values().map(of).sum::<f64>()
    }

    /// Contexts in which anything was coded.
    #[must_use]
    pub fn contexts(&self) -> usize {
        self.counts.len()
    }
}

/// Of each symbol; a bit is one of the first two.
type Counts = [u64; KindModel::KINDS];

/// Reads symbols and counts them. A context is known by where its model lies.
struct Counted<'a> {
    decoder: Decoder<'a>,
    base: usize,
    counts: &'a mut BTreeMap<usize, Counts>,
    plain_bits: &'a mut u64,
}

impl Counted<'_> {
    fn count(&mut self, place: usize, symbol: usize) {
        self.counts.entry(place.wrapping_sub(self.base)).or_default()[symbol] += 1;
    }
}

impl Symbols for Counted<'_> {
    const IS_GIVEN: bool = false;

    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool {
        let place = core::ptr::from_ref(model).addr();
        let bit = self.decoder.bit(model, bit);
        self.count(place, usize::from(bit));
        bit
    }

    fn kind(&mut self, model: &mut KindModel, kind: usize) -> usize {
        let place = core::ptr::from_ref(model).addr();
        let kind = self.decoder.kind(model, kind);
        self.count(place, kind);
        kind
    }

    fn raw(&mut self, value: u32, count: u32) -> u32 {
        *self.plain_bits += u64::from(count);
        self.decoder.raw(value, count)
    }

    fn is_exhausted(&self) -> bool {
        self.decoder.is_exhausted()
    }
}
