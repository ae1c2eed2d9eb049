//! The tree of nodes: which meshes are drawn, and where.
//!
//! Guaranteed: each node is visited at most once, without recursion; transforms are products in double precision and
//! finite. Not guaranteed: that a transform can be undone.

use gltf::json::scene::Node;
use gltf::json::{Index, Root};

use super::super::ReadError;
use super::{GltfFault, GltfNote, Notes};

/// An affine map: three columns, then the translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine([[f64; 3]; 4]);

impl Affine {
    pub(super) const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]);

    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let Self([.., t]) = self;
        let v = self.direction(p);
        [v[0] + t[0], v[1] + t[1], v[2] + t[2]]
    }

    fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        let Self([x, y, z, _]) = self;
        [0, 1, 2].map(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2])
    }

    fn times(&self, inner: &Self) -> Self {
        let Self([x, y, z, t]) = inner;
        Self([self.direction(*x), self.direction(*y), self.direction(*z), self.point(*t)])
    }

    /// The columns of the inverse transpose up to a positive factor: what moves normals. `None` where the map flattens.
    pub(super) fn for_normals(&self) -> Option<[[f64; 3]; 3]> {
        let (cofactors, determinant) = self.cofactors();
        let sign = determinant.signum();
        self.side()?;
        Some(cofactors.map(|column| column.map(|c| sign * c)))
    }

    /// Whether the map turns outside in; `None` where it flattens, so that there is no inside.
    pub(super) fn side(&self) -> Option<bool> {
        let Self([x, y, z, _]) = self.scaled();
        let (_, determinant) = self.cofactors();
        let volume: f64 = [x, y, z].iter().map(|c| dot(c, c).sqrt()).product();
        // Rounding leaves some 1e-15 of the volume of the box in place of 0, and transforms of 32 bits some 1e-7 that is
        // meant.
        (determinant.abs() > 1e-12 * volume).then_some(determinant < 0.0)
    }

    /// The linear part with its largest entry 1, so that products neither overflow nor vanish.
    fn scaled(&self) -> Self {
        let Self([x, y, z, _]) = self;
        let largest = x.iter().chain(y).chain(z).fold(0.0, |m: f64, c| m.max(c.abs()));
        let scale = |v: &[f64; 3]| v.map(|c| if largest > 0.0 { c / largest } else { 0.0 });
        Self([scale(x), scale(y), scale(z), [0.0; 3]])
    }

    fn cofactors(&self) -> ([[f64; 3]; 3], f64) {
        let Self([x, y, z, _]) = self.scaled();
        let cofactors = [cross(&y, &z), cross(&z, &x), cross(&x, &y)];
        (cofactors, dot(&x, &cofactors[0]))
    }

    fn is_finite(&self) -> bool {
        self.0.as_flattened().iter().all(|c| c.is_finite())
    }
}

pub(super) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A mesh in its place.
pub(super) struct Draw {
    /// The node; `None` where the file has no nodes at all.
    pub(super) node: Option<usize>,
    pub(super) mesh: usize,
    pub(super) transform: Affine,
}

/// The meshes of the scene, in the order of the tree: the default scene, else the first, else all nodes; and where there
/// are no nodes, all meshes.
pub(super) fn draws(root: &Root, notes: &mut Notes) -> Result<Vec<Draw>, ReadError> {
    if root.nodes.is_empty() {
        let meshes = 0..root.meshes.len();
        return Ok(meshes
            .map(|mesh| Draw { node: None, mesh, transform: Affine::IDENTITY })
            .collect());
    }
    let mut draws = Vec::new();
    let mut is_reached = vec![false; root.nodes.len()];
    let mut stack = Vec::new();
    push(root, &roots(root)?, Affine::IDENTITY, &mut is_reached, &mut stack)?;
    while let Some((index, outer)) = stack.pop() {
        let node = &root.nodes[index];
        let fault = |problem: &str| GltfFault::element("node", index, problem.into());
        let transform = outer.times(&local(node).ok_or_else(|| fault("its matrix is not affine"))?);
        if !transform.is_finite() {
            return Err(fault("its transform is not finite"));
        }
        if let Some(mesh) = &node.mesh {
            let mesh = mesh.value();
            if mesh >= root.meshes.len() {
                return Err(fault(&format!("mesh {mesh} does not exist")));
            }
            draws.push(Draw { node: Some(index), mesh, transform });
            notes.add(GltfNote::Skins, usize::from(node.skin.is_some()));
        }
        let children = node.children.as_deref().unwrap_or_default();
        push(root, children, transform, &mut is_reached, &mut stack)?;
    }
    let is_left_out = |(node, reached): &(&Node, &bool)| node.mesh.is_some() && !**reached;
    notes.add(
        GltfNote::OutsideScene,
        root.nodes.iter().zip(&is_reached).filter(is_left_out).count(),
    );
    Ok(draws)
}

