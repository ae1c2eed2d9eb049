//! Ambient occlusion and ground shadow from one small volume.
//!
//! The surface is put into a grid of `64³` cells, its inside filled from without, and the grid
//! averaged into a pyramid. A cone of directions is then followed by reading ever coarser levels, which
//! takes half a dozen reads in place of a hundred rays. This shades creases and the ground, it does not
//! measure: features thinner than two cells (1/15 of the ball's radius) are seen as half solid.
//!
//! A running flow moves only points on cuts, *along* the surface, so the volume stays as it is and
//! what was computed for a place is kept.

use super::arrays;
use crate::session::scene::Scene;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Cells along a side. Half as many lose the creases, twice as many take eight times the work.
const CELLS: usize = 64;
/// Half the side of the volume, a little more than the unit ball.
const REACH: f32 = 1.1;
const CELL: f32 = 2.0 * REACH / CELLS as f32;
/// Tangent of the half-angle of a cone: six of them cover the hemisphere.
const SPREAD: f32 = 0.577;
/// How far a cone looks.
const RANGE: f32 = 1.0;
/// What is left of the light above an open place, whose own cells the low cones graze.
const OPEN: f32 = 0.82;
/// Places that are looked at for one picture, a few hundredths of a second's work: more would hold the page up. No mesh takes more than
/// so many pictures.
const AT_ONCE: usize = 6000;
const PICTURES: usize = 16;
/// What a place that has not been looked at yet sees of the sky.
const UNKNOWN: f32 = 0.85;
/// Pixels along a side of the ground shadow. It is soft: more would show nothing.
pub const SHADOW_PIXELS: usize = 80;
/// Half the side of the ground that has a shadow.
pub const SHADOW_REACH: f32 = 1.7;

/// The filled surface, and what was computed from it.
#[derive(Clone, Debug)]
pub struct Occlusion {
    /// Fractions filled, from the finest level of `CELLS³` to coarser ones.
    levels: Vec<Level>,
    ground: f32,
    known: HashMap<[u32; 3], f32>,
    /// What was known before `known` became too large: what is still asked for moves over.
    older: HashMap<[u32; 3], f32>,
    known_limit: usize,
    /// How many places may be looked at for the next picture and for later ones, how many still for this one, and whether one had to be passed
    /// over.
    at_once: [usize; 2],
    left: usize,
    is_behind: bool,
}

#[derive(Clone, Debug)]
struct Level {
    /// Cells along a side, without the border.
    side: usize,
    fill: Vec<f32>,
}

impl Occlusion {
    /// Fills the volume: a few milliseconds.
    pub fn new(scene: &Scene) -> Self {
        let mut levels = vec![fill(scene)];
        while levels[levels.len() - 1].side > 4 {
            levels.push(levels[levels.len() - 1].halved());
        }
        let ground = scene.positions.iter().skip(1).step_by(3).copied().fold(0.0, f32::min);
        let count = scene.vertex_count();
        let at_once = AT_ONCE.max(count.div_ceil(PICTURES));
        Self {
            levels,
            ground,
            known: HashMap::new(),
            older: HashMap::new(),
            known_limit: 3 * count + 1000,
            at_once: [at_once; 2],
            left: at_once,
            is_behind: false,
        }
    }

    /// Height of the ground: the lowest point of the surface.
    pub fn ground(&self) -> f32 {
        self.ground
    }

    /// Another picture begins.
    pub fn begin(&mut self) {
        (self.left, self.is_behind) = (self.at_once[0], false);
        self.at_once[0] = self.at_once[1];
    }

    /// The next picture is to be whole, however long it takes.
    pub fn catch_up(&mut self) {
        self.at_once[0] = usize::MAX;
    }

    /// Whether places were passed over since then: the next picture will show them better.
    pub fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// How much of the sky a point of the surface sees, 0 to 1; a guess where too many are new at once.
    pub fn openness(&mut self, position: Vec3, normal: Vec3) -> f32 {
        let key = position.to_array().map(f32::to_bits);
        if let Some(&openness) = self.known.get(&key) {
            return openness;
        }
        let openness = match self.older.remove(&key) {
            Some(openness) => openness,
            None if self.left == 0 => {
                self.is_behind = true;
                return UNKNOWN;
            }
            None => {
                self.left -= 1;
                self.look(position, normal)
            }
        };
        // A flow leaves a trail of places that no cut passes any more.
        if self.known.len() > self.known_limit {
            self.older = std::mem::take(&mut self.known);
        }
        self.known.insert(key, openness);
        openness
    }

