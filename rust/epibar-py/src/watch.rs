//! Ctrl-C and progress for long computations.

use std::time::{Duration, Instant};

use epibar::{Stage, Watch};
use pyo3::prelude::*;

use crate::convert::to_python_error;

/// Time between two calls of Python's progress function.
const QUIET: Duration = Duration::from_millis(100);

/// Takes the GIL back between batches, on the calling thread, to look for signals and to report progress.
struct PythonWatch {
    progress: Option<Py<PyAny>>,
    last: Option<(Stage, Instant)>,
    /// What Python raised meanwhile.
    raised: Option<PyErr>,
}

/// Releases the GIL, runs `work` under Python's eyes, raises again what Python raised meanwhile, and maps its error otherwise.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut dyn Watch) -> epibar::Result<T> + Send,
) -> PyResult<T> {
    let mut watch = PythonWatch { progress, last: None, raised: None };
    let found = py.detach(|| work(&mut watch));
    match watch.raised {
        Some(raised) => Err(raised),
        None => found.map_err(|error| to_python_error(&error)),
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
