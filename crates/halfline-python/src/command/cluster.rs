//! Clusters of Dask for the command: Python reaches them, and the command's observer hears of it.

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use halfline::error::{Error, Result};
use halfline::progress::{Observer, Stage};
use halfline_cli::{Cluster, Host};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// How often the observer hears of what Python does, and Python of the observer.
const TICK: Duration = Duration::from_millis(20);

/// Python with a function that connects to the cluster at an address: `halfline._cluster.connect`.
pub struct PythonHost(pub Py<PyAny>);

impl Host for PythonHost {
    fn connect(&self, address: &str) -> Result<Box<dyn Cluster>> {
        Python::attach(|py| {
            let cluster = self.0.call1(py, (address,)).map_err(|raised| error(py, &raised))?;
            Ok(Box::new(PythonCluster(cluster)) as Box<dyn Cluster>)
        })
    }
}

/// A `halfline._cluster.Cluster`.
struct PythonCluster(Py<PyAny>);

impl Cluster for PythonCluster {
    fn trace(&self, tree: &Path, settings: &str, observer: &dyn Observer) -> Result<Vec<Vec<u8>>> {
        let watch = Python::attach(|py| Py::new(py, Watch::default()).map_err(|e| error(py, &e)))?;
        std::thread::scope(|scope| {
            let (over, is_over) = channel::<()>();
            let relay = watch.get();
            scope.spawn(move || {
                while is_over.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                    relay.pass_on(observer);
                }
            });
            // The relay ends when this is dropped, whatever happens.
            let _over = over;
            Python::attach(|py| {
                let arguments = (tree, settings, watch.clone_ref(py));
                let traced = self.0.call_method1(py, "trace", arguments);
                traced.and_then(|parts| parts.extract(py)).map_err(|raised| error(py, &raised))
            })
        })
    }
}

/// What Python calls as it traces, with the stage, what is done of it, and the total, or zeros if that
/// is not news; it raises `KeyboardInterrupt` once the work should end.
#[pyclass(frozen, module = "halfline._native")]
#[derive(Default)]
struct Watch {
    done: AtomicU64,
    total: AtomicU64,
    cancelled: AtomicBool,
}

impl Watch {
    fn pass_on(&self, observer: &dyn Observer) {
        let total = self.total.load(Ordering::Relaxed);
        if total > 0 {
            observer.report(Stage::Trace, self.done.load(Ordering::Relaxed), total);
        }
        if observer.cancelled() {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }
}

#[pymethods]
impl Watch {
    fn __call__(&self, _stage: &str, done: u64, total: u64) -> PyResult<()> {
        if total > 0 {
            self.done.store(done, Ordering::Relaxed);
            self.total.store(total, Ordering::Relaxed);
        }
        match self.cancelled.load(Ordering::Relaxed) {
            true => Err(PyKeyboardInterrupt::new_err(())),
            false => Ok(()),
        }
    }
}

/// What the command says about an exception.
fn error(py: Python, raised: &PyErr) -> Error {
    if raised.is_instance_of::<PyKeyboardInterrupt>(py) {
        return Error::Interrupted;
    }
    let text = raised.value(py).to_string();
    let text = if text.is_empty() { raised.to_string() } else { text };
    Error::invalid("--cluster", text)
}
