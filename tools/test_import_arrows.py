"""The import check must pass this house, and catch every way of breaking its order."""

from __future__ import annotations

from pathlib import Path

import import_arrows
import pytest

LIB = """
pub mod geometry;
pub use geometry::{Aabb, Vec3};
pub use mesh::Mesh;
pub use scene::Scene;
"""


def house(tmp_path: Path, files: dict[str, str]) -> Path:
    """A workspace whose library holds `files`, named relative to its src."""
    crate = tmp_path / "crates" / "halfline"
    for name, text in {"lib.rs": LIB, **files}.items():
        path = crate / "src" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (crate / "Cargo.toml").write_text('[package]\nname = "halfline"\n', encoding="utf-8")
    return tmp_path


def test_this_house_is_in_order() -> None:
    assert import_arrows.check(Path(__file__).resolve().parent.parent) == []


@pytest.mark.parametrize(
    ("file", "source", "complaint"),
    [
        ("geometry/ray.rs", "use crate::mesh::Mesh;", "geometry may not import mesh"),
        ("mesh/mod.rs", "use crate::tree;", "mesh may not import tree"),
        ("tree/node.rs", "use crate::builder::Params;", "tree may not import builder"),
        ("builder/mod.rs", "fn f() { crate::traverse::f() }", "builder may not import traverse"),
        ("builder/mod.rs", "use crate::{geometry::Aabb, scene};", "builder may not import scene"),
        ("builder/mod.rs", "use crate::Scene;", "builder may not import scene"),
        ("builder/mod.rs", "use crate::{mesh::{self, M}, Scene};", "builder may not import scene"),
        ("geometry.rs", "use super::mesh::Mesh;", "geometry may not import mesh"),
        ("numeric/a.rs", "use super::super::tree::Node;", "numeric may not import tree"),
        ("numeric/a.rs", "mod a { use super::super::super::tree }", "numeric may not import tree"),
        ("numeric/mod.rs", "use crate::simd::Lanes;", "numeric may not import simd"),
        ("textbook.rs", "use crate::tree::Node;", "textbook may not import tree"),
        ("brute_force.rs", "use crate::traverse;", "brute_force may not import traverse"),
        ("scene.rs", "use crate::explain::Walk;", "scene may not import explain"),
        ("storage/buffer.rs", "use crate::mesh::Mesh;", "storage may not import mesh"),
        ("scene.rs", "use crate::brute_force;", "scene may not import brute_force"),
        ("error.rs", "use crate::geometry::Vec3;", "error may not import geometry"),
        ("builder/mod.rs", "use crate::*;", "builder imports every room"),
        ("builder/mod.rs", "use crate::colours;", "builder imports colours, which is no room"),
        ("kitchen/mod.rs", "", "unknown room kitchen"),
        ("mesh/mod.rs", "pub(in crate::scene) fn f() {}", "mesh may not import scene"),
        ("mesh/mod.rs", "#[cfg(not(test))] mod a { use crate::tree; }", "mesh may not import tree"),
        ("mesh/mod.rs", "#[cfg(test)] mod tests {} use crate::tree;", "mesh may not import tree"),
    ],
)
def test_an_arrow_that_goes_back_is_caught(
    tmp_path: Path, file: str, source: str, complaint: str
) -> None:
    complaints = import_arrows.check(house(tmp_path, {file: source}))
    assert len(complaints) == 1
    assert complaint in complaints[0]