    /// One cone along the normal and five around it, weighted by the cosine.
    fn look(&self, position: Vec3, normal: Vec3) -> f32 {
        let normal = normal.normalize_or(Vec3::Y);
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        // Leave the cells that the surface itself fills.
        let origin = position + normal * (1.25 * CELL);
        let around: f32 = (0..5)
            .map(|i| {
                let (sin, cos) = (i as f32 * std::f32::consts::TAU / 5.0).sin_cos();
                let sideways = tangent * cos + bitangent * sin;
                self.follow(origin, normal * 0.5 + sideways * 0.866)
            })
            .sum();
        let light = 0.25 * self.follow(origin, normal) + 0.15 * around;
        (light / OPEN).min(1.0)
    }

    /// What is left of the light that comes down a cone.
    ///
    /// Each step reads the level whose cells are as wide as the cone. All cones step alike, so that
    /// the change from level to level shows nowhere.
    fn follow(&self, origin: Vec3, direction: Vec3) -> f32 {
        let mut light = 1.0;
        let mut distance = CELL;
        while distance < RANGE {
            let width = (2.0 * SPREAD * distance).max(CELL);
            let level = ((width / CELL).log2().round() as usize).min(self.levels.len() - 1);
            let filled = self.levels[level].at(origin + direction * distance);
            // Far things shade less: the room is not dark, it has walls of its own.
            light *= 1.0 - filled * (1.0 - distance / RANGE);
            distance += 0.7 * width;
        }
        light
    }

    /// The shadow on the ground: darkness of [`SHADOW_PIXELS`]² pixels, rows along z, 0 at the edge.
    pub fn ground_shadow(&self) -> Vec<u8> {
        let pixel = |i: usize| ((i as f32 + 0.5) / SHADOW_PIXELS as f32 * 2.0 - 1.0) * SHADOW_REACH;
        let darkness = |x: f32, z: f32| {
            let place = Vec3::new(x, self.ground, z);
            let fade = 1.0 - Vec2::new(x, z).length() / SHADOW_REACH;
            let fade = (fade * 2.5).clamp(0.0, 1.0);
            // Low cones, since most of what shades the ground stands beside it.
            let around: f32 = (0..8)
                .map(|i| {
                    let (sin, cos) = (i as f32 * std::f32::consts::TAU / 8.0).sin_cos();
                    self.follow(place, Vec3::new(0.75 * cos, 0.66, 0.75 * sin))
                })
                .sum();
            let light = 0.28 * self.follow(place, Vec3::Y) + 0.09 * around;
            // What stands on the ground also hides the brightest part of the sky: a steeper curve.
            (1.0 - light.powf(1.6)) * fade * fade * (3.0 - 2.0 * fade)
        };
        (0..SHADOW_PIXELS * SHADOW_PIXELS)
            .map(|i| darkness(pixel(i % SHADOW_PIXELS), pixel(i / SHADOW_PIXELS)))
            .map(super::color::unit_to_byte)
            .collect()
    }
}

impl Level {
    /// Puts a border of empty cells around `side³` of them, so that reading needs no tests.
    fn new(side: usize, fill: impl Fn([usize; 3]) -> f32) -> Self {
        let row = side + 2;
        let mut bordered = vec![0.0; row.pow(3)];
        for z in 0..side {
            for y in 0..side {
                for x in 0..side {
                    bordered[((z + 1) * row + y + 1) * row + x + 1] = fill([x, y, z]);
                }
            }
        }
        Self { side, fill: bordered }
    }

    fn cell(&self, [x, y, z]: [usize; 3]) -> f32 {
        let row = self.side + 2;
        self.fill[((z + 1) * row + y + 1) * row + x + 1]
    }

    /// Trilinear between the centres of cells, empty outside.
    fn at(&self, place: Vec3) -> f32 {
        let side = self.side as f32;
        let p = (place / (2.0 * REACH) + 0.5) * side + 0.5;
        let p = p.clamp(Vec3::ZERO, Vec3::splat(side + 0.999));
        let t = p.fract();
        let row = self.side + 2;
        let corner = ((p.z as usize) * row + p.y as usize) * row + p.x as usize;
        let along_x = |start: usize| self.fill[start] * (1.0 - t.x) + self.fill[start + 1] * t.x;
        let along_y = |start| along_x(start) * (1.0 - t.y) + along_x(start + row) * t.y;
        along_y(corner) * (1.0 - t.z) + along_y(corner + row * row) * t.z
    }

