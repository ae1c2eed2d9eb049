//! Meshes: the primitives of each, as triangles over one pool of welded vertices.
//!
//! Guaranteed: of an accessor only the elements that triangles use are read, so that many primitives may share a long one;
//! every index is in range; every coordinate finite. Not guaranteed: that triangles have area.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use gltf::json::accessor::Accessor as JsonAccessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::super::ReadError;
use super::super::number::LARGEST;
use super::accessors::{Accessor, Use};
use super::container::{Buffers, unsupported, uses};
use super::{GltfFault, GltfNote, Notes};
use crate::mesh::Welder;

/// "None", as the corners of a soup have it.
pub(super) const NONE: u32 = u32::MAX;

/// The triangles of a mesh in its own coordinates.
#[derive(Default)]
pub(super) struct Triangles {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) corners: Vec<u32>,
    pub(super) texture_coordinates: Vec<[f64; 2]>,
    pub(super) texture_corners: Vec<u32>,
    pub(super) normals: Vec<[f64; 3]>,
    pub(super) normal_corners: Vec<u32>,
    /// For each primitive that has triangles the end of its triangles, and its material.
    pub(super) materials: Vec<(usize, Option<usize>)>,
    /// Number of vertices before welding.
    pub(super) stored: usize,
}

/// What all meshes of a file are read from.
pub(super) struct Source<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) file_bytes: usize,
}

impl<'a> Source<'a> {
    fn accessor(
        &self,
        index: &Index<JsonAccessor>,
        purpose: Use,
    ) -> Result<Accessor<'a>, ReadError> {
        Accessor::new(self.root, self.buffers, index.value(), purpose, self.file_bytes)
    }

    /// An attribute that a mesh can do without.
    fn forgiving(
        &self,
        primitive: &Primitive,
        semantic: &Checked<Semantic>,
        purpose: Use,
    ) -> Result<Option<Accessor<'a>>, ReadError> {
        primitive.attributes.get(semantic).map(|a| self.accessor(a, purpose)).transpose()
    }

    /// An upper bound of the number of triangles of a mesh, from promises that the bytes of the file keep; and whether any
    /// of them has texture coordinates or normals.
    pub(super) fn survey(&self, mesh: usize) -> Result<Survey, ReadError> {
        let mut survey = Survey::default();
        for (index, primitive) in self.root.meshes[mesh].primitives.iter().enumerate() {
            let Some((mode, positions)) = drawn(primitive, mesh, index)? else {
                match primitive.mode {
                    Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => {
                        survey.without_positions += 1;
                    }
                    _ => survey.points_and_lines += 1,
                }
                continue;
            };
            check_compression(self.root, primitive, positions)?;
            let positions = self.accessor(positions, Use::Positions)?;
            let count = match &primitive.indices {
                Some(indices) => self.accessor(indices, Use::Indices)?.count,
                None => positions.count,
            };
            survey.triangles += match mode {
                Mode::TriangleStrip | Mode::TriangleFan => count.saturating_sub(2),
                _ => count / 3,
            } as u64;
            let attributes = &primitive.attributes;
            survey.has_texture |= attributes.contains_key(&TEXTURE);
            survey.has_normals |= attributes.contains_key(&NORMALS);
            survey.morphs += usize::from(primitive.targets.as_ref().is_some_and(|t| !t.is_empty()));
        }
        Ok(survey)
    }

    /// Reads a mesh.
    ///
    /// **Takes** scratch: any number of entries, all [`NONE`]; they are so again afterwards.
    pub(super) fn triangles(
        &self,
        mesh: usize,
        scratch: &mut Vec<u32>,
        notes: &mut Notes,
    ) -> Result<Triangles, ReadError> {
        let mut result = Triangles::default();
        let mut welder = Welder::default();
        for (index, primitive) in self.root.meshes[mesh].primitives.iter().enumerate() {
            let Some((mode, accessor)) = drawn(primitive, mesh, index)? else { continue };
            let positions = self.accessor(accessor, Use::Positions)?;
            let first = result.corners.len();
            let is_fully_used = match &primitive.indices {
                Some(accessor) => {
                    let indices = self.accessor(accessor, Use::Indices)?;
                    let restart = (mode != Mode::Triangles).then(|| indices.restart());
                    let indices = (0..indices.count).map(|i| indices.index(i));
                    assemble(mode, indices, restart, &mut result.corners)
                }
                None => {
                    let count = u32::try_from(positions.count).unwrap_or(NONE);
                    assemble(mode, 0..count, None, &mut result.corners)
                }
            };
            notes.add(GltfNote::LeftOver, usize::from(!is_fully_used));
            if result.corners.len() == first {
                continue;
            }
            let texture = self.forgiving(primitive, &TEXTURE, Use::TextureCoordinates);
            notes.add(GltfNote::TextureUnreadable, usize::from(texture.is_err()));
            let texture = texture.unwrap_or_default();
            let normals = self.forgiving(primitive, &NORMALS, Use::Normals);
            notes.add(GltfNote::NormalsUnreadable, usize::from(normals.is_err()));
            let normals = normals.unwrap_or_default();
            // What the corners name becomes a number in order of first use.
            let mut used = Vec::new();
            for (i, corner) in result.corners[first..].iter_mut().enumerate() {
                let vertex = *corner as usize;
                if vertex >= positions.count {
                    let (face, vertices) = (i / 3, positions.count);
                    let fault = GltfFault::Index { mesh, primitive: index, face, vertex, vertices };
                    return Err(fault.anywhere());
                }
                if vertex >= scratch.len() {
                    scratch.resize(vertex + 1, NONE);
                }
                if scratch[vertex] == NONE {
                    scratch[vertex] = used.len() as u32;
                    used.push(*corner);
                }
                *corner = scratch[vertex];
            }
            for &vertex in &used {
                scratch[vertex as usize] = NONE;
            }
            let own = &mut result.corners[first..];
            add_attribute(
                texture.as_ref(),
                &used,
                own,
                &mut result.texture_coordinates,
                &mut result.texture_corners,
                |uv: [f64; 2]| uv.iter().all(|c| c.abs() <= LARGEST).then(|| [uv[0], 1.0 - uv[1]]),
                || notes.add(GltfNote::TextureNotFinite, 1),
            );
            add_attribute(
                normals.as_ref(),
                &used,
                own,
                &mut result.normals,
                &mut result.normal_corners,
                |n: [f64; 3]| n.iter().all(|c| c.abs() <= LARGEST).then_some(n),
                || notes.add(GltfNote::NormalNotFinite, 1),
            );
            let mut places = Vec::with_capacity(used.len());
            for &vertex in &used {
                let position: [f64; 3] = positions.vector(vertex as usize);
                if let Some(bad) = position.iter().find(|c| !c.is_finite()) {
                    let text = bad.to_string();
                    let fault = GltfFault::Coordinate { mesh, primitive: index, vertex, text };
                    return Err(fault.anywhere());
                }
                places.push(welder.add(position));
            }
            for corner in own {
                *corner = places[*corner as usize];
            }
            result.stored += used.len();
            let material = primitive.material.as_ref().map(Index::value);
            result.materials.push((result.corners.len() / 3, material));
        }
        result.positions = welder.into_places();
        Ok(result)
    }
}

