//! Saddle tests: a cut that has converged is disturbed and improved again, beside the state that it came from.

use super::band::LevelSets;
use super::{CutFlow, CutState, Progress};
use crate::methods::flow::{SolveError, Status};

/// Steps that a disturbed cut has to get below the one it came from.
const STEPS: usize = 30;

/// Steps before it is judged whether it can still succeed.
const PATIENCE: usize = 4;

/// A disturbed cut on trial.
pub(super) struct Probe {
    state: CutState,
    progress: Progress,
    left: usize,
    /// How the run ends if the trial fails.
    end: Status,
}

/// What a checkpoint keeps of a trial.
#[derive(Clone, Debug)]
pub(super) struct SavedProbe {
    levels: LevelSets,
    progress: Progress,
    left: usize,
    end: Status,
}

impl Probe {
    pub fn save(&self) -> SavedProbe {
        SavedProbe {
            levels: self.state.levels.clone(),
            progress: self.progress.clone(),
            left: self.left,
            end: self.end,
        }
    }
}

impl SavedProbe {
    /// The trial again.
    pub fn revive(&self, flow: &mut CutFlow) -> Result<Probe, SolveError> {
        let state = flow.state_of(self.levels.clone())?;
        Ok(Probe { state, progress: self.progress.clone(), left: self.left, end: self.end })
    }
}

impl CutFlow {
    /// Whether a saddle test is under way.
    pub fn is_testing(&self) -> bool {
        self.probe.is_some()
    }

    /// Evaluates level sets whole.
    fn state_of(&mut self, levels: LevelSets) -> Result<CutState, SolveError> {
        let (cut, solution) = self.evaluate(&levels)?;
        let (levels, response) = LevelSets::rebuild(&self.problem, &cut, levels, self.mean_edge);
        Ok(CutState { levels, response, cut, solution })
    }

    /// Ends the run, unless a saddle test is due: then that begins.
    pub(super) fn end_or_probe(&mut self, end: Status) -> Result<(), SolveError> {
        if self.progress.probes >= self.params.saddle_tests || self.params.kick <= 0.0 {
            self.status = end;
            return Ok(());
        }
        self.progress.probes += 1;
        let state = self.state_of(self.state.levels.clone())?;
        let mut probe = Probe { state, progress: Progress::default(), left: STEPS, end };
        // Another disturbance than the first one, and than that of other tests.
        let seed = self.params.seed.wrapping_add(0x51ed_270b * self.progress.probes as u64);
        self.swap(&mut probe);
        let result = self.kick(seed);
        self.swap(&mut probe);
        result?;
        self.probe = Some(probe);
        Ok(())
    }

    fn swap(&mut self, probe: &mut Probe) {
        std::mem::swap(&mut self.state, &mut probe.state);
        std::mem::swap(&mut self.progress, &mut probe.progress);
    }

    /// One step of the trial. The state stays the better one.
    pub(super) fn step_probe(&mut self) -> Result<(), SolveError> {
        let Some(mut probe) = self.probe.take() else { return Ok(()) };
        let best = self.state.solution.energy.total;
        self.swap(&mut probe);
        let before = self.state.solution.energy.total;
        let result = self.search(f64::INFINITY);
        let total = self.state.solution.energy.total;
        self.swap(&mut probe);
        let moved = result?;
        probe.left -= 1;
        if total < best - self.params.tolerance * best.abs() {
            // It was a saddle, or a worse valley: go on from beyond.
            let Progress { step, probes, mut history, .. } = self.progress.clone();
            history.push(total);
            self.state = probe.state;
            self.progress = Progress { step: step + 1, probes, history, ..probe.progress };
            return Ok(());
        }
        // At the pace of this step, would it get there?
        let is_hopeless =
            STEPS - probe.left > PATIENCE && total - best > probe.left as f64 * (before - total);
        if !moved || probe.left == 0 || is_hopeless {
            self.status = probe.end;
        } else {
            self.probe = Some(probe);
        }
        Ok(())
    }
}
