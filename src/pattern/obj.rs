//! Meshes as OBJ: the user's surface with texture coordinates, and the cut as polylines.

use super::attributes::{Normals, line, names, word};
use super::number::exact;
use super::uv_map::{UvMap, faces_by_patch};
use crate::mesh::{CutMesh, Mesh, OpenedMesh, Soup, SurfacePoint, chains};

/// A surface that was cut, and the file that it came from.
#[derive(Clone, Copy, Debug)]
pub struct CutSurface<'a> {
    /// The file as it was read.
    pub soup: &'a Soup,
    /// For each vertex of the mesh its vertex of the file; empty where they are the same.
    pub soup_vertices: &'a [u32],
    /// For each face of the mesh its polygon in the file; empty where groups, materials and normals do not matter.
    pub face_polygons: &'a [u32],
    /// Real size: millimetres of one unit of the file, where it is known.
    pub mm_per_unit: Option<f64>,
    /// The mesh before it was cut.
    pub mesh: &'a Mesh,
    /// The mesh refined along the cut.
    pub cut: &'a CutMesh,
    /// The refined mesh opened there.
    pub opened: &'a OpenedMesh,
}

impl CutSurface<'_> {
    /// The vertex of the file, counted from 0, that a vertex of the mesh came from.
    pub(super) fn soup_vertex(&self, v: usize) -> usize {
        self.soup_vertices.get(v).map_or(v, |&v| v as usize)
    }

    /// Number in an OBJ file, from 1, of each point, when the file's vertices come first and new points follow.
    pub(super) fn point_number(&self, point: u32) -> usize {
        let point = point as usize;
        let own = self.mesh.vertex_count();
        if point < own {
            self.soup_vertex(point) + 1
        } else {
            self.soup.positions.len() + point - own + 1
        }
    }

    /// Where a point lies in the coordinates of the file.
    pub fn place(&self, point: SurfacePoint) -> [f64; 3] {
        let corner = |v: crate::mesh::VertexId| self.soup.positions[self.soup_vertex(v.index())];
        match point {
            SurfacePoint::Vertex(v) => corner(v),
            SurfacePoint::Edge(e, t) => {
                let [a, b] = self.mesh.edge_vertices(e).map(corner);
                [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]))
            }
            SurfacePoint::Face(f, [r, s, t]) => {
                let [a, b, c] = self.mesh.face_vertices(f).map(corner);
                [0, 1, 2].map(|i| r * a[i] + s * b[i] + t * c[i])
            }
        }
    }
}

/// The refined surface with texture coordinates, as OBJ.
///
/// The file's vertices come first, all of them, in their order, and read back bit for bit; the points made by the cut follow.
/// Faces are those of the refined triangulation, group `piece_1`, `piece_2`, … for each patch, with the file's groups as
/// further groups, its materials, and its normals (points on the cut get the mean of their neighbours'). Charts fill the
/// unit square as far as one scale for all allows.
///
/// **Takes** a place for each vertex of the opened surface (NaN for patches without chart: their faces have no texture
/// coordinates), and the length of that unit in units of the file.
pub fn uv_obj(surface: &CutSurface, charts: &[[f64; 2]], chart_unit: f64) -> Vec<u8> {
    let CutSurface { soup, mesh, cut, opened, .. } = *surface;
    let faces_by_patch = faces_by_patch(opened);
    let map = UvMap::new(opened, charts);
    let UvMap { placed, extent, .. } = &map;
    let count = placed.len();
    // Corners that have a place, numbered from 1; 0 for none.
    let mut numbers = vec![0usize; charts.len()];
    for (i, &v) in placed.iter().enumerate() {
        numbers[v as usize] = i + 1;
    }

    let new_points = &cut.points[mesh.vertex_count()..];
    let mut out = String::with_capacity(64 * (soup.positions.len() + charts.len()));
    out += "# Cutflow: surface cut into pieces, with texture coordinates\n";
    out += "# units: as in the input, whose vertices come first, in order and unchanged\n";
    push_size(&mut out, surface.mm_per_unit);
    out += &format!(
        "# {} vertices of the input, {} new on the cut, {count} texture coordinates\n",
        soup.positions.len(),
        new_points.len(),
    );
    out += &format!("# {} faces, {} pieces\n", cut.triangles.len(), opened.patch_count);
    if count > 0 && (extent * chart_unit).is_finite() {
        out += "# uv_scale ";
        exact(&mut out, extent * chart_unit);
        out += " (units of the input per 1 in u and v)\n";
    }
    for &position in &soup.positions {
        write_numbers(&mut out, "v", &position);
    }
    for &point in new_points {
        write_numbers(&mut out, "v", &surface.place(point));
    }
    for &v in placed {
        write_numbers(&mut out, "vt", &map.uv(charts[v as usize]));
    }
    let normals = Normals::new(surface);
    if !surface.face_polygons.is_empty() {
        for normal in soup.normals.iter().chain(&normals.new) {
            write_numbers(&mut out, "vn", normal);
        }
    }
    let mut material = None;
    for (patch, faces) in faces_by_patch.iter().enumerate() {
        let mut group = None;
        for &face in faces {
            let [own_material, own_group] = names(surface, face);
            if group != Some(own_group) {
                group = Some(own_group);
                out += &format!("g piece_{}", patch + 1);
                out += &own_group.map_or(String::new(), |name| format!(" {}", word(name)));
                out.push('\n');
            }
            if material != own_material {
                material = own_material;
                let name = own_material.map_or(String::new(), |name| format!(" {}", line(name)));
                out += &format!("usemtl{name}\n");
            }
            out.push('f');
            for (corner, v) in opened.mesh.triangles()[face].into_iter().enumerate() {
                let point = surface.point_number(opened.vertex_points[v.index()]);
                out += &match (numbers[v.index()], normals.corner(face, corner)) {
                    (0, None) => format!(" {point}"),
                    (0, Some(normal)) => format!(" {point}//{}", normal + 1),
                    (number, None) => format!(" {point}/{number}"),
                    (number, Some(normal)) => format!(" {point}/{number}/{}", normal + 1),
                };
            }
            out.push('\n');
        }
    }
    out.into_bytes()
}