/// What [`Source::survey`] finds in a mesh.
#[derive(Clone, Copy, Default)]
pub(super) struct Survey {
    pub(super) triangles: u64,
    pub(super) has_texture: bool,
    pub(super) has_normals: bool,
    pub(super) points_and_lines: usize,
    pub(super) without_positions: usize,
    pub(super) morphs: usize,
}

const TEXTURE: Checked<Semantic> = Checked::Valid(Semantic::TexCoords(0));
const NORMALS: Checked<Semantic> = Checked::Valid(Semantic::Normals);

/// Mode and positions of a primitive that has triangles; `None` for points and lines, and where there are no positions.
fn drawn(
    primitive: &Primitive,
    mesh: usize,
    index: usize,
) -> Result<Option<(Mode, &Index<JsonAccessor>)>, ReadError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(GltfFault::Mode { mesh, primitive: index }.anywhere());
    };
    let is_drawn = matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
    let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
    Ok(positions.filter(|_| is_drawn).map(|p| (mode, p)))
}

/// Refuses a primitive that is there in compressed form only.
fn check_compression(
    root: &Root,
    primitive: &Primitive,
    positions: &Index<JsonAccessor>,
) -> Result<(), ReadError> {
    const NAME: &str = "KHR_draco_mesh_compression";
    let is_plain = |a: &Index<JsonAccessor>| {
        root.accessors.get(a.value()).is_none_or(|a| a.buffer_view.is_some())
    };
    let is_there = is_plain(positions) && primitive.indices.as_ref().is_none_or(is_plain);
    if !is_there && uses(root, NAME) {
        return Err(unsupported(NAME));
    }
    Ok(())
}

/// Adds the triangles of a list, strip or fan; says whether every index was of use.
///
/// Every other triangle of a strip is turned, so that all have the same side up. Triangles of strips and fans that name a
/// vertex twice are what joins two strips, and are left out.
fn assemble(
    mode: Mode,
    indices: impl Iterator<Item = u32>,
    restart: Option<u32>,
    corners: &mut Vec<u32>,
) -> bool {
    if mode == Mode::Triangles {
        let first = corners.len();
        corners.extend(indices);
        let rest = (corners.len() - first) % 3;
        corners.truncate(corners.len() - rest);
        return rest == 0;
    }
    // The last two indices of a strip; the first and the last of a fan.
    let (mut a, mut b, mut seen) = (0, 0, 0_usize);
    for c in indices {
        if Some(c) == restart {
            seen = 0;
            continue;
        }
        if seen >= 2 && a != b && b != c && c != a {
            let is_turned = mode == Mode::TriangleStrip && seen % 2 == 1;
            corners.extend(if is_turned { [b, a, c] } else { [a, b, c] });
        }
        match (mode, seen) {
            (Mode::TriangleFan, 0) => (a, b) = (c, c),
            (Mode::TriangleFan, _) => b = c,
            _ => (a, b) = (b, c),
        }
        seen += 1;
    }
    true
}

/// Reads the used elements of an attribute and says which one each corner has.
fn add_attribute<const N: usize>(
    accessor: Option<&Accessor>,
    used: &[u32],
    corners: &[u32],
    values: &mut Vec<[f64; N]>,
    value_corners: &mut Vec<u32>,
    accept: impl Fn([f64; N]) -> Option<[f64; N]>,
    mut note: impl FnMut(),
) {
    let mut numbers = Vec::with_capacity(used.len());
    for &vertex in used {
        let vertex = vertex as usize;
        let number = match accessor.filter(|a| vertex < a.count) {
            None => NONE,
            Some(accessor) => match accept(accessor.vector(vertex)) {
                Some(value) => {
                    values.push(value);
                    values.len() as u32 - 1
                }
                None => {
                    note();
                    NONE
                }
            },
        };
        numbers.push(number);
    }
    value_corners.extend(corners.iter().map(|&c| numbers[c as usize]));
}
