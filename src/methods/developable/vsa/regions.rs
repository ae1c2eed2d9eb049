//! Regions with their proxies, errors and seeds.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::flood::{Flood, NONE};

/// Regions: each hangs together and has its seed.
#[derive(Clone)]
pub(super) struct Regions {
    /// Region of every face.
    pub charts: Vec<u32>,
    /// N of every region.
    pub proxies: Vec<Vector3<f64>>,
    seeds: Vec<u32>,
    /// Σ a n and Σ a.
    sums: Vec<(Vector3<f64>, f64)>,
}

/// E of a region with these sums.
fn error_of((sum, area): &(Vector3<f64>, f64)) -> f64 {
    // Rounding must not make flat regions better than flat.
    (2.0 * (area - sum.norm())).max(0.0)
}

impl Regions {
    /// Faces of one label that hang together are a region.
    pub fn of_labels(flood: &Flood, labels: &[u32]) -> Self {
        let mut charts = vec![NONE; labels.len()];
        let mut seeds = Vec::new();
        let mut stack = Vec::new();
        for start in 0..labels.len() {
            if charts[start] != NONE {
                continue;
            }
            let region = number(seeds.len());
            seeds.push(number(start));
            charts[start] = region;
            stack.push(start);
            while let Some(face) = stack.pop() {
                for next in flood.neighbours[face].into_iter().filter(|&next| next != NONE) {
                    let next = next as usize;
                    if charts[next] == NONE && labels[next] == labels[face] {
                        charts[next] = region;
                        stack.push(next);
                    }
                }
            }
        }
        let count = seeds.len();
        let mut regions = Self {
            charts,
            proxies: vec![Vector3::zeros(); count],
            seeds,
            sums: vec![(Vector3::zeros(), 0.0); count],
        };
        regions.fit(flood, &(0..number(count)).collect());
        regions
    }

    pub fn count(&self) -> usize {
        self.seeds.len()
    }

    pub fn of(&self, face: u32) -> usize {
        self.charts[face as usize] as usize
    }

    pub fn error(&self, region: u32) -> f64 {
        error_of(&self.sums[region as usize])
    }

