//! What the builder promises about every tree.

use crate::common::engines::build_variants;
use crate::common::{check_structure, meshes, soup};
use halfline::error::Error;
use halfline::mesh::Positions;
use halfline::progress::{NoProgress, Observer};
use halfline::tree::Tree;
use halfline::{BuildParameters, Mesh, Preset, Ray, Scene, Vec3};
use halfline_io::models::{Kind, generate};

#[test]
fn trees_are_what_they_should_be() {
    let generated = [Kind::Scan, Kind::Hall, Kind::Soup, Kind::Terrain, Kind::Tree]
        .map(|kind| (kind.name(), generate(kind, 30_000, 1, &NoProgress).expect("generates")));
    for (name, mesh) in meshes().into_iter().chain(generated) {
        for parameters in build_variants() {
            let scene = Scene::builder(mesh.clone())
                .parameters(parameters)
                .observer(&NoProgress)
                .build()
                .expect("builds");
            check_structure(name, scene.tree(), &mesh);
            let limit = mesh.triangle_count() as f64 * (1.0 + parameters.duplication_budget);
            assert!(scene.tree().references as f64 <= limit, "{name}: {parameters:?}");
        }
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let mesh = generate(Kind::Hall, 60_000, 1, &NoProgress).expect("generates");
    for preset in Preset::ALL {
        let parameters = BuildParameters::preset(preset);
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool").install(|| {
                Scene::builder(mesh.clone())
                    .parameters(parameters)
                    .observer(&NoProgress)
                    .build()
                    .expect("builds")
            })
        };
        let (one, four) = (build(1), build(4));
        let [one, four] = [one.tree(), four.tree()];
        assert_eq!(one.references, four.references);
        let bytes = |tree: &Tree| bytemuck::cast_slice::<_, u8>(&tree.nodes).to_vec();
        assert!(bytes(one) == bytes(four), "{preset:?}: nodes differ");
        let leaves = |tree: &Tree| bytemuck::cast_slice::<_, u8>(&tree.leaves.blocks).to_vec();
        assert!(leaves(one) == leaves(four), "{preset:?}: leaves differ");
    }
}

#[test]
fn empty_meshes_and_meshes_of_skipped_faces_are_never_hit() {
    let nan = f64::NAN;
    let vertices = vec![[nan, 0.0, 0.0], [0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
    let skipped = Mesh::new(Positions::F64(vertices.into()), vec![[0, 1, 2], [1, 2, 3], [1, 1, 2]]);
    for (mesh, zero_area, non_finite) in [(soup([]), 0, 0), (skipped.expect("a valid mesh"), 2, 1)]
    {
        let scene = Scene::new(mesh).expect("builds");
        let tree = scene.tree();
        assert_eq!((tree.skipped_zero_area, tree.skipped_non_finite), (zero_area, non_finite));
        let statistics = scene.statistics();
        assert_eq!((statistics.nodes, statistics.leaves, statistics.references), (0, 0, 0));
        let ray = Ray::new(Vec3::ZERO, Vec3::from([1.0, 1.0, 1.0]));
        assert!(scene.caster().intersect(&ray).is_none() && !scene.caster().occluded(&ray));
    }
}

#[test]
fn a_build_ends_when_it_is_told_to() {
    struct Impatient;
    impl Observer for Impatient {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let mesh = generate(Kind::Sphere, 20_000, 1, &NoProgress).expect("generates");
    assert!(matches!(Scene::builder(mesh).observer(&Impatient).build(), Err(Error::Interrupted)));
}

#[test]
fn senseless_parameters_are_refused() {
    for (parameters, name) in [
        (
            BuildParameters::default().with_spatial_split_min_triangles(0),
            "spatial_split_min_triangles",
        ),
        (BuildParameters::default().with_duplication_budget(f64::NAN), "duplication_budget"),
        (BuildParameters::default().with_spatial_bins(0), "spatial_bins"),
        (BuildParameters::default().with_object_bins(64), "object_bins"),
        (BuildParameters::default().with_duplication_budget(-1.0), "duplication_budget"),
    ] {
        let error = Scene::builder(soup([]))
            .parameters(parameters)
            .observer(&NoProgress)
            .build()
            .expect_err("an error");
        assert!(error.to_string().starts_with(name), "{error}");
    }
}
