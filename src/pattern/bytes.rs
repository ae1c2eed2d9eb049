//! What writers of bytes share: limits of formats, and little-endian numbers.

use std::fmt;

/// Why a file cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFault {
    /// More bytes than the format can hold.
    TooLarge {
        /// Bytes that were needed, or the first count that was too many.
        bytes: usize,
        /// The most that it holds.
        most: usize,
    },
    /// More files in an archive than the format counts.
    TooManyFiles {
        /// How many there are.
        files: usize,
        /// The most that it holds.
        most: usize,
    },
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { bytes, most } => {
                write!(f, "{bytes} bytes, the format holds {most}")
            }
            Self::TooManyFiles { files, most } => {
                write!(f, "{files} files, the format holds {most}")
            }
        }
    }
}

impl std::error::Error for FileFault {}

/// A length in 32 bits.
pub(super) fn length_u32(bytes: usize) -> Result<u32, FileFault> {
    u32::try_from(bytes).map_err(|_| FileFault::TooLarge { bytes, most: u32::MAX as usize })
}

/// Single precision, kept finite: readers of meshes refuse what does not fit, but a writer should not rely on it.
#[expect(clippy::cast_possible_truncation, reason = "rounded to what the file holds")]
pub(super) fn single(x: f64) -> f32 {
    (x as f32).clamp(f32::MIN, f32::MAX)
}

/// Appends numbers, low byte first.
pub(super) fn push_singles(out: &mut Vec<u8>, numbers: impl IntoIterator<Item = f32>) {
    for x in numbers {
        out.extend(x.to_le_bytes());
    }
}
