//! Primitives: faces of one group, one material, with or without a chart.

use crate::pattern::attributes::names;
use crate::pattern::obj::CutSurface;
use crate::pattern::uv_map::UvMap;

/// Faces that are drawn at once.
pub(super) struct Part<'a> {
    pub group: Option<&'a str>,
    pub material: Option<&'a str>,
    pub has_chart: bool,
    pub faces: Vec<usize>,
}

/// Groups in the order of their first face, and in each its parts likewise.
pub(super) fn parts<'a>(surface: &CutSurface<'a>, map: &UvMap) -> Vec<Part<'a>> {
    let mut parts: Vec<Part> = Vec::new();
    let mut last = 0;
    for (face, &patch) in surface.opened.face_patches.iter().enumerate() {
        let has_chart = map.has_chart[patch as usize];
        let [material, group] = names(surface, face);
        let is_it = |part: &Part| {
            (part.group, part.material, part.has_chart) == (group, material, has_chart)
        };
        // Faces of one part mostly follow each other.
        if !parts.get(last).is_some_and(is_it) {
            last = parts.iter().position(is_it).unwrap_or(parts.len());
        }
        if last == parts.len() {
            parts.push(Part { group, material, has_chart, faces: Vec::new() });
        }
        parts[last].faces.push(face);
    }
    let groups: Vec<Option<&str>> = parts.iter().map(|part| part.group).collect();
    parts.sort_by_key(|part| groups.iter().position(|&group| group == part.group));
    parts
}

/// Materials of the file with and without texture, in the order of their first part.
pub(super) fn materials<'a>(parts: &[Part<'a>]) -> Vec<(Option<&'a str>, bool)> {
    let mut found = Vec::new();
    for part in parts {
        let material = (part.material, part.has_chart);
        if !found.contains(&material) {
            found.push(material);
        }
    }
    found
}