    fn halved(&self) -> Self {
        Self::new(self.side / 2, |corner| {
            let child = |i: usize| [0, 1, 2].map(|axis| 2 * corner[axis] + (i >> axis & 1));
            (0..8).map(|i| self.cell(child(i))).sum::<f32>() / 8.0
        })
    }
}

/// Half for cells that the surface passes, 1 for those that cannot be reached from outside.
///
/// An open surface leaks and is left as a shell, which shades less but not wrongly.
fn fill(scene: &Scene) -> Level {
    const EMPTY: u8 = 0;
    const PASSED: u8 = 1;
    const OUTSIDE: u8 = 2;
    let mut cells = vec![EMPTY; CELLS.pow(3)];
    let index = |[x, y, z]: [usize; 3]| (z * CELLS + y) * CELLS + x;
    for corners in arrays::triangles(scene) {
        let [a, b, c] = corners.map(|vertex| arrays::position(scene, vertex));
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        // Samples no further apart than half a cell.
        let steps = ((longest / CELL * 2.0).ceil() as usize).clamp(1, 4 * CELLS);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (u, v) = (i as f32 / steps as f32, j as f32 / steps as f32);
                let place = a + (b - a) * u + (c - a) * v;
                // `as` saturates, so that a surface larger than promised stays within the grid.
                let cell = (place / CELL + CELLS as f32 / 2.0).to_array().map(|x| x as usize);
                cells[index(cell.map(|x| x.min(CELLS - 1)))] = PASSED;
            }
        }
    }
    // The rim of the grid is outside: the ball does not reach it.
    let mut stack = vec![[0, 0, 0]];
    while let Some(cell) = stack.pop() {
        if std::mem::replace(&mut cells[index(cell)], OUTSIDE) == OUTSIDE {
            continue;
        }
        for axis in 0..3 {
            for forward in [false, true] {
                let mut next = cell;
                next[axis] = if forward { cell[axis] + 1 } else { cell[axis].wrapping_sub(1) };
                if next[axis] < CELLS && cells[index(next)] == EMPTY {
                    stack.push(next);
                }
            }
        }
    }
    let fraction = |cell: u8| match cell {
        OUTSIDE => 0.0,
        PASSED => 0.5,
        _ => 1.0,
    };
    Level::new(CELLS, |cell| fraction(cells[index(cell)]))
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::unit_ball;
    use super::*;

    #[test]
    fn a_ball_is_filled_to_its_volume() {
        let level = fill(&unit_ball(4, 0));
        let filled: f32 = level.fill.iter().sum::<f32>() * CELL.powi(3);
        let volume = 4.0 / 3.0 * std::f32::consts::PI;
        // Cells on the surface count half, whatever their true share: a few parts in a hundred.
        assert!((filled / volume - 1.0).abs() < 0.03, "{filled} of {volume}");
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "exact by construction")]
    fn averaging_keeps_the_mean() {
        let fine = fill(&unit_ball(3, 0));
        let coarse = fine.halved();
        let mean = |level: &Level| level.fill.iter().sum::<f32>() / level.side.pow(3) as f32;
        assert!((mean(&fine) - mean(&coarse)).abs() < 1e-4);
        assert_eq!(fine.at(Vec3::ZERO), 1.0);
        assert_eq!(fine.at(Vec3::splat(50.0)), 0.0);
    }

    #[test]
    fn a_ball_sees_all_of_the_sky_and_its_inside_none() {
        let scene = unit_ball(4, 0);
        let mut occlusion = Occlusion::new(&scene);
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::ONE.normalize()] {
            let outside = occlusion.openness(direction, direction);
            assert!(outside > 0.93, "{direction}: {outside}");
        }
        assert!(occlusion.openness(Vec3::ZERO, Vec3::Y) < 0.05);
    }

    #[test]
    fn the_shadow_is_darkest_under_the_ball_and_gone_at_the_edge() {
        let occlusion = Occlusion::new(&unit_ball(4, 0));
        let shadow = occlusion.ground_shadow();
        let at = |x: usize, z: usize| shadow[z * SHADOW_PIXELS + x];
        let middle = SHADOW_PIXELS / 2;
        assert!(at(middle, middle) > 150);
        assert!(at(middle, middle) > at(middle + 16, middle));
        assert!(at(middle + 16, middle) > at(middle + 30, middle));
        assert!((0..SHADOW_PIXELS).all(|i| at(i, 0) == 0 && at(0, i) == 0));
        assert!((occlusion.ground() + 1.0).abs() < 1e-5);
    }
}
