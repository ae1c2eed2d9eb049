//! The flow: a layout at once, then shorter and shorter ones.

use super::part::{Part, Spot};
use super::plane::Dice;
use super::probe::Probe;
use super::raster::{Board, fill};
use super::separate::Separation;
use super::state::{Laid, NestState};
use super::{NestFault, NestParams, NestShape, check, shelf};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Samples that a step looks up, about: some 40 ms.
const WORK: u64 = 3_000_000;
/// The stock is shortened by this part at first, and no more by less than the second.
const SHORTER: [f64; 2] = [0.02, 0.001];
/// Rounds without a gain after which a trial is given up.
const PATIENCE: usize = 30;
/// Trials given up one after the other before it ends.
const FAILURES: usize = 40;
/// Rounds of pushing all parts after each round of moving single ones.
const RELAXING: usize = 30;
/// Above this many parts there are too many pairs to search.
const MOST_PARTS: usize = 3000;

/// Nests shapes.
///
/// **Minimises** [`NestState::cost_mm`] subject to [`check`]. **Step**: the first few lay all pieces on a raster, each as low as it
/// goes, in another order (the first takes some tenths of a second for 200 pieces); then one round or a few of moving pieces
/// apart in stock that is too short. The state changes only where a layout is shorter and passes the check. **Ends** `Converged`
/// where nothing can be shorter, or 40 trials in a row came to nothing; `StepLimit`. A clone is a checkpoint.
///
/// ```
/// # use cutflow::pattern::{NestFlow, NestParams, NestShape, Stock};
/// # use cutflow::methods::flow::Flow;
/// let square = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
/// let shape = NestShape { outlines: vec![square], ..NestShape::default() };
/// let stock = Stock::Roll { width_mm: 30.0 };
/// let params = NestParams { stock, gap_mm: 0.0, margin_mm: 0.0, ..NestParams::default() };
/// let mut flow = NestFlow::new(&vec![shape; 6], &params).unwrap();
/// flow.step().unwrap();
/// assert!((flow.state().cost_mm - 20.0).abs() < 1e-9);
/// ```
#[derive(Clone, Debug)]
pub struct NestFlow {
    laid: Laid,
    spots: Vec<Spot>,
    /// No layout costs less.
    least_cost: f64,
    least_height: f64,
    state: NestState,
    dice: Dice,
    stage: Stage,
    shorter: f64,
    failures: usize,
    probes: Vec<Probe>,
    step: usize,
    status: Status,
}

/// What the next step does.
#[derive(Clone, Debug)]
enum Stage {
    /// Lays parts in one of several orders.
    Raster(usize),
    /// Prepares the search, a few parts a step.
    Prepare,
    /// Begins with stock a little shorter.
    Shorten,
    /// Moves parts apart.
    Separate(Box<Trial>),
}

#[derive(Clone, Debug)]
struct Trial {
    search: Separation,
    /// Parts of this round that are still to be moved.
    queue: Vec<usize>,
    least: f64,
    rounds_without_gain: usize,
}

impl NestFlow {
    /// **Fails** where a parameter is out of its range.
    pub fn new(shapes: &[NestShape], params: &NestParams) -> Result<Self, SolveError> {
        params.validate()?;
        let mut flow = Self {
            laid: Laid::new(shapes, params),
            spots: Vec::new(),
            least_cost: 0.0,
            least_height: 0.0,
            state: NestState::default(),
            dice: Dice(params.seed),
            stage: Stage::Raster(0),
            shorter: SHORTER[0],
            failures: 0,
            probes: Vec::new(),
            step: 0,
            status: Status::Running,
        };
        flow.spots = shelf::rows(&flow.laid.parts, &flow.laid.room);
        flow.state = flow.laid.state(&flow.spots);
        if flow.laid.parts.is_empty() {
            flow.status = Status::Converged;
        } else {
            flow.least_cost = flow.laid.room.least_cost(&flow.laid.parts);
            let heights = flow.laid.parts.iter().map(|part| part.least_extent()[0]);
            flow.least_height = heights.fold(f64::INFINITY, f64::min);
        }
        Ok(flow)
    }

