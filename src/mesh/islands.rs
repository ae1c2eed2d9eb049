//! Islands of a texture map: polygons that hang together in it.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::Soup;

const NONE: u32 = u32::MAX;

/// The island of every polygon: connected by edges whose ends have the same texture coordinates on both sides.
///
/// Coordinates are compared by value, exactly: files often repeat them, and writers repeat them digit by digit. Polygons
/// without texture coordinates hang together as if theirs were all the same.
///
/// **Gives** islands numbered by first polygon; `None` if no corner has texture coordinates. **Costs** O(C log C).
pub fn uv_islands(soup: &Soup) -> Option<Vec<u32>> {
    let sides = sides(soup)?;
    let mut parents: Vec<u32> = (0..soup.polygon_count() as u32).collect();
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [a, b] = [pair[0].1, pair[1].1].map(|polygon| root(&mut parents, polygon));
        // The first polygon leads.
        parents[a.max(b) as usize] = a.min(b);
    }
    let mut islands = Vec::with_capacity(parents.len());
    let mut count = 0;
    for polygon in 0..parents.len() as u32 {
        let leader = root(&mut parents, polygon);
        if leader == polygon {
            islands.push(count);
            count += 1;
        } else {
            islands.push(islands[leader as usize]);
        }
    }
    Some(islands)
}

/// The edges along which a texture map is torn, as pairs of vertices, the smaller first, in order: sides of two polygons whose ends
/// have other texture coordinates in the one than in the other. Inside an island too, where it is slit.
///
/// Compared as by [`uv_islands`]. **Gives** `None` if no corner has texture coordinates. **Costs** O(C log C).
pub fn uv_seams(soup: &Soup) -> Option<Vec<[u32; 2]>> {
    let sides = sides(soup)?;
    let ends = |key: &[u32; 4]| [key[0], key[1]];
    let mut seams = Vec::new();
    for edge in sides.chunk_by(|(a, _), (b, _)| ends(a) == ends(b)) {
        if edge.iter().any(|(key, _)| *key != edge[0].0) {
            seams.push(ends(&edge[0].0));
        }
    }
    Some(seams)
}

/// Every side of every polygon with its ends ordered by vertex, the numbers of their values, and its polygon, sorted: the same
/// side of two polygons stands together if the map agrees.
fn sides(soup: &Soup) -> Option<Vec<([u32; 4], u32)>> {
    let corners = soup.corners.len();
    if soup.texture_corners.len() != corners || soup.texture_corners.iter().all(|&t| t == NONE) {
        return None;
    }
    let values = value_numbers(&soup.texture_coordinates);
    let value =
        |corner: usize| values.get(soup.texture_corners[corner] as usize).copied().unwrap_or(NONE);
    let mut sides: Vec<([u32; 4], u32)> = Vec::with_capacity(corners);
    for polygon in 0..soup.polygon_count() {
        let (first, end) = (soup.starts[polygon] as usize, soup.starts[polygon + 1] as usize);
        for corner in first..end {
            let next = if corner + 1 == end { first } else { corner + 1 };
            let (a, b) = (soup.corners[corner], soup.corners[next]);
            let (low, high) = if a <= b { (corner, next) } else { (next, corner) };
            let key = [soup.corners[low], soup.corners[high], value(low), value(high)];
            sides.push((key, polygon as u32));
        }
    }
    sides.sort_unstable();
    Some(sides)
}

/// A number for each coordinate pair, the same for equal ones.
fn value_numbers(coordinates: &[[f64; 2]]) -> Vec<u32> {
    // −0 is 0.
    let bits = |i: u32| coordinates[i as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..coordinates.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (bits(i), i));
    let mut numbers = vec![0; coordinates.len()];
    for same in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
        for &i in same {
            numbers[i as usize] = same[0];
        }
    }
    numbers
}

/// The leader of a polygon's set; halves the way to it.
fn root(parents: &mut [u32], mut polygon: u32) -> u32 {
    while parents[polygon as usize] != polygon {
        let above = parents[parents[polygon as usize] as usize];
        parents[polygon as usize] = above;
        polygon = above;
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four squares in a row of the mesh. The map repeats coordinates, and tears the row after the second.
    fn strip() -> Soup {
        let positions = (0..10).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.0]).collect();
        let mut soup = Soup { positions, starts: vec![0], ..Soup::default() };
        for i in 0..4u32 {
            let [a, b] = [2 * i, 2 * i + 2];
            let shift = if i < 2 { 0.0 } else { 10.0 };
            for v in [a, b, b + 1, a + 1] {
                soup.corners.push(v);
                soup.texture_corners.push(soup.texture_coordinates.len() as u32);
                soup.texture_coordinates.push([f64::from(v / 2) + shift, f64::from(v % 2)]);
            }
            soup.starts.push(soup.corners.len() as u32);
        }
        soup
    }

    #[test]
    fn a_map_torn_in_the_middle_has_two_islands() {
        assert_eq!(uv_islands(&strip()).unwrap(), [0, 0, 1, 1]);
    }

    #[test]
    fn one_end_in_common_is_not_enough() {
        let mut soup = strip();
        // The second square turns away about one end of the side that it shares with the first.
        soup.texture_coordinates[7] = [0.5, 2.0];
        assert_eq!(uv_islands(&soup).unwrap(), [0, 1, 2, 2]);
    }

    #[test]
    fn seams_are_where_the_map_is_torn_slits_included() {
        assert_eq!(uv_seams(&strip()).unwrap(), [[4, 5]]);
        let mut soup = strip();
        // A vertex of the last square moves away: a slit from the end of the strip to its inside.
        soup.texture_coordinates[12] = [13.0, -1.0];
        assert_eq!(uv_seams(&soup).unwrap(), [[4, 5], [6, 7]]);
        soup.texture_corners.fill(NONE);
        assert_eq!(uv_seams(&soup), None);
    }

    #[test]
    fn without_a_map_there_are_none_and_blank_polygons_hang_together() {
        let mut soup = strip();
        soup.texture_corners[8..].fill(NONE);
        assert_eq!(uv_islands(&soup).unwrap(), [0, 0, 1, 1]);
        soup.texture_corners.fill(NONE);
        assert_eq!(uv_islands(&soup), None);
        assert_eq!(uv_islands(&Soup { texture_corners: Vec::new(), ..strip() }), None);
    }
}
