//! Where the notches of each seam stand.

use std::fmt;

use super::NotchParams;
use super::sequence::{Group, Reading, is_similar, seams};
use crate::pattern::Pattern;
use crate::pattern::curve::turns;

/// The notches of all seams.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NotchPlan {
    /// By number of the seam, in increasing order; all seams, also those without notches.
    pub seams: Vec<SeamNotches>,
    /// Between the marks of one group.
    pub pair_mm: f64,
    /// By what factor the lengths asked for are reduced, as the model is small; 1 if it is not.
    pub factor: f64,
    /// What could not be had.
    pub notices: Vec<NotchNotice>,
}

/// The notches of one seam, the same for both of its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct SeamNotches {
    /// The seam.
    pub number: usize,
    /// Its length on the surface.
    pub length_mm: f64,
    /// Whether it is closed. Then its first group is the start mark: three marks, which no other group has.
    pub is_closed: bool,
    /// In order along the seam, after the start mark of a closed one.
    pub groups: Vec<Group>,
}

/// What a person should know of the notches. Seams by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotchNotice {
    /// The seam has no room for notches that differ from their reverse and from those of other seams.
    Ambiguous {
        /// The seam.
        number: usize,
    },
    /// A notch stands closer to a corner than it should, because corners are everywhere.
    NearCorner {
        /// The seam.
        number: usize,
    },
}

impl fmt::Display for NotchNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ambiguous { number } => write!(
                f,
                "seam {number} is too short for notches that tell its direction and tell it from others"
            ),
            Self::NearCorner { number } => {
                write!(f, "seam {number} has corners everywhere; a notch stands close to one")
            }
        }
    }
}

impl SeamNotches {
    /// Distances of all single marks from the beginning of the seam, in the order of the groups; those of a closed seam within its
    /// length.
    pub fn marks(&self, pair_mm: f64) -> Vec<f64> {
        let mut marks = Vec::new();
        for group in &self.groups {
            for k in 0..group.count {
                let arc = group.arc_mm + (k as f64 - 0.5 * (group.count as f64 - 1.0)) * pair_mm;
                let is_closed = self.is_closed && self.length_mm > 0.0;
                marks.push(if is_closed { arc.rem_euclid(self.length_mm) } else { arc });
            }
        }
        marks
    }
}

/// Tries per seam; more are only needed by pieces with dozens of equal short seams.
const TRIES: usize = 4000;
/// Shifts of evenly spaced groups, as shares of the distance between them.
const SHIFTS: [f64; 7] = [0.0, -0.2, 0.2, -0.35, 0.35, -0.1, 0.1];

/// Chooses notches for all seams of a pattern, the longest choice of few marks first.
///
/// **Takes** any pattern. **Gives** for each seam groups at about the asked spacing, at least one on every seam longer than
/// `shortest_mm`, none near corners of either side. Read along the seam they differ from their own reverse and from those of
/// every other seam of similar length (5 %) on the same pieces; a seam for which no such choice is found has a notice. Closed seams have a
/// start mark. **Costs** O(s² n) for s seams of n groups, in practice.
pub fn plan(pattern: &Pattern, params: &NotchParams) -> NotchPlan {
    let known = seams(pattern);
    let longest = known.iter().map(|s| s.1).fold(0.0, f64::max);
    let (params, factor) = params.reduced(longest);
    let corners = corners(pattern, &known);
    let mut plan =
        NotchPlan { seams: Vec::new(), pair_mm: params.pair_mm, factor, notices: Vec::new() };
    // Readings of the seams that are done.
    let mut done: Vec<Vec<Group>> = Vec::new();
    for (i, (number, length_mm, is_closed, pieces)) in known.iter().enumerate() {
        let (number, length_mm, is_closed) = (*number, *length_mm, *is_closed);
        let rivals: Vec<Reading<'_>> = (0..i)
            .filter(|&j| {
                let (_, length, closed, others) = &known[j];
                is_similar(length_mm, *length)
                    && is_closed == *closed
                    && pieces.iter().any(|p| others.contains(p))
                    && !plan.seams[j].groups.is_empty()
            })
            .map(|j| Reading { length_mm: known[j].1, groups: &done[j] })
            .collect();
        let mut seam = SeamNotches { number, length_mm, is_closed, groups: Vec::new() };
        if length_mm > params.shortest_mm || is_closed {
            let room = Room::new(length_mm, is_closed, &corners[i], &params);
            let (start, groups, is_sure) = room.choose(&rivals, &params);
            if is_closed {
                seam.groups.push(Group { arc_mm: start, count: 3 });
            }
            let place = |g: &Group| Group { arc_mm: room.place(start, g.arc_mm), ..*g };
            seam.groups.extend(groups.iter().map(place));
            if !is_sure {
                plan.notices.push(NotchNotice::Ambiguous { number });
            }
            if seam.groups.iter().any(|g| room.is_near_corner(g)) {
                plan.notices.push(NotchNotice::NearCorner { number });
            }
        }
        done.push(seam.reading());
        plan.seams.push(seam);
    }
    plan
}

