//! Points and directions of the plane as pairs of numbers, and where polylines turn.

/// a − b.
pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// p + s·d.
pub(super) fn along(p: [f64; 2], s: f64, d: [f64; 2]) -> [f64; 2] {
    [p[0] + s * d[0], p[1] + s * d[1]]
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Positive where b turns left from a.
pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// By a plain root: millimetres neither overflow nor underflow when squared, and this is asked millions of times.
pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    squared(a, b).sqrt()
}

pub(super) fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = minus(a, b);
    dot(d, d)
}

/// A quarter turn to the right: out of a piece that lies on the left.
pub(super) fn right([x, y]: [f64; 2]) -> [f64; 2] {
    [y, -x]
}

/// The vector with length 1; none for a vector without length.
pub(super) fn direction(v: [f64; 2]) -> Option<[f64; 2]> {
    let size = v[0].hypot(v[1]);
    (size > 0.0 && size.is_finite()).then(|| [v[0] / size, v[1] / size])
}

/// The nearest point of a segment, and its place from 0 at the first end to 1.
pub(super) fn nearest(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> ([f64; 2], f64) {
    let d = minus(b, a);
    let squared = dot(d, d);
    let t = if squared > 0.0 { (dot(minus(p, a), d) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (along(a, t, d), t)
}

/// Distance of two segments, and the points nearest to each other: on the first, on the second.
pub(super) fn between(s: [[f64; 2]; 2], t: [[f64; 2]; 2]) -> (f64, [[f64; 2]; 2]) {
    let [a, b] = s;
    let [c, d] = t;
    if let Some([u, _]) = meeting(s, t) {
        let p = along(a, u, minus(b, a));
        return (0.0, [p, p]);
    }
    let pairs = [
        [a, nearest(a, c, d).0],
        [b, nearest(b, c, d).0],
        [nearest(c, a, b).0, c],
        [nearest(d, a, b).0, d],
    ];
    let mut best = (f64::INFINITY, pairs[0]);
    for pair in pairs {
        let far = squared(pair[0], pair[1]);
        if far < best.0 {
            best = (far, pair);
        }
    }
    (best.0.sqrt(), best.1)
}

/// Where two segments meet, as places 0 … 1 on both; none where they are parallel.
pub(super) fn meeting([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let (r, s, w) = (minus(b, a), minus(d, c), minus(c, a));
    let turn = cross(r, s);
    let [t, u] = [cross(w, s) / turn, cross(w, r) / turn];
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)).then_some([t, u])
}

/// Twice the area would be this doubled; positive for polygons that run counter-clockwise.
pub(super) fn area(points: &[[f64; 2]]) -> f64 {
    let Some(&origin) = points.first() else { return 0.0 };
    let sides = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * sides.map(|(&a, &b)| cross(minus(a, origin), minus(b, origin))).sum::<f64>()
}

/// How often a polygon winds about a point; points on it may count either way.
pub(super) fn winding(points: &[[f64; 2]], p: [f64; 2]) -> i32 {
    let mut winding = 0;
    for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let is_left = cross(minus(b, a), minus(p, a)) > 0.0;
        if a[1] <= p[1] && b[1] > p[1] && is_left {
            winding += 1;
        } else if a[1] > p[1] && b[1] <= p[1] && !is_left {
            winding -= 1;
        }
    }
    winding
}

/// A polyline that is walked by arc length, back and forth.
pub(super) struct Walk<'a> {
    pub points: &'a [[f64; 2]],
    pub is_closed: bool,
}

impl Walk<'_> {
    /// The point at a distance from a point of the polyline along it, or the end if that is nearer; `step` +1 or −1.
    pub fn from(&self, start: usize, step: isize, far: f64) -> [f64; 2] {
        let n = self.points.len();
        let (mut at, mut rest) = (start, far);
        // A closed polyline is walked around once at most.
        for _ in 0..n {
            let Some(next) = self.next(at, step) else { break };
            let (p, q) = (self.points[at], self.points[next]);
            let size = distance(p, q);
            if size >= rest {
                return along(p, rest / size, minus(q, p));
            }
            rest -= size;
            at = next;
        }
        self.points[at]
    }

    fn next(&self, at: usize, step: isize) -> Option<usize> {
        let n = self.points.len();
        match (step > 0, self.is_closed) {
            (true, true) => Some((at + 1) % n),
            (true, false) => (at + 1 < n).then_some(at + 1),
            (false, true) => Some((at + n - 1) % n),
            (false, false) => at.checked_sub(1),
        }
    }

    /// Directions into and out of a point, each over a distance.
    pub fn directions(&self, at: usize, far: f64) -> Option<[[f64; 2]; 2]> {
        let p = self.points[at];
        let before = direction(minus(p, self.from(at, -1, far)))?;
        let after = direction(minus(self.from(at, 1, far), p))?;
        Some([before, after])
    }
}

/// Angle from one direction to another, −π … π, left positive.
pub(super) fn turning([before, after]: [[f64; 2]; 2]) -> f64 {
    cross(before, after).atan2(dot(before, after))
}
