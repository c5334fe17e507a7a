//! `halfline._native.Explanation`.

use std::sync::Arc;

use halfline::explain;
use halfline::geometry::{Ray, Vec3};
use halfline_explain::Report;
use pyo3::prelude::*;

use crate::call::{Progress, on_pool};
use crate::error::exception;
use crate::scene::Scene;

/// What became of a ray.
#[pyclass(frozen, module = "halfline._native")]
pub struct Explanation {
    scene: Arc<halfline::Scene>,
    explanation: explain::Explanation,
    name: String,
}

impl Explanation {
    /// Tells of it in words.
    fn tell(&self, py: Python, words: fn(&Report) -> String) -> PyResult<String> {
        on_pool(py, None, |_| {
            self.scene.guarded(|| {
                let Explanation { scene, explanation, name } = self;
                Ok(words(&Report { name, mesh: scene.mesh(), explanation }))
            })
        })
    }
}

#[pymethods]
impl Explanation {
    #[new]
    #[pyo3(signature = (scene, origin, direction, t_min, t_max, rule, name, progress=None, /))]
    #[expect(clippy::too_many_arguments, reason = "they are those of Scene.explain in Python")]
    fn new(
        py: Python,
        scene: &Scene,
        origin: [f64; 3],
        direction: [f64; 3],
        t_min: f64,
        t_max: f64,
        rule: &str,
        name: String,
        progress: Progress,
    ) -> PyResult<Explanation> {
        let rule = rule.parse().map_err(|error| exception(py, error))?;
        let ray = Ray::with_range(Vec3::from(origin), Vec3::from(direction), t_min, t_max);
        let scene = Arc::clone(&scene.scene);
        let explanation = on_pool(py, progress, |observer| scene.explain(&ray, rule, observer))?;
        Ok(Explanation { scene, explanation, name })
    }

    fn json(&self, py: Python) -> PyResult<String> {
        self.tell(py, |report| report.to_json().to_string())
    }

    fn text(&self, py: Python) -> PyResult<String> {
        self.tell(py, |report| report.to_text())
    }

    fn page(&self, py: Python) -> PyResult<String> {
        self.tell(py, |report| report.to_page(2))
    }
}
