//! The surface that a soup describes once what is said twice or says nothing is left out.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use std::borrow::Cow;

use super::degenerate::{degenerate, harmless};
use super::surface::Surface;
use crate::mesh::Soup;
use crate::mesh::doctor::{Sides, duplicates, keep_polygons, repeated, without_repetitions};

/// A soup without repetitions, duplicates, and polygons without area that nothing hangs on: without these every edge of
/// theirs would look as if it had too many sides.
pub(super) struct Clean<'a> {
    pub soup: Cow<'a, Soup>,
    pub sides: Sides,
    pub surface: Surface,
    /// For each polygon which it is in the soup that was given.
    pub origins: Vec<u32>,
    /// Polygons given that repeat vertices, that repeat others, and that have no area; in increasing order.
    pub repeated: Vec<u32>,
    pub duplicates: Vec<u32>,
    pub degenerate: Vec<u32>,
    /// Whether polygons without area were left out.
    pub hides_degenerate: bool,
}

impl<'a> Clean<'a> {
    pub fn new(given: &'a Soup) -> Self {
        let repeated = repeated(given);
        let mut soup = Cow::Borrowed(given);
        let mut origins = Vec::from_iter(0..given.polygon_count() as u32);
        if !repeated.is_empty() {
            let (kept, from) = without_repetitions(given, &repeated);
            (soup, origins) = (Cow::Owned(kept), from);
        }
        let mut clean = Self {
            sides: Sides::new(&soup),
            surface: Surface::new(&soup),
            soup,
            duplicates: Vec::new(),
            degenerate: Vec::new(),
            hides_degenerate: false,
            repeated,
            origins,
        };
        // What is no polygon once its repetitions are gone has no area.
        let gone = clean.repeated.iter().filter(|i| clean.origins.binary_search(i).is_err());
        clean.degenerate = gone.copied().collect();
        let duplicates = duplicates(&clean.soup);
        clean.duplicates = clean.drop(&duplicates);
        let flat = degenerate(&clean.soup, &clean.surface);
        clean.degenerate.extend(flat.iter().map(|&i| clean.origins[i as usize]));
        clean.degenerate.sort_unstable();
        if flat.len() < clean.soup.polygon_count() {
            let harmless = harmless(&clean.soup, &clean.sides, &flat);
            clean.hides_degenerate = !clean.drop(&harmless).is_empty();
        }
        clean
    }

    /// Leaves polygons out; gives what they are in the soup that was given.
    fn drop(&mut self, faults: &[u32]) -> Vec<u32> {
        if faults.is_empty() {
            return Vec::new();
        }
        let is_fault = |i: u32| faults.binary_search(&i).is_ok();
        self.soup = Cow::Owned(keep_polygons(&self.soup, |i| !is_fault(i)));
        self.sides = Sides::new(&self.soup);
        self.surface = Surface::new(&self.soup);
        let (gone, kept) =
            (0u32..).zip(&self.origins).partition::<Vec<_>, _>(|&(i, _)| is_fault(i));
        let origins = |list: Vec<(u32, &u32)>| Vec::from_iter(list.into_iter().map(|(_, &i)| i));
        let (gone, kept) = (origins(gone), origins(kept));
        self.origins = kept;
        gone
    }
}
