//! Texture coordinates, normals, groups and materials of a soup while it is being read: arrays that stay empty until a
//! file uses them.
//!
//! Guaranteed: what is left empty costs nothing; names are numbered in order of first use. Not guaranteed: that a name is
//! used by more than one polygon.

use std::collections::BTreeMap;

use super::{Place, ReadNotice, note, number, to_u32};
use crate::mesh::Soup;

/// "None", in all index arrays of a soup.
pub(super) const NONE: u32 = u32::MAX;

/// Appends to an array that has an entry for each corner, or for each polygon, or stays empty as long as all are [`NONE`].
/// `length` is the number of entries before, `room` that for which to reserve when it begins.
#[inline]
pub(super) fn push(array: &mut Vec<u32>, value: u32, length: usize, room: usize) {
    if array.is_empty() {
        if value == NONE {
            return;
        }
        array.reserve_exact(room.max(length + 1));
        array.resize(length, NONE);
    }
    array.push(value);
}

/// Takes away from each corner the attribute whose index is out of range or whose numbers are not finite, and leaves only
/// finite numbers.
///
/// **Gives** the first corner out of range with its index, and the number of such corners.
pub(super) fn settle<const N: usize>(
    values: &mut [[f64; N]],
    corners: &mut Vec<u32>,
) -> Option<(usize, u32, usize)> {
    let mut first = None;
    let mut count = 0;
    for (corner, i) in corners.iter_mut().enumerate() {
        if *i == NONE {
            continue;
        }
        match values.get(*i as usize) {
            Some(value) if !value[0].is_nan() => {}
            Some(_) => *i = NONE,
            None => {
                first.get_or_insert((corner, *i));
                count += 1;
                *i = NONE;
            }
        }
    }
    for value in values.iter_mut().filter(|value| value[0].is_nan()) {
        *value = [0.0; N];
    }
    if values.is_empty() {
        corners.clear();
    }
    first.map(|(corner, i)| (corner, i, count))
}

/// Numbers that are all finite; otherwise what marks them until [`settle`], and a notice about this `noun`.
pub(super) fn or_broken<const N: usize>(
    value: Option<[f64; N]>,
    notice: &mut Option<ReadNotice>,
    kind: &'static str,
    noun: &str,
    place: Place,
) -> [f64; N] {
    value.unwrap_or_else(|| {
        note(notice, kind, place, || format!("{noun} is not a number, ignored"));
        [f64::NAN; N]
    })
}

/// Longest part of a name that counts, bytes: comparing names must not take longer than reading them.
const LONGEST_NAME: usize = 256;

/// Names in order of first use.
#[derive(Default)]
pub(super) struct Names<'a> {
    numbers: BTreeMap<&'a [u8], u32>,
    names: Vec<String>,
    /// The last one asked for: most polygons ask for the same as the one before.
    last: Option<(&'a [u8], u32)>,
}

impl<'a> Names<'a> {
    /// The number of a name, [`NONE`] for an empty one.
    pub(super) fn number(&mut self, name: &'a [u8]) -> u32 {
        if name.is_empty() {
            return NONE;
        }
        // The same slice, not the same letters: no comparison of long names for each polygon.
        if let Some((last, i)) = self.last
            && std::ptr::eq(last, name)
        {
            return i;
        }
        let short = &name[..name.len().min(LONGEST_NAME)];
        let i = *self.numbers.entry(short).or_insert_with(|| {
            self.names.push(number::name(name));
            to_u32(self.names.len() - 1)
        });
        self.last = Some((name, i));
        i
    }

    /// All names.
    pub(super) fn into_names(self) -> Vec<String> {
        self.names
    }
}

/// Gives the corners of a soup the texture coordinates and normals of their vertices, unless they have their own.
pub(super) fn of_vertices(soup: &mut Soup) {
    if !soup.texture_coordinates.is_empty() && soup.texture_corners.is_empty() {
        soup.texture_corners.clone_from(&soup.corners);
    }
    if !soup.normals.is_empty() && soup.normal_corners.is_empty() {
        soup.normal_corners.clone_from(&soup.corners);
    }
    settle(&mut soup.texture_coordinates, &mut soup.texture_corners);
    settle(&mut soup.normals, &mut soup.normal_corners);
}
