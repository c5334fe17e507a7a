"""Draws a mesh with PyVista off-screen in a process of its own; run by `make bench-vtk`.

`python bench tools.vtk.pyvista MESH PICTURE.png VIEW WIDTH,HEIGHT` prints one JSON object. VIEW is
what `halfline generate --json` says of the view. Nothing of VTK's looks is changed but the
background.
"""

from __future__ import annotations

import json
import sys
from time import perf_counter

START = perf_counter()

import pyvista  # noqa: E402


def main() -> None:
    """Reads, draws, writes, reports."""
    mesh_path, picture, view, size = sys.argv[1], sys.argv[2], json.loads(sys.argv[3]), sys.argv[4]
    imported = perf_counter()
    mesh = pyvista.read(mesh_path)
    read = perf_counter()
    plotter = pyvista.Plotter(off_screen=True, window_size=[int(n) for n in size.split(",")])
    plotter.background_color = "white"
    plotter.add_mesh(mesh)
    plotter.camera.position = view["position"]
    plotter.camera.focal_point = view["focal_point"]
    plotter.camera.up = view["up"]
    plotter.camera.view_angle = view["angle_degrees"]
    plotter.reset_camera_clipping_range()
    plotter.screenshot(picture)
    drawn = perf_counter()
    capabilities = plotter.render_window.ReportCapabilities().splitlines()
    renderer = next((line for line in capabilities if "renderer string" in line), ":unknown")
    vtk_version = ".".join(str(number) for number in pyvista.vtk_version_info)
    report = {
        "tool": f"PyVista {pyvista.__version__} with VTK {vtk_version}",
        "triangles": mesh.n_cells,
        "renderer": renderer.split(":", 1)[1].strip(),
        "import_seconds": imported - START,
        "read_seconds": read - imported,
        "draw_seconds": drawn - read,
    }
    print(json.dumps(report))
