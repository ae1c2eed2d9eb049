//! How far parts reach into one another: samples of each against the field of the other.

use super::field::Field;
use super::part::{Part, Spot};
use super::plane::{self, cross, minus, size};

/// Disks within a part.
const DISKS: usize = 12;
/// Points along a rim, at least.
const RIM: f64 = 32.0;
/// Disks are this part of their size: fields of others are interpolated where disks meet them, and must not keep parts apart that
/// are.
const DISK: f64 = 0.8;

/// A place of a part that must keep away from others by its radius and the gap.
#[derive(Clone, Copy, Debug)]
struct Sample {
    at: [f64; 2],
    radius: f64,
    /// How much counts how far it reaches in: length of rim.
    weight: f64,
}

/// What the search knows of a part.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    field: Field,
    /// Disks, then every fourth place of the rim, then the others.
    samples: Vec<Sample>,
    /// How many of these tell about how much a part overlaps.
    coarse: usize,
    slack: f64,
}

/// Two parts where they lie.
#[derive(Clone, Copy)]
pub(super) struct Meeting<'a> {
    pub probes: [&'a Probe; 2],
    pub spots: [&'a Spot; 2],
    /// What parts move apart to.
    pub gap: f64,
    /// By how much they may fall short of it.
    pub touch: f64,
}

/// Where a part reaches deepest into another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    pub depth: f64,
    /// On the sheet.
    pub at: [f64; 2],
    /// The way out, of length about 1.
    pub out: [f64; 2],
}

impl Probe {
    /// **Costs** the most of all preparations: about 4000 cells times the points of the rim.
    pub fn new(part: &Part, gap: f64, most_slack: f64) -> Self {
        let exact = [gap + part.slack, gap + part.slack + most_slack];
        let field = Field::new(&part.rim, exact, exact[1] + 0.1 * part.diameter);
        let disks: Vec<Sample> = field
            .disks(DISKS)
            .into_iter()
            .map(|(at, radius)| Sample { at, radius: DISK * radius, weight: 2.0 * radius })
            .collect();
        let all = || part.rim.iter().flat_map(|outline| plane::sides(outline));
        let step = all().map(|[a, b]| size(minus(b, a))).sum::<f64>() / RIM;
        let mut rim = Vec::new();
        for [a, b] in all() {
            let along = minus(b, a);
            let parts = (size(along) / step).ceil().max(1.0);
            let weight = (size(along) / parts).max(0.25 * step);
            let mut k = 0.0;
            while k < parts {
                let at = [0, 1].map(|axis| a[axis] + k / parts * along[axis]);
                rim.push(Sample { at, radius: 0.0, weight });
                k += 1.0;
            }
        }
        let some = rim.iter().step_by(4);
        let coarse = disks.len() + some.len();
        let others = rim.iter().enumerate().filter(|(k, _)| k % 4 > 0).map(|(_, sample)| sample);
        let samples = disks.iter().chain(some).chain(others).copied().collect();
        Self { field, samples, coarse, slack: part.slack }
    }

    /// One more place on the rim, where the others missed that another part reaches in.
    pub fn add(&mut self, at: [f64; 2]) {
        let weight = self.samples.last().map_or(1.0, |sample| sample.weight);
        self.samples.push(Sample { at, radius: 0.0, weight });
    }
}

impl Meeting<'_> {
    /// The distance that rims must keep, with what they are simplified by.
    fn distance(&self) -> f64 {
        self.gap + self.probes[0].slack + self.probes[1].slack
    }

    /// Whether extents alone tell that the parts keep their distance.
    pub fn is_apart(&self) -> bool {
        let [s, t] = self.spots;
        let gap = self.distance();
        let is_apart = |k: usize| {
            s.bounds.low[k] >= t.bounds.high[k] + gap || t.bounds.low[k] >= s.bounds.high[k] + gap
        };
        s.sheet != t.sheet || is_apart(0) || is_apart(1)
    }

    pub fn swapped(&self) -> Self {
        let ([a, b], [s, t]) = (self.probes, self.spots);
        Self { probes: [b, a], spots: [t, s], ..*self }
    }

    /// Places of samples of the first part as the second part sees them.
    fn places(&self) -> impl Fn([f64; 2]) -> [f64; 2] + use<> {
        let [s, t] = self.spots;
        let [p, q, r, u] = s.turn.relative_to(&t.turn);
        let [x, y] = t.turn.undo(minus(s.at, t.at));
        move |[px, py]| [p * px + q * py + x, r * px + u * py + y]
    }

    /// Σ weight × how far samples of either part reach in; more than `most` once it is known to be. Coarse: of few samples.
    pub fn overlap(&self, is_coarse: bool, most: f64, work: &mut u64) -> f64 {
        if self.is_apart() {
            return 0.0;
        }
        let mut sum = 0.0;
        for meeting in [*self, self.swapped()] {
            let [a, b] = meeting.probes;
            let place = meeting.places();
            let gap = meeting.distance();
            let count = if is_coarse { a.coarse } else { a.samples.len() };
            *work += count as u64;
            for sample in &a.samples[..count] {
                let inside = gap + sample.radius - b.field.distance(place(sample.at));
                if inside > self.touch {
                    sum += sample.weight * inside;
                    if sum > most {
                        return sum;
                    }
                }
            }
        }
        sum
    }

    /// The overlap, and its slope against shifts of the first part and turns of it about a point.
    pub fn slope(&self, about: [f64; 2], work: &mut u64) -> (f64, [f64; 3]) {
        let mut sum = 0.0;
        let mut slope = [0.0; 3];
        for (meeting, sign) in [(*self, 1.0), (self.swapped(), -1.0)] {
            let [a, b] = meeting.probes;
            let [s, t] = meeting.spots;
            let place = meeting.places();
            let gap = meeting.distance();
            *work += a.samples.len() as u64;
            for sample in &a.samples {
                let (distance, out) = b.field.slope(place(sample.at));
                let inside = gap + sample.radius - distance;
                if inside > self.touch {
                    sum += sample.weight * inside;
                    let out = t.turn.apply(out);
                    let arm = minus(s.place(sample.at), about);
                    let factor = sign * sample.weight;
                    slope[0] -= factor * out[0];
                    slope[1] -= factor * out[1];
                    slope[2] -= factor * cross(arm, out);
                }
            }
        }
        (sum, slope)
    }

    /// Where a sample of the first part reaches deepest into the second.
    pub fn deepest(&self, work: &mut u64) -> Option<Contact> {
        let [a, b] = self.probes;
        let place = self.places();
        let gap = self.distance();
        *work += a.samples.len() as u64;
        let mut deepest = (self.touch, None);
        for sample in &a.samples {
            let inside = gap + sample.radius - b.field.distance(place(sample.at));
            if inside > deepest.0 {
                deepest = (inside, Some(sample.at));
            }
        }
        let own = deepest.1?;
        let [s, t] = self.spots;
        let out = t.turn.apply(b.field.slope(place(own)).1);
        Some(Contact { depth: deepest.0, at: s.place(own), out })
    }
}
