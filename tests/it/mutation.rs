//! Damage to files, the same each time: what the property tests of the readers feed on.
//!
//! A mutant has one to eight small injuries, more than half of all only one: bytes changed, parts cut out, repeated, moved or cut off,
//! numbers of text replaced by awkward ones, and words of four bytes by awkward counts and floats.

/// A small generator of pseudo-random numbers: SplitMix64 (Steele, Lea, Flood 2014).
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// A generator that gives the same numbers for the same seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number below `n`, 0 for none; the bias is of no concern here.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Numbers that a text should not have there.
const AWKWARD_TEXTS: [&[u8]; 24] = [
    b"0",
    b"-0",
    b"1",
    b"-1",
    b"2",
    b"3",
    b"255",
    b"256",
    b"65536",
    b"2147483647",
    b"-2147483648",
    b"4294967295",
    b"4294967296",
    b"18446744073709551615",
    b"99999999999999999999999",
    b"nan",
    b"-inf",
    b"1e400",
    b"1e39",
    b"1e-400",
    b"0.1.2",
    b"1,5",
    b"x",
    b"",
];

/// Words of four bytes that a binary file should not have there: counts, indices, and floats that are not finite.
const AWKWARD_WORDS: [u32; 12] = [
    0,
    1,
    2,
    0xff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0xffff_fffe,
    0x7f80_0000,
    0x7fc0_0000,
    0x7f7f_ffff,
];

/// A damaged copy of `bytes`, at most eight times a few hundred bytes longer; the same for the same seed.
pub fn mutate(seed: u64, bytes: &[u8]) -> Vec<u8> {
    let mut random = SplitMix64::new(seed);
    let mut out = bytes.to_vec();
    for _ in 0..=random.below(2) * random.below(8) {
        injure(&mut random, &mut out);
    }
    out
}

fn injure(random: &mut SplitMix64, out: &mut Vec<u8>) {
    let at = random.below(out.len());
    let length = (1 << random.below(8)) + random.below(8);
    let part = at..out.len().min(at + length);
    if out.is_empty() {
        out.push(random.next() as u8);
        return;
    }
    match random.below(10) {
        0 => out[at] ^= 1 << random.below(8),
        1 => out[at] = random.next() as u8,
        2 => out[at] = b" \t\n\r#\\/-+.,0"[random.below(12)],
        // Rarely, or most mutants would be stumps.
        3 if random.below(3) == 0 => out.truncate(at),
        3 | 4 => drop(out.drain(part)),
        5 => {
            let copy = out[part].to_vec();
            let place = random.below(out.len() + 1);
            out.splice(place..place, copy);
        }
        6 => {
            let copy = out[part].to_vec();
            let place = random.below(out.len());
            let end = out.len().min(place + copy.len());
            out[place..end].copy_from_slice(&copy[..end - place]);
        }
        7 => {
            let word = AWKWARD_WORDS[random.below(AWKWARD_WORDS.len())];
            let word = if random.below(2) == 0 { word.to_le_bytes() } else { word.to_be_bytes() };
            let end = out.len().min(at + 4);
            out[at..end].copy_from_slice(&word[..end - at]);
        }
        _ => {
            let number = number_near(out, at);
            let text = AWKWARD_TEXTS[random.below(AWKWARD_TEXTS.len())];
            out.splice(number, text.iter().copied());
        }
    }
}

/// The first number of the text at or after a place; nothing at that place where there is none near.
fn number_near(text: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_part = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'+' | b'.');
    let near = &text[at..text.len().min(at + 64)];
    let Some(start) = near.iter().position(is_part) else { return at..at };
    let rest = &text[at + start..];
    let length = rest.iter().position(|b| !is_part(b)).unwrap_or(rest.len());
    at + start..at + start + length
}

#[test]
fn a_mutant_is_the_same_for_the_same_seed_and_differs_for_most_others() {
    let file = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".repeat(20);
    assert_eq!(mutate(7, &file), mutate(7, &file));
    let mutants = std::collections::BTreeSet::from_iter((0..1000).map(|seed| mutate(seed, &file)));
    // A few seeds change nothing, or the same byte.
    assert!(mutants.len() > 900, "{}", mutants.len());
    mutate(1, b"");
}