    pub fn errors(&self) -> impl Iterator<Item = f64> + '_ {
        self.sums.iter().map(error_of)
    }

    /// The region with the largest error.
    pub fn worst(&self) -> Option<u32> {
        let regions = 0..number(self.count());
        regions.max_by(|&a, &b| self.error(a).total_cmp(&self.error(b)).then(b.cmp(&a)))
    }

    /// The face of a region that adds most to its error, other than its seed; none in a region of one face.
    pub fn farthest(&self, flood: &Flood, region: u32) -> Option<u32> {
        let proxy = self.proxies[region as usize];
        let seed = self.seeds[region as usize];
        let faces = (0..number(self.charts.len()))
            .filter(|&f| self.charts[f as usize] == region && f != seed);
        faces.max_by(|&a, &b| {
            flood.error(a, &proxy).total_cmp(&flood.error(b, &proxy)).then(b.cmp(&a))
        })
    }

    /// Fits proxies to the faces of some regions, and puts their seeds where normals are nearest to them.
    fn fit(&mut self, flood: &Flood, regions: &BTreeSet<u32>) {
        for &region in regions {
            self.sums[region as usize] = (Vector3::zeros(), 0.0);
        }
        let is_in = self.marks(regions);
        for (face, &region) in self.charts.iter().enumerate() {
            if is_in[region as usize] {
                let (sum, area) = &mut self.sums[region as usize];
                *sum += flood.normals[face] * flood.areas[face];
                *area += flood.areas[face];
            }
        }
        for &region in regions {
            let (sum, _) = self.sums[region as usize];
            // A region that is bent all around has no mean: what it had serves as well as any.
            if let Some(proxy) = sum.try_normalize(0.0) {
                self.proxies[region as usize] = proxy;
            }
        }
        let mut nearest = vec![f64::INFINITY; self.count()];
        for (face, &region) in (0u32..).zip(&self.charts) {
            if is_in[region as usize] {
                let distance = flood.distance(face, &self.proxies[region as usize]);
                if distance < nearest[region as usize] {
                    nearest[region as usize] = distance;
                    self.seeds[region as usize] = face;
                }
            }
        }
    }

    fn marks(&self, regions: &BTreeSet<u32>) -> Vec<bool> {
        let mut is_in = vec![false; self.count()];
        regions.iter().for_each(|&region| is_in[region as usize] = true);
        is_in
    }

    /// Floods some regions anew from their seeds, and fits them.
    fn flood(&mut self, flood: &mut Flood, regions: &BTreeSet<u32>) {
        let is_in = self.marks(regions);
        for region in &mut self.charts {
            if is_in[*region as usize] {
                *region = NONE;
            }
        }
        let seeds = regions.iter().map(|&region| (self.seeds[region as usize], region));
        flood.run(&mut self.charts, seeds, &self.proxies);
        self.fit(flood, regions);
    }

    /// One round of all regions. **Gives** whether a face changed its region.
    pub fn round(&mut self, flood: &mut Flood) -> bool {
        let before = self.charts.clone();
        self.flood(flood, &(0..number(self.count())).collect());
        self.charts != before
    }

    /// A region, and those that it touches.
    fn around(&self, flood: &Flood, region: u32) -> BTreeSet<u32> {
        let mut found = BTreeSet::from([region]);
        for (face, &own) in self.charts.iter().enumerate() {
            if own == region {
                let across = flood.neighbours[face].into_iter().filter(|&next| next != NONE);
                found.extend(across.map(|next| self.charts[next as usize]));
            }
        }
        found
    }

    /// A new region around a face, with some rounds of what it touches.
    pub fn insert(&mut self, flood: &mut Flood, seed: u32, rounds: usize) {
        let from = self.charts[seed as usize];
        let mut touched = self.around(flood, from);
        let region = number(self.count());
        self.seeds.push(seed);
        self.proxies.push(flood.normals[seed as usize]);
        self.sums.push((Vector3::zeros(), 0.0));
        touched.insert(region);
        for _ in 0..rounds {
            self.flood(flood, &touched);
        }
    }

    /// Pairs of regions that touch, each once.
    fn pairs(&self, flood: &Flood) -> BTreeSet<[u32; 2]> {
        let mut pairs = BTreeSet::new();
        for (face, &own) in self.charts.iter().enumerate() {
            for next in flood.neighbours[face].into_iter().filter(|&next| next != NONE) {
                let other = self.charts[next as usize];
                if own < other {
                    pairs.insert([own, other]);
                }
            }
        }
        pairs
    }

    /// Sums of a pair as one region.
    fn joined(&self, [a, b]: [u32; 2]) -> (Vector3<f64>, f64) {
        let ((s, x), (t, y)) = (self.sums[a as usize], self.sums[b as usize]);
        (s + t, x + y)
    }

    /// What merging a pair adds to the sum of errors.
    fn increase(&self, pair: [u32; 2]) -> f64 {
        error_of(&self.joined(pair)) - self.error(pair[0]) - self.error(pair[1])
    }

    /// The pair whose merging adds least, and how much.
    pub fn nearest_pair(&self, flood: &Flood) -> Option<([u32; 2], f64)> {
        let all = self.pairs(flood).into_iter().map(|pair| (pair, self.increase(pair)));
        all.min_by(|(p, x), (q, y)| x.total_cmp(y).then(p.cmp(q)))
    }

    /// The pair whose merging adds least, of those whose error then is below a limit.
    pub fn best_merge(&self, flood: &Flood, limit: f64) -> Option<[u32; 2]> {
        let fits = |pair: &[u32; 2]| error_of(&self.joined(*pair)) <= limit;
        let all = self.pairs(flood).into_iter().filter(fits);
        let keyed = all.map(|pair| (pair, self.increase(pair)));
        keyed.min_by(|(p, x), (q, y)| x.total_cmp(y).then(p.cmp(q))).map(|(pair, _)| pair)
    }

    /// Makes a pair one region. The last region takes the number that is free.
    pub fn merge(&mut self, [a, b]: [u32; 2]) {
        let sums = self.joined([a, b]);
        for region in &mut self.charts {
            if *region == b {
                *region = a;
            }
        }
        self.sums[a as usize] = sums;
        if let Some(proxy) = sums.0.try_normalize(0.0) {
            self.proxies[a as usize] = proxy;
        }
        let last = number(self.count() - 1);
        for region in &mut self.charts {
            if *region == last {
                *region = b;
            }
        }
        self.sums.swap_remove(b as usize);
        self.proxies.swap_remove(b as usize);
        self.seeds.swap_remove(b as usize);
    }

    /// Merges a pair, and uses the region that is saved around a face elsewhere.
    pub fn teleport(&mut self, flood: &mut Flood, pair: [u32; 2], seed: u32, rounds: usize) {
        self.merge(pair);
        self.insert(flood, seed, rounds);
    }
}

/// Numbers of faces and regions fit 32 bits: meshes are refused beyond.
#[expect(clippy::cast_possible_truncation, reason = "`Mesh::new` refuses larger meshes")]
fn number(i: usize) -> u32 {
    i as u32
}
