//! The doctor of meshes: what is wrong with polygon soup, and repairs.
//!
//! **Problem.** Given polygons in space, find all places where they are no oriented manifold with a metric, or one that
//! will give trouble, and change as little as possible so that they are one. What needs no places is found and done in
//! [`crate::mesh::doctor`]; here is what measures, and the two entrances: [`examine`] and [`repair`] (one repair) or
//! [`repair_all`] (those that are needed before any method can work).
//!
//! Guaranteed: after [`repair_all`] the triangles of the polygons are accepted by [`crate::mesh::Mesh::new`], or there is no
//! polygon left; what holds for all repairs, see [`crate::mesh::doctor`]; nothing depends on scale or place.
//!
//! Not guaranteed: that surfaces do not pass through each other, which nothing here looks at; that a single repair
//! leaves no defect of another kind ([`repair_all`] repeats them).

mod clean;
mod degenerate;
mod edges;
mod examine;
mod holes;
mod orient;
mod parts;
mod polygons;
mod surface;
mod weld;

use self::degenerate::degenerate;
use self::surface::Surface;
use crate::mesh::doctor::{
    Repair, Shape, Sides, drop_duplicates, drop_isolated, drop_repeated, duplicates,
    open_one_sided, repeated, split_vertices,
};
use crate::mesh::{Mesh, Soup};

pub use degenerate::drop_degenerate;
pub use edges::split_edges;
pub use examine::{BoundaryLoop, Component, Examination, examine};
pub use holes::fill_holes;
pub use orient::{orient, turn_inside_out};
pub use parts::{drop_small_components, keep_component, keep_largest};
pub use polygons::split_polygons;
pub use weld::weld;

/// Rounds of [`repair_all`]. The second one finds what the first has uncovered; more are rare.
const ROUNDS: usize = 6;

/// Does one repair. **Gives** the soup and in how many places it changed; what is counted follows from the repair.
pub fn repair(soup: &Soup, repair: Repair) -> (Soup, usize) {
    match repair {
        Repair::DropRepeated => drop_repeated(soup),
        Repair::DropDuplicates => drop_duplicates(soup),
        Repair::DropDegenerate => drop_degenerate(soup),
        Repair::Weld { tolerance } => weld(soup, tolerance),
        Repair::SplitEdges => split_edges(soup),
        Repair::SplitVertices => split_vertices(soup),
        Repair::OpenOneSided => open_one_sided(soup),
        Repair::Orient => orient(soup),
        Repair::SplitPolygons => split_polygons(soup),
        Repair::DropIsolated => drop_isolated(soup),
        Repair::KeepLargest => keep_largest(soup),
        Repair::KeepComponent { component } => keep_component(soup, component),
        Repair::DropSmallComponents => drop_small_components(soup),
        Repair::FillHoles { max_edges } => fill_holes(soup, max_edges),
        Repair::TurnInsideOut => turn_inside_out(soup),
    }
}

/// Does what must be done before any method can work, and names what it did with the number of places, in order.
///
/// A soup that has fallen apart is welded once, before anything is split. The rest is repeated until nothing changes.
/// Surfaces whose neighbours agree are not turned, even where they face inward. Vertices keep their numbers.
pub fn repair_all(soup: &Soup) -> (Soup, Vec<(Repair, usize)>) {
    let mut result = soup.clone();
    let mut done: Vec<(Repair, usize)> = Vec::new();
    let mut apply = |result: &mut Soup, one: Repair| {
        let (changed, count) = repair(result, one);
        if count > 0 {
            *result = changed;
            match done.iter_mut().find(|(other, _)| *other == one) {
                Some((_, sum)) => *sum += count,
                None => done.push((one, count)),
            }
        }
        count > 0
    };
    apply(&mut result, Repair::DropRepeated);
    apply(&mut result, Repair::DropDuplicates);
    if let Some(tolerance) = examine::recommended_weld(&result) {
        apply(&mut result, Repair::Weld { tolerance });
    }
    for round in 0..2 * ROUNDS {
        // Should taking out triangles without area ever undo what another repair does, that one wins.
        let drops_flat = round < ROUNDS;
        if is_sound(&result, drops_flat) {
            break;
        }
        apply(&mut result, Repair::DropRepeated);
        apply(&mut result, Repair::DropDuplicates);
        if drops_flat && apply(&mut result, Repair::DropDegenerate) {
            apply(&mut result, Repair::DropDuplicates);
        }
        for one in [Repair::SplitEdges, Repair::SplitVertices, Repair::OpenOneSided] {
            apply(&mut result, one);
        }
        if !Shape::new(&result, &Sides::new(&result)).disagreeing.is_empty() {
            apply(&mut result, Repair::Orient);
        }
        apply(&mut result, Repair::SplitPolygons);
    }
    (result, done)
}

/// The triangles of all polygons, one polygon after the other, and the polygon of each.
pub fn triangles(soup: &Soup) -> (Vec<[u32; 3]>, Vec<u32>) {
    let count = soup.corners.len().saturating_sub(2 * soup.polygon_count());
    let (mut triangles, mut polygons) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for i in 0..soup.polygon_count() {
        super::polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
        polygons.resize(triangles.len(), u32::try_from(i).unwrap_or(u32::MAX));
    }
    (triangles, polygons)
}

/// Whether nothing is left to be done that must be done.
fn is_sound(soup: &Soup, drops_flat: bool) -> bool {
    if soup.polygon_count() == 0 {
        return true;
    }
    let is_surface = makes_a_mesh(soup) && repeated(soup).is_empty() && duplicates(soup).is_empty();
    is_surface && (!drops_flat || degenerate(soup, &Surface::new(soup)).is_empty())
}

/// Whether the triangles of the polygons make a [`Mesh`].
fn makes_a_mesh(soup: &Soup) -> bool {
    Mesh::new(soup.positions.len(), &triangles(soup).0).is_ok()
}