fn roots(root: &Root) -> Result<Vec<Index<Node>>, ReadError> {
    let index = root.scene.as_ref().map_or(0, Index::value);
    if let Some(scene) = root.scenes.get(index) {
        return Ok(scene.nodes.clone());
    }
    if root.scene.is_some() {
        return Err(GltfFault::element("scene", index, "does not exist".into()));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let roots: Vec<_> =
        (0..).zip(&is_child).filter(|(_, c)| !**c).map(|(i, _)| Index::new(i)).collect();
    if roots.is_empty() {
        return Err(GltfFault::Cycle { node: 0 }.anywhere());
    }
    Ok(roots)
}

/// Puts nodes on the stack, the first one on top. None may have been there before.
fn push(
    root: &Root,
    nodes: &[Index<Node>],
    outer: Affine,
    is_reached: &mut [bool],
    stack: &mut Vec<(usize, Affine)>,
) -> Result<(), ReadError> {
    for node in nodes.iter().rev().map(Index::value) {
        match is_reached.get_mut(node) {
            None => {
                let problem = format!("does not exist, there are {}", root.nodes.len());
                return Err(GltfFault::element("node", node, problem));
            }
            Some(true) => return Err(GltfFault::Cycle { node }.anywhere()),
            Some(is_reached) => *is_reached = true,
        }
        stack.push((node, outer));
    }
    Ok(())
}

/// The transform of a node against its parent; `None` for a matrix that is not affine.
fn local(node: &Node) -> Option<Affine> {
    if let Some(matrix) = &node.matrix {
        let m = matrix.map(f64::from);
        let is_affine = [m[3], m[7], m[11], m[15] - 1.0].iter().all(|c| *c == 0.0);
        let columns = [0, 4, 8, 12].map(|i| [m[i], m[i + 1], m[i + 2]]);
        return is_affine.then_some(Affine(columns));
    }
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let [x, y, z] = rotation(node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0));
    let translation = node.translation.unwrap_or_default().map(f64::from);
    let times = |v: [f64; 3], s: f64| v.map(|c| c * s);
    Some(Affine([times(x, scale[0]), times(y, scale[1]), times(z, scale[2]), translation]))
}

/// The columns of a rotation. The quaternion is made a unit first, since single precision leaves it 1e-7 off; 0 is no
/// rotation.
fn rotation(quaternion: [f32; 4]) -> [[f64; 3]; 3] {
    let [x, y, z, w] = quaternion.map(f64::from);
    let square = x * x + y * y + z * z + w * w;
    let s = if square > 0.0 { 2.0 / square } else { 0.0 };
    [
        [1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)],
        [s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)],
        [s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_y_takes_x_to_minus_z() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let [x, y, z] = rotation([0.0, half, 0.0, half]);
        // Rounding of the products, some units of 2e-16.
        let is_near =
            |a: [f64; 3], b: [f64; 3]| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(
            is_near(x, [0.0, 0.0, -1.0])
                && is_near(y, [0.0, 1.0, 0.0])
                && is_near(z, [1.0, 0.0, 0.0])
        );
    }

    #[test]
    fn sides_are_told_at_any_scale_and_flat_maps_have_none() {
        let map = |x: f64, y: f64, z: f64| {
            Affine([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [5.0; 3]])
        };
        for scale in [1e-200, 1e-7, 1.0, 1e200] {
            assert_eq!(map(scale, scale, scale).side(), Some(false), "{scale}");
            assert_eq!(map(scale, -scale, scale).side(), Some(true), "{scale}");
        }
        assert_eq!(map(1.0, 1e-6, 1.0).side(), Some(false));
        assert_eq!(map(0.0, 0.0, 0.0).side(), None);
        assert_eq!(map(1.0, 1.0, 0.0).side(), None);
        let flat = Affine([[1.0, 2.0, 3.0], [0.1, 0.2, 0.3], [0.0, 1.0, 0.0], [0.0; 3]]);
        assert_eq!(flat.side(), None);
    }
}
