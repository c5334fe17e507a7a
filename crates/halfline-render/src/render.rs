//! A picture at once, on one machine.

use halfline::Scene;
use halfline::error::Result;
use halfline::progress::Observer;

use crate::assemble::assemble;
use crate::image::Rendering;
use crate::plan::Plan;
use crate::settings::RenderSettings;

/// Draws `scene` as `settings` ask, reporting [`Stage::Trace`](halfline::progress::Stage::Trace) in
/// pixels to `observer`.
///
/// # Errors
/// [`Error::Invalid`](halfline::Error::Invalid) if a setting makes no sense, naming it;
/// [`Error::Interrupted`](halfline::Error::Interrupted) soon after `observer` asks for the end.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendering> {
    observer.check()?;
    let rows = Plan::new(scene, settings)?.trace_rows(0..settings.height, observer)?;
    assemble(settings, [rows])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Ground, Shading};
    use crate::tile;
    use halfline::geometry::{Hit, Ray};
    use halfline::mesh::Material;
    use halfline::progress::NoProgress;
    use halfline_io::models::{Kind, generate};

    /// Answers by brute force.
    struct Judge<'a>(&'a halfline::Mesh);

    impl crate::Intersector for Judge<'_> {
        fn closest(&self, rays: &[Ray]) -> Vec<Hit> {
            halfline::brute_force::intersect(self.0, rays)
        }

        fn occluded(&self, rays: &[Ray]) -> Vec<bool> {
            self.closest(rays).iter().map(Hit::is_hit).collect()
        }
    }

    #[test]
    fn a_judge_draws_the_same_picture() {
        let scene = Scene::new(generate(Kind::Scan, 1000, 0, &NoProgress).unwrap()).unwrap();
        for shading in [Shading::Clay, Shading::Whitted] {
            let settings =
                RenderSettings { width: 24, height: 16, shading, ..RenderSettings::default() };
            let plan = Plan::new(&scene, &settings).unwrap();
            let drawn = |rows| {
                let mut picture = assemble(&settings, [rows]).unwrap();
                picture.statistics.trace_seconds = 0.0;
                picture
            };
            let usual = drawn(plan.trace_rows(0..16, &NoProgress).unwrap());
            let judged =
                drawn(plan.trace_rows_by(&Judge(scene.mesh()), 0..16, &NoProgress).unwrap());
            assert!(usual == judged, "{}", shading.name());
        }
    }

    #[test]
    fn another_intersector_is_asked_about_every_ray() {
        struct Nothing;
        impl crate::Intersector for Nothing {
            fn closest(&self, rays: &[Ray]) -> Vec<Hit> {
                vec![Hit::MISS; rays.len()]
            }
            fn occluded(&self, rays: &[Ray]) -> Vec<bool> {
                vec![false; rays.len()]
            }
        }
        let scene = Scene::new(generate(Kind::Scan, 1000, 0, &NoProgress).unwrap()).unwrap();
        let settings = RenderSettings { width: 24, height: 16, ..RenderSettings::default() };
        let rows =
            Plan::new(&scene, &settings).unwrap().trace_rows_by(&Nothing, 0..16, &NoProgress);
        let picture = assemble(&settings, [rows.unwrap()]).unwrap();
        assert!(picture.face.iter().all(|&face| face == halfline::geometry::NO_FACE));
    }

    /// Every tile size cuts the picture, the samples and the waves of rays elsewhere.
    #[test]
    fn the_size_of_tiles_does_not_show() {
        let scene = Scene::new(generate(Kind::Scan, 3000, 0, &NoProgress).unwrap()).unwrap();
        let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
        for shading in Shading::ALL {
            let material = (shading == Shading::Whitted).then_some(glass);
            for samples in [1, 6] {
                let settings = RenderSettings {
                    width: 37,
                    height: 22,
                    samples,
                    shading,
                    material,
                    ground: Some(Ground { reflectivity: 0.3, ..Ground::default() }),
                    smooth_angle: Some(60.0),
                    ..RenderSettings::default()
                };
                let drawn = |batch| {
                    let plan = Plan::new(&scene, &settings).unwrap().with_batch(batch);
                    let rows = plan.trace_rows(0..settings.height, &NoProgress).unwrap();
                    let mut picture = assemble(&settings, [rows]).unwrap();
                    picture.statistics.trace_seconds = 0.0;
                    picture
                };
                let usual = drawn(tile::BATCH);
                for batch in [1, 40, 1000, 100_000] {
                    let name = shading.name();
                    assert!(drawn(batch) == usual, "{name}, {samples} samples, {batch} rays");
                }
            }
        }
    }
}
