//! Components by number and by size.

use super::clean::Clean;
use crate::mesh::Soup;
use crate::mesh::doctor::{Shape, keep_polygons};

/// The part of the whole area below which a component is small.
pub(super) const SMALL: f64 = 0.01;

/// For each polygon its component, `u32::MAX` for what belongs to none; and the areas of the components.
fn measure(soup: &Soup) -> (Vec<u32>, Vec<f64>) {
    let clean = Clean::new(soup);
    let shape = Shape::new(&clean.soup, &clean.sides);
    let mut components = vec![u32::MAX; soup.polygon_count()];
    let mut areas = vec![0.0; shape.components];
    for (polygon, &component) in shape.face_components.iter().enumerate() {
        components[clean.origins[polygon] as usize] = component;
        areas[component as usize] += clean.surface.area(&clean.soup, polygon);
    }
    (components, areas)
}

/// Keeps the components that pass, given number, areas and whole area; counts the others. Vertices stay.
fn keep(soup: &Soup, passes: impl Fn(usize, &[f64], f64) -> bool) -> (Soup, usize) {
    let (components, areas) = measure(soup);
    let total = areas.iter().sum();
    let passes = Vec::from_iter((0..areas.len()).map(|i| passes(i, &areas, total)));
    let count = passes.iter().filter(|&&kept| !kept).count();
    if count == 0 {
        return (soup.clone(), 0);
    }
    let is_kept = |i: u32| passes.get(components[i as usize] as usize).is_some_and(|&kept| kept);
    (keep_polygons(soup, is_kept), count)
}

/// Keeps the component with the largest area, the first of several; counts the dropped.
pub fn keep_largest(soup: &Soup) -> (Soup, usize) {
    let (_, areas) = measure(soup);
    let largest = (0..areas.len()).rev().max_by(|&i, &j| areas[i].total_cmp(&areas[j]));
    keep(soup, |i, _, _| Some(i) == largest)
}

/// Keeps one component, numbered as in an [`super::Examination`]; counts the dropped. Changes nothing if there is none of
/// this number.
pub fn keep_component(soup: &Soup, component: u32) -> (Soup, usize) {
    keep(soup, |i, areas, _| i == component as usize || component as usize >= areas.len())
}

/// Drops the components below a hundredth of the whole area; counts them.
pub fn drop_small_components(soup: &Soup) -> (Soup, usize) {
    keep(soup, |i, areas, total| areas[i] >= SMALL * total)
}