    /// What is asked of the layout.
    pub fn params(&self) -> &NestParams {
        &self.laid.params
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Takes a layout if it is shorter and passes the check.
    fn accept(&mut self, mut spots: Vec<Spot>) -> Result<bool, NestFault> {
        // Sheets without a part go.
        let mut used: Vec<usize> = spots.iter().map(|spot| spot.sheet).collect();
        used.sort_unstable();
        used.dedup();
        for spot in &mut spots {
            spot.sheet = used.partition_point(|&sheet| sheet < spot.sheet);
        }
        let state = self.laid.state(&spots);
        check(&self.laid.shapes, &state.poses, &self.laid.params)?;
        let is_shorter = state.cost_mm < self.state.cost_mm * (1.0 - 1e-12);
        if is_shorter {
            self.spots = spots;
            self.state = state;
        }
        Ok(is_shorter)
    }

    /// Lays all parts by one of several orders; whether there are more.
    fn lay(&mut self, kind: usize) -> bool {
        let key = |part: &Part| {
            let [w, h] = part.fits[0].size();
            match kind {
                0 => part.area,
                1 => w.max(h),
                2 => w * h,
                _ => h,
            }
        };
        let keys: Vec<f64> = self.laid.parts.iter().map(key).collect();
        let mut order: Vec<usize> = (0..self.laid.parts.len()).collect();
        order.sort_by(|&i, &j| keys[j].total_cmp(&keys[i]));
        for width in self.widths() {
            let inner = [width, self.laid.room.inner()[1]];
            let cell = self.cell(width);
            let (gap, margin) = (self.laid.room.gap, self.laid.room.margin);
            let board = Board { inner, gap, margin, cell };
            // A layout that fails the check is none; the last one stays.
            if let Some(spots) = fill(&self.laid.parts, &order, &board) {
                let _ = self.accept(spots);
            }
        }
        kind < 3
    }

    /// Widths between margins to lay on: several for a square.
    fn widths(&self) -> Vec<f64> {
        let [width, _] = self.laid.room.inner();
        if width.is_finite() {
            return vec![width];
        }
        let widest =
            self.laid.parts.iter().map(|part| {
                part.fits.iter().map(|fit| fit.size()[0]).fold(f64::INFINITY, f64::min)
            });
        let widest = widest.fold(0.0, f64::max);
        let least = (self.least_cost - 2.0 * self.laid.room.margin).max(widest);
        [1.05, 1.12, 1.2, 1.3].map(|part| least * part).into_iter().chain([widest]).collect()
    }

    /// Side of a cell: as asked, or fine against the parts, but so coarse that laying takes about a tenth of a second.
    fn cell(&self, width: f64) -> f64 {
        let count = self.laid.parts.len() as f64;
        let gap = self.laid.room.gap;
        let turns: usize = self.laid.parts.iter().map(|part| part.fits.len()).sum();
        // Of parts with the gap around them.
        let sizes = self
            .laid
            .parts
            .iter()
            .map(|part| (part.area.sqrt() + gap, part.fits[0].size()[1] + gap));
        let (area, height) =
            sizes.fold((0.0, 0.0), |(a, h), (side, high)| (a + side * side, h + high));
        let length = (area / (0.6 * width)).max(height / count);
        let coarse = (turns as f64 * length * height / count * CELL_COST).sqrt();
        let extents = self.laid.parts.iter().flat_map(|part| part.fits[0].size());
        let least = extents.fold(f64::INFINITY, f64::min);
        let fits = self.laid.parts.iter().flat_map(|part| &part.fits);
        let longest = fits.flat_map(|fit| fit.size()).fold(0.0, f64::max);
        // Needles stand as high as they are long in some of their turns, whatever their area says: at each place all rows of
        // their mask may be asked. There is one place in each row at least, however narrow the stock.
        let tall = if longest > NEEDLE * (area / count).sqrt() {
            let turns = turns as f64 / NEEDLE_ROWS;
            (turns * width * longest * longest).cbrt().max(longest * turns.sqrt())
        } else {
            0.0
        };
        if self.laid.params.resolution_mm > 0.0 {
            return self.laid.params.resolution_mm.max(coarse);
        }
        let wanted = (area / count).sqrt().min(4.0 * least) / 128.0;
        // Whole cells for the smallest part, its half, third, and quarter, so that equal parts lie side by side without loss.
        let pitch = least + self.laid.room.gap;
        let cells = pitch / wanted.max(coarse);
        let whole =
            if cells < 12.0 { cells.floor().max(1.0) } else { 12.0 * (cells / 12.0).floor() };
        // A part far thinner than the others is laid on cells wider than itself: cells as fine as needles would be laid for minutes.
        (pitch / whole).max(0.25 * coarse).max(tall)
    }

    /// One stage.
    fn advance(&mut self) {
        match std::mem::replace(&mut self.stage, Stage::Shorten) {
            Stage::Raster(kind) => {
                let goes_on = self.lay(kind);
                self.stage = if goes_on { Stage::Raster(kind + 1) } else { Stage::Prepare };
                if self.laid.parts.len() > MOST_PARTS && !goes_on {
                    self.status = Status::Stalled;
                }
            }
            Stage::Prepare => {
                let slack = self.laid.parts.iter().map(|part| part.slack).fold(0.0, f64::max);
                let done = self.probes.len();
                let next = self.laid.parts[done..].iter().take(40);
                self.probes.extend(next.map(|part| Probe::new(part, self.laid.room.gap, slack)));
                if self.probes.len() < self.laid.parts.len() {
                    self.stage = Stage::Prepare;
                }
            }
            Stage::Shorten => {
                let trial = self.shorten();
                self.stage = Stage::Separate(Box::new(trial));
            }
            Stage::Separate(trial) => self.separate(trial),
        }
        if self.state.cost_mm <= self.least_cost * (1.0 + 1e-9) {
            self.status = Status::Converged;
        }
    }

    fn shorten(&mut self) -> Trial {
        let cost = (self.state.cost_mm * (1.0 - self.shorter)).max(self.least_cost);
        let bins = self.laid.room.bins(cost, self.least_height);
        let (gap, margin) = (self.laid.room.gap, self.laid.room.margin);
        let mut search = Separation::new(
            &self.laid.parts,
            &self.probes,
            &self.spots,
            (bins, margin, gap),
            &mut self.dice,
        );
        let count = self.laid.parts.len();
        if self.failures > 0 && count > 1 {
            // The same again would fail again: two of the larger parts change places.
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_by(|&i, &j| self.laid.parts[j].area.total_cmp(&self.laid.parts[i].area));
            let large = count.div_ceil(2).max(2);
            let i = self.dice.below(large);
            let j = (i + 1 + self.dice.below(large - 1)) % large;
            search.swap(&self.probes, [order[i], order[j]]);
        }
        search.relax(&self.laid.parts, &self.probes, (4 * RELAXING, WORK));
        Trial { least: search.total(), search, queue: Vec::new(), rounds_without_gain: 0 }
    }

    /// Moves parts until the work of a step is done or the trial is over.
    fn separate(&mut self, mut trial: Box<Trial>) {
        let end = trial.search.work + WORK;
        while trial.search.work < end {
            if trial.queue.is_empty() {
                trial.queue = trial.search.entangled();
                if trial.queue.is_empty() {
                    self.settle(&trial);
                    return;
                }
                for i in (1..trial.queue.len()).rev() {
                    let j = self.dice.below(i + 1);
                    trial.queue.swap(i, j);
                }
            }
            let Some(part) = trial.queue.pop() else { continue };
            trial.search.relocate(&self.laid.parts, &self.probes, part, &mut self.dice);
            if trial.queue.is_empty() {
                let total = trial.search.total();
                if total < 0.98 * trial.least {
                    trial.least = total;
                    trial.rounds_without_gain = 0;
                } else {
                    trial.rounds_without_gain += 1;
                }
                trial.search.weigh();
                if total > 0.0 {
                    trial.search.relax(&self.laid.parts, &self.probes, (RELAXING, WORK / 2));
                }
                if total > 0.0 && trial.rounds_without_gain > PATIENCE {
                    self.give_up();
                    return;
                }
            }
        }
        self.stage = Stage::Separate(trial);
    }

    /// No part overlaps another by the samples: takes the layout if it passes the check.
    fn settle(&mut self, trial: &Trial) {
        let fault = if trial.search.is_within() {
            match self.accept(trial.search.spots.clone()) {
                Ok(true) => {
                    self.failures = 0;
                    self.shorter = (self.shorter * 1.5).min(SHORTER[0]);
                    return;
                }
                Ok(false) => None,
                Err(fault) => Some(fault),
            }
        } else {
            None
        };
        // Sides crossed between samples: from now on these places are looked at too.
        if let Some(NestFault::Overlap { shapes, at } | NestFault::TooClose { shapes, at, .. }) =
            fault
        {
            for (k, part) in self.laid.parts.iter().enumerate() {
                if shapes.contains(&part.shape) {
                    let spot = &trial.search.spots[k];
                    let at = [at[0] - spot.at[0], at[1] - spot.at[1]];
                    self.probes[k].add(spot.turn.undo(at));
                }
            }
        }
        self.give_up();
    }

    fn give_up(&mut self) {
        self.failures += 1;
        self.shorter = (self.shorter * 0.6).max(SHORTER[1]);
        if self.failures >= FAILURES {
            self.status = Status::Converged;
        }
    }

    fn report(&self) -> StepReport {
        let state = &self.state;
        let limit = self.laid.params.step_limit.max(1);
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let progress = (self.step as f64 / limit as f64).min(1.0) as f32;
        StepReport {
            step: self.step,
            energy: vec![
                ("cost", state.cost_mm),
                ("utilisation", state.utilisation),
                ("sheets", state.sheets as f64),
            ],
            residual: 0.0,
            progress: Some(progress),
            status: self.status,
        }
    }
}

/// Longer than so many sides of the square of its size, a part is a needle.
const NEEDLE: f64 = 10.0;

/// Rows that laying needles may ask for: tenths of a second.
const NEEDLE_ROWS: f64 = 5e7;

/// Time of laying on a raster is about this for each turn, row of the stock and row of the part, seconds over what it may take.
const CELL_COST: f64 = 2e-8;

impl Flow for NestFlow {
    type State = NestState;

    fn state(&self) -> &NestState {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status == Status::Running {
            self.advance();
            self.step += 1;
            if self.status == Status::Running && self.step >= self.laid.params.step_limit {
                self.status = Status::StepLimit;
            }
        }
        Ok(self.report())
    }
}
