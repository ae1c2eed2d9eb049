//! PNG pictures: 8 bits for each channel, not interlaced.
//!
//! Guaranteed: the pixels come back bit for bit, and equal pictures give equal bytes. Each row has the filter with the
//! smallest sum of differences, the usual guess at what packs best.

use super::bytes::{FileFault, length_u32};

/// What a pixel consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue, opacity (not multiplied in).
    Rgba,
}

impl Channels {
    /// Bytes of a pixel.
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }
}

/// zlib's own default: what is better takes several times as long for a few percent.
const LEVEL: u8 = 6;

/// Bytes of a PNG file.
///
/// **Takes** rows from the top, pixels from the left, in sRGB; and how many pixels are a metre, for printing in real size.
/// **Fails** for pictures whose packed pixels exceed 2³¹ − 1 bytes. **Costs** O(pixels).
pub fn png(
    size: [u32; 2],
    channels: Channels,
    pixels: &[u8],
    pixels_per_metre: Option<u32>,
) -> Result<Vec<u8>, FileFault> {
    let [width, height] = size;
    let row = width as usize * channels.count();
    assert!(width > 0 && height > 0, "a picture has pixels");
    assert_eq!(pixels.len(), row * height as usize, "all of them are given");
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::new();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    let colour_type = match channels {
        Channels::Rgb => 2,
        Channels::Rgba => 6,
    };
    header.extend([8, colour_type, 0, 0, 0]);
    push_chunk(&mut out, *b"IHDR", &header)?;
    if let Some(density) = pixels_per_metre {
        let mut data = density.to_be_bytes().repeat(2);
        data.push(1);
        push_chunk(&mut out, *b"pHYs", &data)?;
    }
    let filtered = filter(pixels, row, channels.count());
    let packed = miniz_oxide::deflate::compress_to_vec_zlib(&filtered, LEVEL);
    push_chunk(&mut out, *b"IDAT", &packed)?;
    push_chunk(&mut out, *b"IEND", &[])?;
    Ok(out)
}

fn push_chunk(out: &mut Vec<u8>, name: [u8; 4], data: &[u8]) -> Result<(), FileFault> {
    let most = i32::MAX as usize;
    if data.len() > most {
        return Err(FileFault::TooLarge { bytes: data.len(), most });
    }
    out.extend(length_u32(data.len())?.to_be_bytes());
    let start = out.len();
    out.extend(name);
    out.extend(data);
    out.extend(crc32fast::hash(&out[start..]).to_be_bytes());
    Ok(())
}

/// Each row as differences to its neighbours, behind the number of its filter.
fn filter(pixels: &[u8], row: usize, step: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(pixels.len() + pixels.len() / row);
    let above_first = vec![0; row];
    let mut above: &[u8] = &above_first;
    let mut tries: [Vec<u8>; 5] = std::array::from_fn(|_| Vec::with_capacity(row));
    for now in pixels.chunks_exact(row) {
        for differences in &mut tries {
            differences.clear();
        }
        for i in 0..row {
            let left = if i < step { 0 } else { now[i - step] };
            let corner = if i < step { 0 } else { above[i - step] };
            let up = above[i];
            let mean = left.midpoint(up);
            let guesses = [0, left, up, mean, paeth(left, up, corner)];
            for (differences, guess) in tries.iter_mut().zip(guesses) {
                differences.push(now[i].wrapping_sub(guess));
            }
        }
        // Differences are small numbers of either sign.
        let cost = |differences: &[u8]| {
            differences.iter().map(|d| u64::from(d.cast_signed().unsigned_abs())).sum::<u64>()
        };
        let best = (0..5u8).min_by_key(|&i| cost(&tries[i as usize])).unwrap_or(0);
        out.push(best);
        out.extend(&tries[best as usize]);
        above = now;
    }
    out
}