/// For each seam the distances along it at which one of its sides has a corner, ends left out.
fn corners(pattern: &Pattern, known: &[(usize, f64, bool, Vec<usize>)]) -> Vec<Vec<f64>> {
    let mut corners = vec![Vec::new(); known.len()];
    for piece in &pattern.pieces {
        let turns: Vec<Vec<usize>> =
            piece.outlines.iter().map(|outline| turns(&outline.points, true)).collect();
        for seam in &piece.seams {
            let n = piece.outlines[seam.outline].points.len();
            let Ok(i) = known.binary_search_by_key(&seam.number, |k| k.0) else { continue };
            for &turn in &turns[seam.outline] {
                let at = (turn + n - seam.first % n) % n;
                if at <= seam.sides && (seam.is_closed || (at > 0 && at < seam.sides)) {
                    corners[i].push(seam.shared_arc(seam.arcs_mm[at]));
                }
            }
        }
    }
    for arcs in &mut corners {
        arcs.sort_by(f64::total_cmp);
    }
    corners
}

/// A seam with the places where notches must not be.
struct Room<'a> {
    length: f64,
    is_closed: bool,
    corners: &'a [f64],
    /// From ends and corners, and between groups.
    clear: f64,
    pair: f64,
}

impl<'a> Room<'a> {
    fn new(length: f64, is_closed: bool, corners: &'a [f64], params: &NotchParams) -> Self {
        let clear = params.clear_mm.min(0.2 * length);
        Self { length, is_closed, corners, clear, pair: params.pair_mm }
    }

    /// The place of a distance from the start mark.
    fn place(&self, start: f64, arc: f64) -> f64 {
        if self.is_closed { (start + arc).rem_euclid(self.length) } else { arc }
    }

    fn half(&self, count: usize) -> f64 {
        0.5 * (count as f64 - 1.0) * self.pair
    }

    fn is_near_corner(&self, group: &Group) -> bool {
        let far = self.clear + self.half(group.count) - 1e-9;
        self.corners.iter().any(|&c| {
            let off = (group.arc_mm - c).abs();
            off.min(if self.is_closed { self.length - off } else { off }) < far
        })
    }

