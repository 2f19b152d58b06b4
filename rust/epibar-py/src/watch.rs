//! Ctrl-C and progress for long computations.

use std::time::{Duration, Instant};

use epibar::{Stage, Watch};
use pyo3::prelude::*;

/// Time between two calls of Python's progress function.
const QUIET: Duration = Duration::from_millis(100);

/// Takes the GIL back between batches, on the calling thread, to look for signals and to report progress.
pub struct PythonWatch {
    progress: Option<Py<PyAny>>,
    last: Option<(Stage, Instant)>,
    /// What Python raised, to be raised again by the caller.
    pub raised: Option<PyErr>,
}

impl PythonWatch {
    pub fn new(progress: Option<Py<PyAny>>) -> Self {
        Self { progress, last: None, raised: None }
    }
}

impl Watch for PythonWatch {
    fn keep_going(&mut self, stage: Stage, done: f64) -> bool {
        let due = self.last.is_none_or(|(before, at)| before != stage || at.elapsed() > QUIET);
        if due {
            self.last = Some((stage, Instant::now()));
        }
        let outcome = Python::attach(|py| -> PyResult<()> {
            py.check_signals()?;
            if let (true, Some(progress)) = (due, &self.progress) {
                progress.call1(py, (stage.name(), done))?;
            }
            Ok(())
        });
        match outcome {
            Ok(()) => true,
            Err(error) => {
                self.raised = Some(error);
                false
            }
        }
    }
}
