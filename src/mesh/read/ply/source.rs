//! The numbers of a PLY file, one after the other, whether text or bytes.
//!
//! Guaranteed: no number is made up: where the file ends, [`Stop::End`] says so. Not guaranteed: that a number is finite,
//! unless it is asked for as a coordinate.

use super::header::Scalar;
use crate::mesh::read::ReadFault;
use crate::mesh::read::number::{self, quote};
use crate::mesh::read::words::Words;

/// Why there is no next number.
pub(super) enum Stop {
    /// The file ends.
    End,
    /// What stands there cannot be used.
    Fault(ReadFault),
}

impl From<ReadFault> for Stop {
    fn from(fault: ReadFault) -> Self {
        Self::Fault(fault)
    }
}

/// Where numbers come from.
pub(super) trait Source {
    /// The next number; NaN where a word is none.
    fn number(&mut self, kind: Scalar) -> Result<f64, Stop>;

    /// The next number, which must be finite and fit the graphics card.
    fn coordinate(&mut self, kind: Scalar) -> Result<f64, Stop>;

    /// Steps over numbers.
    fn skip(&mut self, count: u64, kind: Scalar) -> Result<(), Stop>;

    /// The least number of bytes that a number takes.
    fn least_size(&self, kind: Scalar) -> usize;

    /// Number of bytes that are left.
    fn left(&self) -> usize;

    /// The line of the last number; `None` in a binary file.
    fn line(&self) -> Option<u32>;

    /// The next number, which must be a count of as many numbers as there can still be.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::float_cmp,
        reason = "a count is a number that the cast does not change"
    )]
    #[inline]
    fn list(&mut self, count: Scalar, entry: Scalar) -> Result<u64, Stop> {
        let x = self.number(count)?;
        let n = x as u64;
        if x < 0.0 || n as f64 != x {
            return Err(ReadFault::NotACount { text: x.to_string() }.into());
        }
        // The last number of a text may have no blank after it.
        if n.saturating_mul(self.least_size(entry) as u64) > self.left() as u64 + 1 {
            return Err(Stop::End);
        }
        Ok(n)
    }
}

/// The numbers of a binary file; `BIG` says that the first byte of a number is its largest.
pub(super) struct Binary<'a, const BIG: bool> {
    pub(super) bytes: &'a [u8],
}

impl<const BIG: bool> Binary<'_, BIG> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let (first, rest) = self.bytes.split_first_chunk::<N>().ok_or(Stop::End)?;
        self.bytes = rest;
        let mut first = *first;
        if BIG {
            first.reverse();
        }
        Ok(first)
    }
}

impl<const BIG: bool> Source for Binary<'_, BIG> {
    #[inline]
    fn number(&mut self, kind: Scalar) -> Result<f64, Stop> {
        Ok(match kind {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline]
    fn coordinate(&mut self, kind: Scalar) -> Result<f64, Stop> {
        Ok(number::finite(self.number(kind)?)?)
    }

    fn skip(&mut self, count: u64, kind: Scalar) -> Result<(), Stop> {
        let length = count.saturating_mul(kind.size() as u64);
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        self.bytes = self.bytes.get(length..).ok_or(Stop::End)?;
        Ok(())
    }

    fn least_size(&self, kind: Scalar) -> usize {
        kind.size()
    }

    fn left(&self) -> usize {
        self.bytes.len()
    }

    fn line(&self) -> Option<u32> {
        None
    }
}

/// The numbers of a text, on whatever lines they stand.
pub(super) struct Text<'a> {
    pub(super) words: Words<'a>,
}

impl<'a> Text<'a> {
    #[inline]
    fn word(&mut self) -> Result<&'a [u8], Stop> {
        self.words.next_on_any_line().ok_or(Stop::End)
    }
}

impl Source for Text<'_> {
    fn number(&mut self, _: Scalar) -> Result<f64, Stop> {
        Ok(number::parse(self.word()?).unwrap_or(f64::NAN))
    }

    fn coordinate(&mut self, _: Scalar) -> Result<f64, Stop> {
        Ok(number::coordinate(self.word()?)?)
    }

    fn skip(&mut self, count: u64, _: Scalar) -> Result<(), Stop> {
        for _ in 0..count {
            self.word()?;
        }
        Ok(())
    }

    fn list(&mut self, _: Scalar, entry: Scalar) -> Result<u64, Stop> {
        let word = self.word()?;
        let n = number::whole(word).ok_or_else(|| ReadFault::NotACount { text: quote(word) })?;
        if n.saturating_mul(self.least_size(entry) as u64) > self.left() as u64 + 1 {
            return Err(Stop::End);
        }
        Ok(n)
    }

    fn least_size(&self, _: Scalar) -> usize {
        // A digit and a blank.
        2
    }

    fn left(&self) -> usize {
        self.words.left()
    }

    fn line(&self) -> Option<u32> {
        Some(self.words.line)
    }
}
