//! How the values of a field are shared out over the area of a surface.

/// Shares of area by value.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Bounds of the bins: one more than there are bins, evenly spaced.
    pub bounds: Vec<f64>,
    /// Share of the area in each bin; they add up to 1.
    pub shares: Vec<f64>,
    /// Mean over the area.
    pub mean: f64,
    /// Least value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Least value that 95 % of the area do not exceed.
    pub p95: f64,
}

impl Histogram {
    /// Sorts a face field into bins.
    ///
    /// **Takes** values and areas of faces: values that are not finite (no chart), and areas that are not positive, do not count; the range of
    /// the bins, or none for that of the values (values outside fall into the first and last bin); at least one bin.
    /// **Gives** nothing where nothing counts. **Costs** O(F log F).
    ///
    /// ```
    /// # use cutflow::flatten::Histogram;
    /// let histogram = Histogram::new(&[1.0, 2.0, f64::NAN, 4.0], &[2.0, 1.0, 5.0, 1.0], None, 3).unwrap();
    /// assert_eq!(histogram.shares, [0.5, 0.25, 0.25]);
    /// assert_eq!((histogram.mean, histogram.max, histogram.p95), (2.0, 4.0, 4.0));
    /// ```
    pub fn new(
        values: &[f64],
        areas: &[f64],
        range: Option<[f64; 2]>,
        bins: usize,
    ) -> Option<Self> {
        assert_eq!(values.len(), areas.len());
        let counts = |&(value, area): &(f64, f64)| value.is_finite() && area > 0.0;
        let mut sorted: Vec<(f64, f64)> =
            values.iter().copied().zip(areas.iter().copied()).filter(counts).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (&(min, _), &(max, _)) = (sorted.first()?, sorted.last()?);
        let total: f64 = sorted.iter().map(|(_, area)| area).sum();
        let [low, high] = range.unwrap_or([min, max]);
        let bins = bins.max(1);
        let bound = |i: usize| low + (high - low) * (i as f64 / bins as f64);
        let bounds: Vec<f64> = (0..=bins).map(bound).collect();
        let mut shares = vec![0.0; bins];
        for (value, area) in &sorted {
            let above = bounds[1..bins].partition_point(|bound| bound <= value);
            shares[above] += area / total;
        }
        let mean = sorted.iter().map(|(value, area)| value * area).sum::<f64>() / total;
        let mut below = 0.0;
        let p95 = sorted.iter().find(|(_, area)| {
            below += area;
            below >= 0.95 * total
        });
        Some(Self { bounds, shares, mean, min, max, p95: p95.map_or(max, |(value, _)| *value) })
    }
}
