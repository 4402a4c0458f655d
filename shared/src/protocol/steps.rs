//! Small movements from tick to tick, in few bits.
//!
//! Owns the Golomb–Rice code of a run's steps; knows nothing of tools.
//! Invariant: what is decoded from an encoding is what went in; other bytes give some steps or an error, and take no more
//! memory than the message's limit allows.
//!
//! A hand hardly changes its velocity within a millisecond, so that each axis is coded as the change of its step: zigzag,
//! then Rice (1979) with the parameter that makes the run shortest. A quotient of [`ESCAPE`] stands for sixteen plain bits.

use alloc::vec::Vec;

use bincode::de::Decoder;
use bincode::enc::Encoder;
use bincode::error::{DecodeError, EncodeError};
use bincode::{Decode, Encode};

/// Quotient behind which the number itself follows.
const ESCAPE: u32 = 15;
/// Largest parameter: two to this is beyond the fastest hand's change.
const PARAMETER_MAX: u32 = 15;
/// Bits of a parameter.
const PARAMETER_BITS: u32 = 4;

/// Movements along three axes, from tick to tick.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Steps(pub Vec<[i16; 3]>);

impl From<Vec<[i16; 3]>> for Steps {
    fn from(steps: Vec<[i16; 3]>) -> Self {
        Self(steps)
    }
}

impl core::ops::Deref for Steps {
    type Target = Vec<[i16; 3]>;

    fn deref(&self) -> &Vec<[i16; 3]> {
        &self.0
    }
}

impl core::ops::DerefMut for Steps {
    fn deref_mut(&mut self) -> &mut Vec<[i16; 3]> {
        &mut self.0
    }
}

/// A change of a step as a number from zero up: 0, −1, 1, −2, 2 …
const fn zigzag(change: i16) -> u16 {
    ((change << 1) ^ (change >> 15)) as u16
}

const fn unzigzag(number: u16) -> i16 {
    (number >> 1) as i16 ^ -((number & 1) as i16)
}

/// Bits that a number takes.
const fn length(number: u16, parameter: u32) -> u32 {
    let quotient = number as u32 >> parameter;
    if quotient < ESCAPE { quotient + 1 + parameter } else { ESCAPE + 16 }
}

/// Bits, highest first.
#[derive(Debug, Default)]
struct BitWriter {
    bytes: Vec<u8>,
    free: u32,
}

impl BitWriter {
    fn bits(&mut self, value: u32, count: u32) {
        for at in (0..count).rev() {
            if self.free == 0 {
                self.bytes.push(0);
                self.free = 8;
            }
            self.free -= 1;
            if let Some(last) = self.bytes.last_mut() {
                *last |= ((value >> at & 1) as u8) << self.free;
            }
        }
    }

    fn number(&mut self, number: u16, parameter: u32) {
        let quotient = u32::from(number) >> parameter;
        if quotient < ESCAPE {
            // as many ones, and a zero
            self.bits((1 << (quotient + 1)) - 2, quotient + 1);
            self.bits(u32::from(number), parameter);
        } else {
            self.bits((1 << ESCAPE) - 1, ESCAPE);
            self.bits(u32::from(number), 16);
        }
    }
}

#[derive(Debug)]
struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl BitReader<'_> {
    fn bits(&mut self, count: u32) -> Option<u32> {
        let mut value = 0;
        for _ in 0..count {
            let byte = *self.bytes.get(self.at / 8)?;
            value = value << 1 | u32::from(byte >> (7 - self.at % 8) & 1);
            self.at += 1;
        }
        Some(value)
    }

    fn number(&mut self, parameter: u32) -> Option<u16> {
        let mut quotient = 0;
        while quotient < ESCAPE && self.bits(1)? == 1 {
            quotient += 1;
        }
        if quotient == ESCAPE {
            return self.bits(16).map(|number| number as u16);
        }
        let number = quotient << parameter | self.bits(parameter)?;
        u16::try_from(number).ok()
    }

    /// Whether nothing but the zeros of a begun byte is left.
    fn is_done(&mut self) -> bool {
        let left = self.bytes.len() * 8 - self.at;
        left < 8 && self.bits(left as u32) == Some(0)
    }
}

impl Steps {
    /// Most bits that a step takes behind another one, whatever else is in the run: what it takes with one parameter, and the
    /// one that is chosen makes the run no longer.
    #[must_use]
    pub fn bits_max(before: [i16; 3], step: [i16; 3]) -> usize {
        let bits = |axis: usize| length(zigzag(step[axis].wrapping_sub(before[axis])), 3) as usize;
        bits(0) + bits(1) + bits(2)
    }

    fn changes(&self, axis: usize) -> impl Iterator<Item = u16> + '_ {
        let mut before = 0_i16;
        self.iter().map(move |step| zigzag(step[axis].wrapping_sub(core::mem::replace(&mut before, step[axis]))))
    }

    /// The parameter with which an axis is shortest.
    fn parameter(&self, axis: usize) -> u32 {
        let bits = |parameter: u32| self.changes(axis).map(|number| u64::from(length(number, parameter))).sum::<u64>();
        (0..=PARAMETER_MAX).min_by_key(|&parameter| bits(parameter)).unwrap_or(0)
    }

    fn packed(&self) -> Vec<u8> {
        let mut writer = BitWriter::default();
        if !self.is_empty() {
            for axis in 0..3 {
                let parameter = self.parameter(axis);
                writer.bits(parameter, PARAMETER_BITS);
                for number in self.changes(axis) {
                    writer.number(number, parameter);
                }
            }
        }
        writer.bytes
    }

    fn unpack(steps: &mut [[i16; 3]], bytes: &[u8]) -> Option<()> {
        let mut reader = BitReader { bytes, at: 0 };
        if !steps.is_empty() {
            for axis in 0..3 {
                let parameter = reader.bits(PARAMETER_BITS)?;
                let mut before = 0_i16;
                for step in &mut *steps {
                    before = before.wrapping_add(unzigzag(reader.number(parameter)?));
                    step[axis] = before;
                }
            }
        }
        reader.is_done().then_some(())
    }
}

impl Encode for Steps {
    fn encode<E: Encoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
        (self.len() as u64).encode(encoder)?;
        self.packed().encode(encoder)
    }
}

impl<Context> Decode<Context> for Steps {
    fn decode<D: Decoder<Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
        let count = usize::try_from(u64::decode(decoder)?).map_err(|_| DecodeError::LimitExceeded)?;
        let bytes = Vec::<u8>::decode(decoder)?;
        // each step takes a bit an axis at least, so that a claim cannot be larger than what is there
        if count > bytes.len() * 8 / 3 {
            return Err(DecodeError::Other("more steps than bits"));
        }
        decoder.claim_container_read::<[i16; 3]>(count)?;
        let mut steps = alloc::vec![[0; 3]; count];
        Self::unpack(&mut steps, &bytes).ok_or(DecodeError::Other("no steps"))?;
        Ok(Self(steps))
    }
}

bincode::impl_borrow_decode!(Steps);
