//! Long work: bounded before it begins, told while it goes on, ended when asked.
//!
//! Builders say what they are about to do, in comparisons of a point with a triangle or the like,
//! and refuse what is beyond a bound. Whoever wants to hear of it, or to end it, runs the builder
//! inside [`watched`]; without that, work is only bounded. The watch is that of the thread.

use crate::RigError;
use std::cell::RefCell;

/// Most work that may be spent on one stage of building a body, in comparisons of a point with a
/// triangle: half a minute at the 15 ns that one takes on a core of 3 GHz (`cargo bench` of the
/// grid; measured, not guaranteed).
pub const STAGE_MAX: f64 = 2e9;

/// Progress of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Name of the work, for a person: "distances to 1200 triangles".
    pub stage: &'static str,
    /// Work of the whole stage, in comparisons (see [`STAGE_MAX`]).
    pub work: f64,
    /// Part of it that is done, 0 to 1.
    pub done: f64,
    /// Number of steps that the whole stage is expected to have; 0 where nobody counts them.
    pub steps: usize,
}

type ProgressCallback = Box<dyn FnMut(Progress) -> bool>;

thread_local! {
    static WATCH: RefCell<Option<ProgressCallback>> = const { RefCell::new(None) };
}

/// Takes the watch away again, also when the work panics.
struct WatchGuard(Option<ProgressCallback>);

impl Drop for WatchGuard {
    fn drop(&mut self) {
        WATCH.with(|slot| *slot.borrow_mut() = self.0.take());
    }
}

/// Runs `work`, telling `watch` of every stage of all that is built in it on this thread: at its
/// beginning and some hundred times while it lasts. When `watch` returns false, the builder ends
/// with [`RigError::Stopped`].
pub fn watched<T>(watch: impl FnMut(Progress) -> bool + 'static, work: impl FnOnce() -> T) -> T {
    let _ended = WatchGuard(WATCH.with(|slot| slot.borrow_mut().replace(Box::new(watch))));
    work()
}

/// Says what comes next: work in proportion to its data, reported by its name alone.
///
/// # Errors
/// [`RigError::Stopped`] when it is not to go on.
pub(crate) fn phase(name: &'static str) -> Result<(), RigError> {
    let progress = Progress { stage: name, work: 0.0, done: 0.0, steps: 0 };
    if heard(progress) { Ok(()) } else { Err(RigError::Stopped) }
}

/// Says how far a stage is; false when it is not to go on.
fn heard(progress: Progress) -> bool {
    WATCH.with(|slot| slot.borrow_mut().as_mut().is_none_or(|watch| watch(progress)))
}

/// One stage of a builder.
pub(crate) struct Stage {
    name: &'static str,
    cure: &'static str,
    work: f64,
    steps: usize,
    every: usize,
}

impl Stage {
    /// A stage of `steps` steps that cost `work` in all.
    ///
    /// # Errors
    /// The work would cost more than may be spent; `cure` says what helps.
    pub fn new(
        name: &'static str,
        steps: usize,
        work: f64,
        cure: &'static str,
    ) -> Result<Self, RigError> {
        let stage = Self { name, cure, work, steps, every: (steps / 200).max(1) };
        stage.bounded(work)?;
        stage.tell(0)?;
        Ok(stage)
    }

    /// Says that `step` steps are done.
    ///
    /// # Errors
    /// [`RigError::Stopped`] when it is not to go on.
    pub fn at(&self, step: usize) -> Result<(), RigError> {
        if step.is_multiple_of(self.every) { self.tell(step) } else { Ok(()) }
    }

    /// Says that step number `step` comes, which may be beyond those that were expected.
    ///
    /// # Errors
    /// As [`Stage::at`]; or that number of steps costs more than may be spent.
    pub fn at_most(&self, step: usize) -> Result<(), RigError> {
        if step > self.steps || step.is_multiple_of(self.every) {
            self.beyond(step)
        } else {
            Ok(())
        }
    }

    /// Says that step number `step` comes, and checks the price whatever the step.
    ///
    /// # Errors
    /// As there.
    pub fn beyond(&self, step: usize) -> Result<(), RigError> {
        if step > self.steps {
            self.bounded(self.work * step as f64 / self.steps.max(1) as f64)?;
        }
        self.tell(step)
    }

    fn bounded(&self, work: f64) -> Result<(), RigError> {
        if work <= STAGE_MAX {
            return Ok(());
        }
        let Self { name, cure, .. } = self;
        Err(RigError::invalid(format!(
            "{name} would take {work:.1e} comparisons or more, at most {STAGE_MAX:.0e} are spent: {cure}"
        )))
    }

    /// Says that `step` steps are done, however many lie between.
    ///
    /// # Errors
    /// As [`Stage::at`].
    pub fn tell(&self, step: usize) -> Result<(), RigError> {
        let done = if self.steps > 0 { step as f64 / self.steps as f64 } else { 1.0 };
        let Self { name: stage, work, steps, .. } = *self;
        let progress = Progress { stage, work, done: done.min(1.0), steps };
        if heard(progress) { Ok(()) } else { Err(RigError::Stopped) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn a_watch_hears_of_stages_and_ends_them() {
        let heard = Rc::new(RefCell::new(Vec::new()));
        let notes = Rc::clone(&heard);
        let result = watched(
            move |progress| {
                notes.borrow_mut().push((progress.done, progress.steps));
                progress.done < 0.5
            },
            || {
                phase("thinking")?;
                let stage = Stage::new("counting", 10, 10.0, "count less")?;
                (1..=10).try_for_each(|step| stage.at(step))
            },
        );
        assert!(matches!(result, Err(RigError::Stopped)));
        // Nobody counts the steps of the first.
        let of_ten = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5].map(|done| (done, 10));
        assert_eq!(heard.borrow()[0], (0.0, 0));
        assert_eq!(heard.borrow()[1..], of_ten);
        // Nobody watches any more.
        assert!(Stage::new("counting", 0, 0.0, "").is_ok());
        assert_eq!(heard.borrow().len(), 7);
    }

    #[test]
    fn what_costs_too_much_is_refused_before_it_begins() {
        let error = Stage::new("counting", 1, 1e10, "count less").err().unwrap().to_string();
        assert_eq!(
            error,
            "counting would take 1.0e10 comparisons or more, at most 2e9 are spent: count less"
        );
    }
}
