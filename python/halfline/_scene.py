"""Scenes: meshes that answer questions about rays."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfline._arrays import count_of, path_of, points_of, rays_of
from halfline._explanation import Explanation
from halfline._hits import AllHits, Hits
from halfline._html import table
from halfline._image import Image
from halfline._mesh import Mesh, MeshLike, mesh_of
from halfline._native import FormatError, Picture, RenderSettings
from halfline._native import Scene as NativeScene
from halfline._nearest import Nearest
from halfline._progress import Progress, reporting

if TYPE_CHECKING:
    from distributed import Client

Vector: TypeAlias = Sequence[float]
"""Three numbers."""

Color: TypeAlias = str | Sequence[float]
"""An sRGB colour: "#rrggbb", or red, green and blue in 0..1."""


class Scene:
    """A mesh with a tree over it, which answers questions about rays.

    `Scene(mesh)`, `Scene(vertices, faces)`, and `Scene(anything)` with `.vertices` and `.faces`
    build the tree, on all threads (see `set_thread_count`). A scene never changes; it may be asked
    from many threads at once, in children of `fork`, and after it was pickled.

    All questions take rays as `origins` and `directions`, arrays of shape (..., 3) whose leading
    dimensions are broadcast against each other and kept in the answer. A direction need not have
    unit length: `t` is in units of the direction. What is C-contiguous float32 or float64, each as
    it likes, is not copied; other layouts, integers and float16 are; no number is rounded. A ray
    with a NaN or an infinite coordinate, without a direction, or with `t_min > t_max` hits nothing.
    Rays of shape (height, width, 3) are cast in tiles, which is quicker where neighbours are alike.

    Every hit is that of the exact ray with the exact triangles: no ray slips between triangles that
    share an edge or a vertex, and each crossing of a closed surface counts once. docs/numerics.md
    derives it. The tree is that of Stich, Friedrich and Dietrich, "Spatial splits in bounding
    volume hierarchies" (2009), collapsed to nodes of eight children, as ARCHITECTURE.md tells.

    Args:
        mesh: A `Mesh`, or anything with `vertices` and `faces`; or the vertices, shape (n, 3).
        faces: Indices of vertices, shape (m, 3), any integers; only with vertices.
        preset: "fast" for the first answers soonest, "balanced" for about as many rays as there are
            triangles and more, "best" for the most rays a second. The answers are the same.
        progress: True for a bar (of tqdm, where it is installed), or a callable
            `progress(stage, done, total)` with the stage "build".

    Raises:
        TypeError: For what is no mesh.
        ValueError: For wrong arrays, more than 2^29 triangles, or an unknown preset.
        KeyboardInterrupt: On Ctrl-C.

    Examples:
        >>> import halfline
        >>> import numpy as np
        >>> scene = halfline.Scene(halfline.generate("sphere", 1280))
        >>> eyes, pixels = np.zeros((5, 1, 1, 3)), np.ones((48, 64, 3))
        >>> scene.intersect(eyes, pixels).point.shape
        (5, 48, 64, 3)
    """

    __slots__ = ("__weakref__", "_mesh", "_native")

    def __init__(
        self,
        mesh: Mesh | MeshLike | ArrayLike,
        faces: ArrayLike | None = None,
        *,
        preset: str = "balanced",
        progress: Progress = None,
    ) -> None:
        self._mesh = mesh_of(mesh, faces)
        with reporting(progress) as report:
            self._native = NativeScene.build(self._mesh._native, preset, report)

    @classmethod
    def _of(cls, native: NativeScene) -> Scene:
        scene = cls.__new__(cls)
        scene._mesh = Mesh._of(native.mesh)
        scene._native = native
        return scene

    @property
    def mesh(self) -> Mesh:
        """The mesh."""
        return self._mesh

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> Hits:
        """The closest hit of each ray; of equally close ones that with the lowest face index.

        Args:
            origins: Where rays begin, shape (..., 3).
            directions: How far one unit of t reaches, shape (..., 3).
            t_min: Smallest t that counts, itself included: a number, or shape (...).
            t_max: Largest t that counts, itself included: a number, or shape (...).
            progress: True for a bar, or a callable `progress(stage, done, total)` with the stage
                "trace" and rays.

        Returns:
            `t`, `face`, `uv`, `point`, `normal` and `hit` of the rays' leading dimensions; a miss
            has t infinite and face -1.

        Raises:
            TypeError: For arrays of complex numbers, objects, strings, booleans or longdouble.
            ValueError: For shapes that do not end in 3 or cannot be broadcast.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, rays = rays_of(origins, directions, t_min, t_max)
        t = np.empty(shape)
        face = np.empty(shape, dtype=np.int64)
        uv = np.empty((*shape, 2))
        if progress is None:
            self._native.intersect(*rays, t, face, uv)
        else:
            with reporting(progress) as report:
                self._native.intersect(*rays, t, face, uv, report)
        return Hits(self._mesh, t, face, uv)

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything, which is quicker than to find what.

        With directions from point to point and `t_max=1` it is whether something lies between.
        Arguments and exceptions are those of `intersect`.

        Returns:
            The rays' leading dimensions, bool.
        """
        shape, rays = rays_of(origins, directions, t_min, t_max)
        flags = np.empty(shape, dtype=np.bool_)
        with reporting(progress) as report:
            self._native.occluded(*rays, flags, report)
        return flags

    def count_intersections(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> NDArray[np.int64]:
        """How many hits each ray has: the lengths of the rows of `intersect_all`.

        From a point inside a closed surface the number is odd, from outside it is even. Arguments
        and exceptions are those of `intersect`.

        Returns:
            The rays' leading dimensions, int64.
        """
        shape, rays = rays_of(origins, directions, t_min, t_max)
        counts = np.empty(shape, dtype=np.int64)
        with reporting(progress) as report:
            self._native.count_intersections(*rays, counts, report)
        return counts

    def intersect_all(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> AllHits:
        """All hits of each ray: every crossing, and contacts with the border of open surfaces.

        A ray through an edge or a vertex of a closed surface crosses it once there, or not at all
        where it only touches it. Arguments and exceptions are those of `intersect`.

        Returns:
            `splits`, `t`, `face`, `uv`, `point`, `normal` and `ray`, in compressed sparse rows.
        """
        shape, rays = rays_of(origins, directions, t_min, t_max)
        with reporting(progress) as report:
            splits, t, face, uv = self._native.intersect_all(count_of(shape), *rays, report)
        return AllHits(self._mesh, shape, splits, t, face, uv.reshape(-1, 2))

    def closest_points(
        self,
        points: ArrayLike,
        *,
        max_distance: ArrayLike = np.inf,
        progress: Progress = None,
    ) -> Nearest:
        """The point of the mesh that is nearest to each point.

        It is that of exact arithmetic on the coordinates as they are given, of whatever size: of
        faces that are equally near that with the lowest index counts, as around an edge or a
        vertex. Faces without area count as the segments and points that they are. docs/numerics.md
        derives it.

        Args:
            points: Shape (..., 3).
            max_distance: Farthest that counts, itself included: a number, or shape (...).
            progress: True for a bar, or a callable `progress(stage, done, total)` with the stage
                "trace" and points.

        Returns:
            `distance`, `point`, `face`, `uv`, `feature`, `normal` and `found` of the points'
            leading dimensions. Where nothing is near enough, and for a point with a NaN or an
            infinite coordinate, the distance is infinite, the face -1, and the rest NaN.

        Raises:
            TypeError: For arrays of complex numbers, objects, strings, booleans or longdouble.
            ValueError: For shapes that do not end in 3 or cannot be broadcast.
            KeyboardInterrupt: On Ctrl-C.

        Examples:
            >>> import halfline
            >>> scene = halfline.Scene([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
            >>> near = scene.closest_points([[1, 1, 2], [-3, -4, 0]])
            >>> near.distance, near.feature
            (array([2., 5.]), array(['face', 'vertex'], dtype='<U6'))
        """
        shape, where, most = points_of(points, max_distance)
        distance, face = np.empty(shape), np.empty(shape, dtype=np.int64)
        point, uv = np.empty((*shape, 3)), np.empty((*shape, 2))
        code = np.empty(shape, dtype=np.uint8)
        with reporting(progress) as report:
            self._native.closest_points(where, most, distance, point, face, uv, code, report)
        return Nearest(self._mesh, distance, point, face, uv, code)

    def signed_distance(
        self, points: ArrayLike, *, progress: Progress = None
    ) -> NDArray[np.float64]:
        """How far each point is from the surface: negative inside, positive outside, 0 on it.

        Inside is where `contains` is true, so it works for surfaces with holes as well.
        `halfline.trimesh` and `halfline.open3d` keep the signs of their namesakes. Arguments and
        exceptions are those of `closest_points`.

        Returns:
            The points' leading dimensions, float64. NaN for a point with a NaN or an infinite
            coordinate; infinite where the mesh has no face.
        """
        shape, where, _ = points_of(points)
        distance = np.empty(shape)
        with reporting(progress) as report:
            self._native.signed_distance(where, distance, report)
        return distance

    def winding_number(
        self, points: ArrayLike, *, progress: Progress = None
    ) -> NDArray[np.float64]:
        """How often the surface winds around each point: 1 inside, 0 outside of a closed one.

        It is the sum of the solid angles of all faces over that of the sphere, positive where their
        vertices run counter-clockwise as seen from outside (A. Jacobson, L. Kavan, O.
        Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers",
        2013). For a closed and consistently oriented surface it is exactly an integer; for others
        it is within 1e-9. It is found by the crossings of one ray and the open boundary alone
        (Martens, Trettner, Bessmeltsev, "The Antipodal Method for the Generalized Winding Number",
        2026), which is kept
        once it was asked for. Arguments and exceptions are those of `closest_points`.

        Returns:
            The points' leading dimensions, float64; NaN for a point with a NaN or an infinite
            coordinate. On the surface, where it jumps, it is one of the values on both sides, or
            between them.
        """
        shape, where, _ = points_of(points)
        numbers = np.empty(shape)
        with reporting(progress) as report:
            self._native.winding_number(where, numbers, report)
        return numbers

    def contains(
        self, points: ArrayLike, *, rule: str = "winding", progress: Progress = None
    ) -> NDArray[np.bool_]:
        """Whether each point is inside; what is on the surface is.

        Args:
            points: Shape (..., 3).
            rule: "winding": the winding number is above one half, which is decided with certainty,
                for open surfaces too. "parity": a ray from the point crosses the surface an odd
                number of times, whichever way its faces are oriented; for closed surfaces.
            progress: As for `closest_points`.

        Returns:
            The points' leading dimensions, bool; False for a point with a NaN or an infinite
            coordinate.

        Raises:
            ValueError: For another rule, and as `closest_points`.
            TypeError: As `closest_points`.
            KeyboardInterrupt: On Ctrl-C.
        """
        shape, where, _ = points_of(points)
        flags = np.empty(shape, dtype=np.bool_)
        with reporting(progress) as report:
            self._native.contains(where, rule, flags, report)
        return flags

    def save(self, path: str | os.PathLike[str], *, progress: Progress = None) -> None:
        """Writes mesh and tree to a file, which `halfline.open` maps in no time.

        The file appears whole or not at all, and is on the disk when this returns. The scene itself
        stays in memory; docs/tree-file.md specifies the file.

        Args:
            path: Where to; by convention the name ends in .hlt.
            progress: As for `Scene`, with the stage "write".

        Raises:
            ValueError: For a name that is that of a mesh, as in scan.ply.
            OSError: If the file cannot be written.
            FormatError: If the scene is from a file that was damaged meanwhile.
            KeyboardInterrupt: On Ctrl-C; what was at `path` is still there.
        """
        name = path_of("path", path)
        if name.lower().endswith(_MESH_NAMES):
            raise ValueError(f"path: expected the name of a tree, as in scan.hlt, found {name!r}")
        with reporting(progress) as report:
            self._native.save(name, report)

    @property
    def path(self) -> Path | None:
        """The tree file that the scene was opened from, absolute; None for a scene in memory."""
        file = self._native.file
        return None if file is None else Path(file[0])

    @property
    def content_hash(self) -> str | None:
        """What tells the scene's file apart from others, 32 hexadecimal digits.

        It is the same for the same mesh and preset on every machine; None for a scene in memory.
        """
        file = self._native.file
        return None if file is None else file[1]

    def explain(
        self,
        origin: ArrayLike,
        direction: ArrayLike,
        *,
        t_min: float = 0.0,
        t_max: float = np.inf,
        rule: str = "sah",
        progress: Progress = None,
    ) -> Explanation:
        """Tells why a ray hits what it hits, or nothing: its walk through the tree, step by step.

        It is the walk through the lecture's kd-tree (V. Havran, "Heuristic Ray Shooting
        Algorithms", 2000, chapter 4), whose cells are split only where the ray comes, and beside it
        what the engine did for the same hit. For a ray that hits nothing the triangle that it
        passes closest is found. It takes some passes over the mesh, so seconds for millions of
        triangles.

        Args:
            origin: Where the ray begins, shape (3,).
            direction: How far one unit of t reaches, shape (3,).
            t_min: Smallest t that counts, itself included.
            t_max: Largest t that counts, itself included.
            rule: Where the lecture's tree splits cells: "sah" (surface-area heuristic), "middle" or
                "median".
            progress: A callable that is asked from time to time; True has nothing to show.

        Returns:
            What became of the ray; it prints as text, and shows itself in Jupyter as a page to step
            through.

        Raises:
            TypeError: As `intersect`.
            ValueError: For more than one ray, an unknown rule, and a ray that hits nothing whatever
                the mesh: with a NaN or an infinite coordinate, without a direction, or with
                `t_min > t_max`.
            KeyboardInterrupt: On Ctrl-C.
        """
        return Explanation._of(self._native, origin, direction, (t_min, t_max), rule, progress)

    def render(
        self,
        *,
        width: int = 1280,
        height: int = 720,
        samples: int = 16,
        seed: int = 0,
        shading: str = "clay",
        up: str = "+Y",
        camera_position: Vector | None = None,
        camera_focal_point: Vector | None = None,
        camera_view_up: Vector | None = None,
        camera_view_angle: float | None = None,
        camera_azimuth_angle: float | None = None,
        camera_elevation_angle: float | None = None,
        camera_orthographic: bool | float | None = None,
        background: Color = "studio",
        ground: bool | Color | None = None,
        ground_height: float | None = None,
        ground_reflectivity: float | None = None,
        material: str | None = None,
        color: Color | None = None,
        metallic: float | None = None,
        roughness: float | None = None,
        base_ior: float | None = None,
        smooth_angle: float | None = None,
        lights: Sequence[str] | None = None,
        max_depth: int | None = None,
        occlusion_rays: int | None = None,
        occlusion_reach: float | None = None,
        client: Client | None = None,
        progress: Progress = None,
    ) -> Image:
        """Draws a picture. The arguments are the options of `halfline render`; see its help.

        The picture is the same to the bit for any number of threads, and of workers.

        Args:
            width: Pixels from left to right.
            height: Pixels from top to bottom.
            samples: Rays from the eye through each pixel.
            seed: Chooses among equally good random numbers.
            shading: "clay", "whitted", "normal", "depth", "face" or "steps".
            up: Which axis points up: "+X", "-X", "+Y", "-Y", "+Z" or "-Z".
            camera_position: Where the camera is; by itself it shows the whole model.
            camera_focal_point: What it looks at.
            camera_view_up: The direction that is up in the picture.
            camera_view_angle: Angle between the top and the bottom of the picture, in degrees.
            camera_azimuth_angle: How far to go round the model, in degrees.
            camera_elevation_angle: How far to rise above its middle, in degrees.
            camera_orthographic: True, or the height of the picture in units of the model.
            background: "studio", "none" for transparency, or a colour.
            ground: True or "shadow", "checker", or a colour: a plane under the model.
            ground_height: Where the plane lies along the up axis.
            ground_reflectivity: How much it mirrors, 0 to 1 ("whitted").
            material: "plaster", "plastic", "metal", "mirror" or "glass" instead of the file's.
            color: Base colour.
            metallic: 0 for a dielectric, 1 for a metal.
            roughness: 0 for a mirror, 1 for fully rough.
            base_ior: Index of refraction, 1 to 4.
            smooth_angle: Faces that meet at less than this angle look smooth, in degrees.
            lights: Lights for "whitted", as `--light` has them.
            max_depth: How often light may be mirrored or refracted ("whitted").
            occlusion_rays: Rays into the surroundings for each ray from the eye ("clay").
            occlusion_reach: How far surfaces darken each other, as a share of the model's diagonal.
            client: A client of Dask, whose workers draw the picture; see `halfline.dask.render`.
            progress: As for `Scene`, with the stage "trace" in pixels.

        Returns:
            An array of uint8, shape (height, width, 3), or (height, width, 4) if transparent. It
            shows itself in Jupyter and has the other layers as attributes.

        Raises:
            TypeError: For an argument of a type that it cannot have.
            ValueError: For one that makes no sense, naming it and what was expected.
            KeyboardInterrupt: On Ctrl-C.
        """
        settings = {
            "width": width,
            "height": height,
            "samples": samples,
            "seed": seed,
            "shading": shading,
            "up": up,
            "camera_position": camera_position,
            "camera_focal_point": camera_focal_point,
            "camera_view_up": camera_view_up,
            "camera_view_angle": camera_view_angle,
            "camera_azimuth_angle": camera_azimuth_angle,
            "camera_elevation_angle": camera_elevation_angle,
            "camera_orthographic": camera_orthographic,
            "background": background,
            "ground": ground,
            "ground_height": ground_height,
            "ground_reflectivity": ground_reflectivity,
            "material": material,
            "color": color,
            "metallic": metallic,
            "roughness": roughness,
            "base_ior": base_ior,
            "smooth_angle": smooth_angle,
            "lights": lights,
            "max_depth": max_depth,
            "occlusion_rays": occlusion_rays,
            "occlusion_reach": occlusion_reach,
        }
        if client is not None:
            from halfline.dask import render

            return render(self, client=client, progress=progress, **settings)
        with reporting(progress) as report:
            return Image._of(Picture(self._native, RenderSettings(**settings)).trace(report))

    def info(self) -> dict[str, Any]:
        """The figures of mesh and tree, as `halfline info --json` names them.

        Returns:
            `triangles`, `vertices`, `precision`, `bounds` (two points, or None), `skipped`
            (triangles that no ray can hit), `skipped_degenerate`, `skipped_non_finite`, `preset`,
            `tree` (a dict, with `bytes` among others) and `build_seconds`.
        """
        bounds = self._mesh.bounds
        return {
            "triangles": self._mesh._native.triangle_count,
            "vertices": self._mesh._native.vertex_count,
            "precision": self._mesh._precision,
            "bounds": None if np.isnan(bounds).any() else bounds.tolist(),
            **self._native.info(),
        }

    def __copy__(self) -> Scene:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        file = self._native.file
        if file is not None:
            return _reopen, (file[0], file[1])
        return _build, (self._mesh, self._native.preset)

    def __repr__(self) -> str:
        mesh = self._mesh._native
        return (
            f"<halfline.Scene: {mesh.triangle_count:,} triangles, {self._mesh._precision}, "
            f"preset {self._native.preset!r}>"
        )

    def _repr_html_(self) -> str:
        info = self.info()
        tree = info["tree"]
        rows = [
            ("skipped", f"{info['skipped']:,} triangles that no ray can hit"),
            ("tree", f"{tree['bytes'] / 1e6:,.1f} MB, preset {info['preset']!r}"),
            ("built in", f"{info['build_seconds']:.3g} s"),
        ]
        return table("Scene", [*self._mesh._figures(), *rows])


_MESH_NAMES = (".ply", ".stl", ".obj", ".off", ".gltf", ".glb")


def _reopen(path: str, content_hash: str) -> Scene:
    """What a scene from a file pickles as."""
    scene = Scene._of(NativeScene.open(path))
    if scene.content_hash != content_hash:
        raise FormatError(
            f"{path}: header: this is not the tree that was pickled: its content hash is "
            f"{scene.content_hash} and was {content_hash}"
        )
    return scene


def _build(mesh: Mesh, preset: str) -> Scene:
    """What a scene in memory pickles as."""
    return Scene(mesh, preset=preset)
