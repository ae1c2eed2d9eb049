//! A soup made from another, polygon by polygon, with everything that belongs to polygons and corners.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use crate::mesh::Soup;

/// One corner of a polygon with what belongs to it. `u32::MAX` for no texture coordinate or normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// The vertex.
    pub vertex: u32,
    /// Index into [`Soup::texture_coordinates`].
    pub texture: u32,
    /// Index into [`Soup::normals`].
    pub normal: u32,
}

impl Corner {
    /// A corner of which nothing but the vertex is known.
    pub fn bare(vertex: u32) -> Self {
        Self { vertex, texture: u32::MAX, normal: u32::MAX }
    }

    /// The corner of a soup with this index.
    pub fn of(soup: &Soup, corner: usize) -> Self {
        let at = |list: &[u32]| list.get(corner).copied().unwrap_or(u32::MAX);
        Self {
            vertex: soup.corners[corner],
            texture: at(&soup.texture_corners),
            normal: at(&soup.normal_corners),
        }
    }
}

/// A copy of a soup under way: all of its vertices, and the polygons given so far.
pub struct Rebuild<'a> {
    source: &'a Soup,
    result: Soup,
}

impl<'a> Rebuild<'a> {
    /// Starts with the vertices and tables of a soup and without polygons.
    pub fn new(source: &'a Soup) -> Self {
        let result = Soup {
            positions: source.positions.clone(),
            starts: vec![0],
            texture_coordinates: source.texture_coordinates.clone(),
            normals: source.normals.clone(),
            groups: source.groups.clone(),
            materials: source.materials.clone(),
            ..Soup::default()
        };
        Self { source, result }
    }

    /// Appends a vertex.
    pub fn add_vertex(&mut self, position: [f64; 3]) -> u32 {
        self.result.positions.push(position);
        (self.result.positions.len() - 1) as u32
    }

    /// A corner at a vertex between two corners of a polygon, `t` of the way from `a` to `b`: texture coordinates between
    /// theirs where both have some; no normal.
    pub fn between(&mut self, a: Corner, b: Corner, t: f64, vertex: u32) -> Corner {
        let uv = |corner: Corner| self.result.texture_coordinates.get(corner.texture as usize);
        let mut corner = Corner::bare(vertex);
        if let (Some(&p), Some(&q)) = (uv(a), uv(b)) {
            corner.texture = self.result.texture_coordinates.len() as u32;
            let at = [0, 1].map(|i| p[i] + t * (q[i] - p[i]));
            self.result.texture_coordinates.push(at);
        }
        corner
    }

    /// Appends a polygon that has line, group and material of polygon `like` of the source.
    pub fn polygon(&mut self, like: usize, corners: impl IntoIterator<Item = Corner>) {
        for corner in corners {
            self.result.corners.push(corner.vertex);
            if !self.source.texture_corners.is_empty() {
                self.result.texture_corners.push(corner.texture);
            }
            if !self.source.normal_corners.is_empty() {
                self.result.normal_corners.push(corner.normal);
            }
        }
        self.result.starts.push(self.result.corners.len() as u32);
        let follow = |list: &[u32], out: &mut Vec<u32>| out.extend(list.get(like));
        follow(&self.source.lines, &mut self.result.lines);
        follow(&self.source.polygon_groups, &mut self.result.polygon_groups);
        follow(&self.source.polygon_materials, &mut self.result.polygon_materials);
    }

    /// Appends polygon `i` of the source as it is.
    pub fn keep(&mut self, i: usize) {
        let source = self.source;
        let corners = source.starts[i] as usize..source.starts[i + 1] as usize;
        self.polygon(i, corners.map(|corner| Corner::of(source, corner)));
    }

    /// Ends the work.
    pub fn finish(self) -> Soup {
        self.result
    }
}