/// Polygon soup as OBJ: everything that it holds, coordinates and order bit for bit.
pub fn mesh_obj(soup: &Soup, mm_per_unit: Option<f64>) -> Vec<u8> {
    let mut out = String::with_capacity(48 * soup.positions.len() + 12 * soup.corners.len());
    out += "# Cutflow: mesh\n";
    push_size(&mut out, mm_per_unit);
    for position in &soup.positions {
        write_numbers(&mut out, "v", position);
    }
    for uv in &soup.texture_coordinates {
        write_numbers(&mut out, "vt", uv);
    }
    for normal in &soup.normals {
        write_numbers(&mut out, "vn", normal);
    }
    let number = |numbers: &[u32], at: usize| {
        numbers.get(at).filter(|&&n| n != u32::MAX).map_or(String::new(), |n| (n + 1).to_string())
    };
    let (mut group, mut material) = (u32::MAX, u32::MAX);
    for i in 0..soup.polygon_count() {
        let changes = [
            ("g", &soup.polygon_groups, &soup.groups, &mut group),
            ("usemtl", &soup.polygon_materials, &soup.materials, &mut material),
        ];
        for (key, numbers, names, current) in changes {
            let Some(&now) = numbers.get(i) else { continue };
            if std::mem::replace(current, now) != now {
                // Without a name there is none from here on.
                let name =
                    names.get(now as usize).map_or(String::new(), |n| format!(" {}", line(n)));
                out += &format!("{key}{name}\n");
            }
        }
        out.push('f');
        for at in soup.starts[i] as usize..soup.starts[i + 1] as usize {
            let texture = number(&soup.texture_corners, at);
            let normal = number(&soup.normal_corners, at);
            out += &format!(" {}", soup.corners[at] + 1);
            out += &match (texture.as_str(), normal.as_str()) {
                ("", "") => String::new(),
                (texture, "") => format!("/{texture}"),
                (texture, normal) => format!("/{texture}/{normal}"),
            };
        }
        out.push('\n');
    }
    out.into_bytes()
}

/// The cut as OBJ polylines in the coordinates of the file, each as long as it can be between junctions.
pub fn cut_obj(surface: &CutSurface) -> Vec<u8> {
    let CutSurface { cut, .. } = *surface;
    // Two cuts that end at one place of the surface's rim do not go on into each other.
    let whole_rim = rim_points(surface);
    let chains = chains(&cut.cut_edges, |point| whole_rim[point as usize]);
    let mut points: Vec<u32> = cut.cut_edges.concat();
    points.sort_unstable();
    points.dedup();
    let number = |point: u32| points.partition_point(|&p| p < point) + 1;
    let mut out = String::from("# Cutflow: the cut, in the units of the input\n");
    push_size(&mut out, surface.mm_per_unit);
    out += &format!("# {} points, {} polylines\no cut\n", points.len(), chains.len());
    for &point in &points {
        write_numbers(&mut out, "v", &surface.place(cut.points[point as usize]));
    }
    for chain in &chains {
        out.push('l');
        for &point in chain {
            out += &format!(" {}", number(point));
        }
        out.push('\n');
    }
    out.into_bytes()
}

/// For each point whether it lies on the boundary of the surface itself.
fn rim_points(surface: &CutSurface) -> Vec<bool> {
    let opened = surface.opened;
    let mut is_rim = vec![false; surface.cut.points.len()];
    for &start in opened.mesh.boundary_loops() {
        for outside in opened.mesh.boundary_loop(start) {
            if opened.partner(outside.twin()).is_none() {
                for v in opened.mesh.edge_vertices(outside.edge()) {
                    is_rim[opened.vertex_points[v.index()] as usize] = true;
                }
            }
        }
    }
    is_rim
}

/// A comment with the real size.
pub(super) fn push_size(out: &mut String, mm_per_unit: Option<f64>) {
    if let Some(mm) = mm_per_unit {
        *out += "# real size: 1 unit = ";
        exact(out, mm);
        *out += " mm\n";
    }
}

pub(super) fn write_numbers(out: &mut String, key: &str, numbers: &[f64]) {
    *out += key;
    for &x in numbers {
        out.push(' ');
        exact(out, x);
    }
    out.push('\n');
}