    /// Groups, start of a closed seam, and whether they are unmistakable.
    fn choose(&self, rivals: &[Reading<'_>], params: &NotchParams) -> (f64, Vec<Group>, bool) {
        let start = if self.is_closed { self.start() } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let wanted = (self.length / params.spacing_mm - 1.0).ceil().clamp(1.0, 1000.0) as usize;
        if self.is_closed && self.length <= params.shortest_mm {
            return (start, Vec::new(), false);
        }
        let mut tries = 0;
        // First away from corners; where those leave no place at all, without regard to them.
        for heed in [true, false] {
            let mut fallback: Option<Vec<Group>> = None;
            for n in [wanted, wanted + 1, wanted + 2, wanted + 3, wanted.saturating_sub(1)] {
                for shift in SHIFTS {
                    let Some(places) = self.places(n, shift, start, heed) else { continue };
                    let mut found = None;
                    sequences(places.len(), if self.is_closed { 2 } else { 3 }, |counts| {
                        tries += 1;
                        let groups: Vec<Group> = places
                            .iter()
                            .zip(counts)
                            .map(|(&arc_mm, &count)| Group { arc_mm, count })
                            .collect();
                        if self.fits(&groups, start, heed) {
                            if fallback.is_none() {
                                fallback = Some(groups.clone());
                            }
                            let own = Reading { length_mm: self.length, groups: &groups };
                            let clash = own.resembles(&own, true, self.pair)
                                || rivals.iter().any(|r| {
                                    [false, true].iter().any(|&b| own.resembles(r, b, self.pair))
                                });
                            if !clash {
                                found = Some(groups);
                            }
                        }
                        found.is_none() && tries < TRIES
                    });
                    if let Some(groups) = found {
                        return (start, groups, true);
                    }
                }
            }
            if let Some(groups) = fallback {
                return (start, groups, false);
            }
            tries = 0;
        }
        (start, Vec::new(), false)
    }

    /// Evenly spaced places, all shifted by a share of their distance, each moved away from corners by no more than half of it. A
    /// single one stands off the middle, or it would not tell the direction.
    fn places(&self, n: usize, shift: f64, start: f64, heed: bool) -> Option<Vec<f64>> {
        if n == 0 {
            return None;
        }
        let step = self.length / (n as f64 + 1.0);
        let off = if n == 1 { 0.2 * (shift - 1.0) } else { shift };
        let mut places = Vec::new();
        for k in 1..=n {
            let wanted = (k as f64 + off) * step;
            let is_free = |at: &f64| {
                let group = Group { arc_mm: self.place(start, *at), count: 1 };
                !heed || !self.is_near_corner(&group)
            };
            let moves = (0..=20).flat_map(|i| [1.0, -1.0].map(|s| s * f64::from(i) * 0.025 * step));
            places.extend(moves.map(|by| wanted + by).find(is_free));
        }
        (!places.is_empty()).then_some(places)
    }

    /// Whether groups keep clear of the ends, of one another and of corners.
    fn fits(&self, groups: &[Group], start: f64, heed: bool) -> bool {
        // The start mark of a closed seam has three marks.
        let edge = self.clear + if self.is_closed { self.half(3) } else { 0.0 } - 1e-9;
        let ends = |g: &Group| {
            let half = self.half(g.count);
            g.arc_mm - half >= edge && g.arc_mm + half <= self.length - edge
        };
        let apart = |pair: &[Group]| {
            let halves = self.half(pair[0].count) + self.half(pair[1].count);
            pair[1].arc_mm - pair[0].arc_mm - halves >= self.clear - 1e-9
        };
        let at = |g: &Group| Group { arc_mm: self.place(start, g.arc_mm), ..*g };
        groups.iter().all(ends)
            && groups.windows(2).all(apart)
            && !(heed && groups.iter().any(|g| self.is_near_corner(&at(g))))
    }

    /// The first place at or after the beginning of a closed seam where a start mark is clear of corners.
    fn start(&self) -> f64 {
        let places = (0..64).map(|i| f64::from(i) / 64.0 * self.length);
        let free = |at: &f64| !self.is_near_corner(&Group { arc_mm: *at, count: 3 });
        places.into_iter().find(free).unwrap_or(0.0)
    }
}

/// Sequences of n counts up to a largest one, those with few marks first, until told to stop. All of them for short ones, for long
/// ones those with up to three groups of more than one mark.
fn sequences(n: usize, largest: usize, mut go_on: impl FnMut(&[usize]) -> bool) {
    let mut counts = vec![1; n];
    if !go_on(&counts) {
        return;
    }
    // Recursively: the next place that has more than one mark.
    fn more(
        counts: &mut Vec<usize>,
        from: usize,
        left: usize,
        largest: usize,
        go_on: &mut dyn FnMut(&[usize]) -> bool,
    ) -> bool {
        if left == 0 {
            return go_on(counts);
        }
        for i in from..counts.len() {
            for count in 2..=largest {
                counts[i] = count;
                let goes_on = more(counts, i + 1, left - 1, largest, go_on);
                counts[i] = 1;
                if !goes_on {
                    return false;
                }
            }
        }
        true
    }
    let most = if n <= 5 { n } else { 3 };
    for special in 1..=most {
        if !more(&mut counts, 0, special, largest, &mut go_on) {
            return;
        }
    }
}