/// The neighbour that is nearest to left + up − corner.
fn paeth(left: u8, up: u8, corner: u8) -> u8 {
    let [a, b, c] = [left, up, corner].map(i16::from);
    let guess = a + b - c;
    let [to_a, to_b, to_c] = [a, b, c].map(|x| (guess - x).abs());
    if to_a <= to_b && to_a <= to_c {
        left
    } else if to_b <= to_c {
        up
    } else {
        corner
    }
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "made-up pixels")]
mod tests {
    use super::*;

    /// Chunks as name and data, their sums checked.
    fn chunks(file: &[u8]) -> Vec<([u8; 4], &[u8])> {
        let mut rest = file.strip_prefix(b"\x89PNG\r\n\x1a\n").unwrap();
        let mut found = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            let sum = u32::from_be_bytes(rest[8 + length..12 + length].try_into().unwrap());
            assert_eq!(crc32fast::hash(&rest[4..8 + length]), sum);
            found.push((rest[4..8].try_into().unwrap(), &rest[8..8 + length]));
            rest = &rest[12 + length..];
        }
        found
    }

    /// Undoes the filters by their definition.
    fn unfilter(data: &[u8], row: usize, step: usize) -> Vec<u8> {
        let mut rows: Vec<Vec<u8>> = vec![vec![0; row]];
        for line in data.chunks_exact(row + 1) {
            let above = rows.last().unwrap().clone();
            let mut now: Vec<u8> = Vec::new();
            for (i, &x) in line[1..].iter().enumerate() {
                let (a, c) = if i < step { (0, 0) } else { (now[i - step], above[i - step]) };
                let b = above[i];
                let guess = match line[0] {
                    0 => 0,
                    1 => a,
                    2 => b,
                    3 => ((u16::from(a) + u16::from(b)) / 2) as u8,
                    4 => paeth(a, b, c),
                    other => panic!("filter {other}"),
                };
                now.push(x.wrapping_add(guess));
            }
            rows.push(now);
        }
        rows[1..].concat()
    }

    fn picture(width: usize, height: usize, step: usize) -> Vec<u8> {
        let value = |i: usize| {
            let (x, y, channel) = (i / step % width, i / step / width, i % step);
            // Smooth, striped and rough in turn, so that each filter is the best somewhere.
            match y % 4 {
                0 => (3 * x + 40 * channel) as u8,
                1 => (x.wrapping_mul(2_654_435_761) >> 7) as u8,
                2 => (255 * (x / 4 % 2)) as u8,
                _ => (x * x / 50 + 7 * y) as u8,
            }
        };
        (0..width * height * step).map(value).collect()
    }

    #[test]
    fn pixels_come_back_bit_for_bit() {
        for (channels, size) in
            [(Channels::Rgb, [61, 40]), (Channels::Rgba, [1, 7]), (Channels::Rgba, [200, 33])]
        {
            let step = channels.count();
            let pixels = picture(size[0] as usize, size[1] as usize, step);
            let file = png(size, channels, &pixels, Some(11811)).unwrap();
            let chunks = chunks(&file);
            let names: Vec<_> = chunks.iter().map(|(name, _)| name).collect();
            assert_eq!(names, [b"IHDR", b"pHYs", b"IDAT", b"IEND"]);
            assert_eq!(chunks[0].1[..4], size[0].to_be_bytes());
            assert_eq!(chunks[0].1[4..8], size[1].to_be_bytes());
            assert_eq!(chunks[1].1, [0, 0, 0x2e, 0x23, 0, 0, 0x2e, 0x23, 1]);
            let data = miniz_oxide::inflate::decompress_to_vec_zlib(chunks[2].1).unwrap();
            assert_eq!(unfilter(&data, size[0] as usize * step, step), pixels);
        }
    }

    #[test]
    fn smooth_pictures_pack_well() {
        let pixels: Vec<u8> =
            (0..256 * 256).flat_map(|i| [(i % 256) as u8, (i / 256) as u8, 128]).collect();
        let file = png([256, 256], Channels::Rgb, &pixels, None).unwrap();
        // Each row is the same differences: far below one byte for each pixel.
        assert!(file.len() < 4000, "{}", file.len());
    }
}
