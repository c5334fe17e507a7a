"""The questions of `Scene` over Dask arrays of rays and points, and pictures drawn by a cluster.

    import halfline.dask

    scene = halfline.open("scan.hlt")
    hits = halfline.dask.intersect(scene, origins, directions)  # dask arrays in, lazy
    nearest, face = dask.compute(hits.t.min(), hits.face)       # each ray is cast once
    distance = halfline.dask.signed_distance(scene, points)     # of points, lazy as well
    image = scene.render(client=client)                         # or halfline.dask.render

The answers are those of `Scene`, to the bit, whatever the chunks and whichever worker does what.

What travels is the path of the tree's file and its content hash. A worker opens the file there, and
keeps the last few of them open. If it does not see the path, or finds another file there, it looks
in its machine's cache of trees, and then asks the other workers for the bytes; `publish` sends them
once to each machine that lacks them, and `render` calls it. The cache is a folder `halfline-trees`
beside the workers' scratch folders (`dask worker --local-directory`, or Dask's
`temporary-directory`), or what the environment variable HALFLINE_CACHE says.

The threads of a worker process that was started by Dask's nanny are as many as Dask gave it,
whatever the number of its tasks at a time: halfline's pool has so many there, unless
HALFLINE_THREADS says otherwise. Everywhere else they are as always.

Needs Dask: `pip install 'halfline[dask]'`.
"""

from __future__ import annotations

try:
    import dask.array  # noqa: F401
    import distributed  # noqa: F401
except ImportError as error:
    raise ImportError(
        f"halfline.dask needs Dask, pip install 'halfline[dask]': {error}", name=error.name
    ) from None

from halfline.dask._lazy_hits import LazyHits
from halfline.dask._lazy_nearest import LazyNearest
from halfline.dask._points import closest_points, contains, signed_distance, winding_number
from halfline.dask._publish import publish, unpublish
from halfline.dask._rays import count_intersections, intersect, occluded
from halfline.dask._render import render
from halfline.dask._trees import MissingTreeError

__all__ = [
    "LazyHits",
    "LazyNearest",
    "MissingTreeError",
    "closest_points",
    "contains",
    "count_intersections",
    "intersect",
    "occluded",
    "publish",
    "render",
    "signed_distance",
    "unpublish",
    "winding_number",
]