@pytest.mark.parametrize(
    ("file", "source"),
    [
        ("scene.rs", "use crate::traverse; use crate::builder; use crate::geometry::Ray;"),
        ("numeric/a.rs", "use super::Format; use crate::mesh::Mesh; use crate::error::Error;"),
        ("builder/mod.rs", "use crate::{Aabb, Mesh, numeric::{self, bounds}}; use std::io;"),
        ("builder/sub/mod.rs", "use super::super::tree; mod a { use super::super::super::mesh; }"),
        ("builder/tests.rs", "use crate::textbook; use crate::scene::Scene;"),
        ("textbook.rs", "use crate::numeric::triangle; use crate::mesh::Mesh;"),
        ("mesh/mod.rs", "// use crate::tree;\n/* a /* crate::tree */ crate::tree */ fn f() {}"),
        ("mesh/mod.rs", 'fn f() { g("crate::x", r#"" crate::tree"#, b"\\" crate::tree", \'"\') }'),
        ("mesh/mod.rs", "fn f<'a>(x: &'a str) -> char { '\\'' } fn g<'b>(x: &'b str) {}"),
        ("mesh/mod.rs", "#[cfg(test)]\nmod tests {\n use crate::scene; use super::super::tree;\n}"),
        ("mesh/mod.rs", "#[cfg(test)] #[allow(x)] pub(crate) mod tests { use crate::textbook; }"),
    ],
)
def test_what_is_allowed_passes(tmp_path: Path, file: str, source: str) -> None:
    assert import_arrows.check(house(tmp_path, {file: source})) == []


def test_a_complaint_names_the_line(tmp_path: Path) -> None:
    source = '/* one\n two */\nconst A: &str = "three\nfour";\nuse crate::scene;\n'
    (complaint,) = import_arrows.check(house(tmp_path, {"mesh/mod.rs": source}))
    assert complaint.endswith("mesh/mod.rs:5: mesh may not import scene")


def test_unsafe_is_caught_outside_its_rooms(tmp_path: Path) -> None:
    block = "fn f() { unsafe { g() } }"
    files = {
        "storage/mod.rs": block,
        "simd/avx2.rs": block,
        "numeric/a.rs": "// unsafe\n" + block,
        "mesh/mod.rs": "#[cfg(test)] mod tests { " + block + " }",
    }
    root = house(tmp_path, files)
    example = root / "crates" / "halfline" / "examples" / "one.rs"
    example.parent.mkdir()
    example.write_text(block, encoding="utf-8")
    complaints = import_arrows.check(root)
    places = [complaint.split("halfline/")[1].split(" ")[0] for complaint in complaints]
    assert places == ["examples/one.rs:1:", "src/mesh/mod.rs:1:", "src/numeric/a.rs:2:"]


@pytest.mark.parametrize(
    "dependency",
    [
        "[dependencies]\nhalfline-cli.workspace = true",
        '[dev-dependencies]\nhalfline-cli = { path = "../halfline-cli" }',
        "[dependencies.halfline-cli]\nworkspace = true",
        '[target."cfg(unix)".dependencies]\nhalfline-cli.workspace = true',
    ],
)
def test_a_crate_that_depends_backwards_is_caught(tmp_path: Path, dependency: str) -> None:
    root = house(tmp_path, {})
    manifest = root / "crates" / "halfline-render" / "Cargo.toml"
    manifest.parent.mkdir()
    text = (
        f'[package]\nname = "halfline-render"\n\n[dependencies]\nhalfline = "1"\n\n{dependency}\n'
    )
    manifest.write_text(text, encoding="utf-8")
    (complaint,) = import_arrows.check(root)
    assert "halfline-render may not depend on halfline-cli" in complaint


@pytest.mark.parametrize(
    ("dependency", "complaints"),
    [
        ('[dev-dependencies]\nhalfline-io = { path = "../halfline-io" }', []),
        ("[dev-dependencies]\nhalfline-io.workspace = true", ["by its path alone"]),
        (
            '[dev-dependencies]\nhalfline-io = { path = "../halfline-io", version = "1" }',
            ["by its path alone"],
        ),
        (
            '[dependencies]\nhalfline-io = { path = "../halfline-io" }',
            ["halfline may not depend on halfline-io"],
        ),
    ],
)
def test_the_library_is_tested_with_models_and_does_not_need_them(
    tmp_path: Path, dependency: str, complaints: list[str]
) -> None:
    root = house(tmp_path, {})
    manifest = root / "crates" / "halfline" / "Cargo.toml"
    manifest.write_text(f'[package]\nname = "halfline"\n\n{dependency}\n', encoding="utf-8")
    found = import_arrows.check(root)
    assert len(found) == len(complaints)
    for line, complaint in zip(found, complaints, strict=True):
        assert complaint in line
