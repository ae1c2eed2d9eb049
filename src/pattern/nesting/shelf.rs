//! Parts side by side in rows: a layout without any search, so that there always is one.

use super::part::{Part, Spot};
use super::room::Room;

/// Rows of parts, the highest first, from the lower left.
pub(super) fn rows(parts: &[Part], room: &Room) -> Vec<Spot> {
    let height = |i: usize| parts[i].fits[0].size()[1];
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|&i, &j| height(j).total_cmp(&height(i)));
    let [mut width, full] = room.inner();
    if !width.is_finite() {
        let tiles = parts.iter().map(|part| part.fits[0].size().map(|x| x + room.gap));
        width = tiles.map(|[w, h]| w * h).sum::<f64>().sqrt();
    }
    let mut spots: Vec<Option<Spot>> = vec![None; parts.len()];
    let (mut sheet, mut x, mut y, mut row) = (0, 0.0, 0.0, 0.0_f64);
    for i in order {
        let fit = &parts[i].fits[0];
        let [w, h] = fit.size();
        if x > 0.0 && x + w > width {
            y += row + room.gap;
            (x, row) = (0.0, 0.0);
        }
        if y > 0.0 && y + h > full {
            sheet += 1;
            (x, y, row) = (0.0, 0.0, 0.0);
        }
        spots[i] = Some(Spot::new(sheet, fit, [room.margin + x, room.margin + y]));
        x += w + room.gap;
        row = row.max(h);
    }
    spots.into_iter().flatten().collect()
}
