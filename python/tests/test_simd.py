"""`HALFLINE_SIMD` chooses the instruction set, and no answer depends on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Halfline, Judged


def names(halfline: Halfline, judged: Judged, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The instruction sets of this machine, as the error for an unknown one lists them."""
    monkeypatch.setenv("HALFLINE_SIMD", "mmx")
    error = halfline.complains("render", judged.path, "--output", judged.path.with_suffix(".png"))
    assert 'HALFLINE_SIMD: is "mmx"; this machine has ' in error
    assert not judged.path.with_suffix(".png").exists()
    return error.split(" has ")[1].split(", ")


@pytest.mark.parametrize("option", [(), ("--any",), ("--all",)])
def test_all_instruction_sets_give_the_same_bits(
    halfline: Halfline,
    judged: Judged,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    option: tuple[str, ...],
) -> None:
    available = names(halfline, judged, monkeypatch)
    assert available[0] == "scalar"
    monkeypatch.delenv("HALFLINE_SIMD")
    expected = halfline.query(judged.path, judged.rays, tmp_path, *option)
    for name in available:
        monkeypatch.setenv("HALFLINE_SIMD", name)
        hits = halfline.query(judged.path, judged.rays, tmp_path, *option)
        assert hits.keys() == expected.keys()
        for key, array in expected.items():
            np.testing.assert_array_equal(hits[key].view(np.uint8), array.view(np.uint8))


def test_an_empty_choice_is_none(
    halfline: Halfline, judged: Judged, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HALFLINE_SIMD", "")
    assert len(halfline.query(judged.path, judged.rays, tmp_path)["t"]) == len(judged.rays)
