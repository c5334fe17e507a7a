#!/usr/bin/env python3
"""Writes what the fuzzers begin with, fuzz/seeds/TARGET/*: small files of every kind.

Run by hand after a change here; the files are committed. Equal runs write equal bytes.
"""

from __future__ import annotations

import base64
import json
import random
import struct
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SEEDS = ROOT / "fuzz" / "seeds"
JPEG = ROOT / "crates" / "halfline" / "tests" / "mesh_files" / "red.jpg"

SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.5)]
FACES = [(0, 1, 2), (0, 2, 3)]


def ply_header(encoding: str, *lines: str) -> bytes:
    """A PLY header of the given lines."""
    return "\n".join(["ply", f"format {encoding} 1.0", *lines, "end_header", ""]).encode()


XYZ = ["property float x", "property float y", "property float z"]
INDICES = "property list uchar int vertex_indices"


def ply_files() -> dict[str, bytes]:
    """Every encoding; colours, strips, foreign elements and lists."""
    plain = ["element vertex 4", *XYZ, "element face 2", INDICES]
    text = "".join(f"{x} {y} {z}\n" for x, y, z in SQUARE)
    text += "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    files = {"ascii": ply_header("ascii", "comment a square", *plain) + text.encode()}
    for name, order in [("little", "<"), ("big", ">")]:
        body = b"".join(struct.pack(order + "3f", *p) for p in SQUARE)
        body += b"".join(struct.pack(order + "B3i", 3, *f) for f in FACES)
        files[name] = ply_header(f"binary_{name}_endian", *plain) + body

        colors = [f"property uchar {c}" for c in ("red", "green", "blue")]
        rich = ["element camera 1", "property list uchar double m", "element vertex 4"]
        rich += [line.replace("float", "double") for line in XYZ] + colors
        rich += ["element face 2", "property uchar flags"]
        rich += ["property list uint ushort vertex_index", "property list uchar float uv"]
        body = struct.pack(order + "B2d", 2, 1.5, 2.5)
        body += b"".join(struct.pack(order + "3d3B", *p, 255, 9, 0) for p in SQUARE)
        body += struct.pack(order + "BI4HB", 7, 4, 0, 1, 2, 3, 0)
        body += struct.pack(order + "BI3HBf", 7, 3, 0, 2, 3, 1, 0.5)
        files[f"rich_{name}"] = ply_header(f"binary_{name}_endian", *rich) + body

        strips = ["element vertex 4", *XYZ, "element tristrips 1"]
        strips.append("property list int int vertex_indices")
        body = b"".join(struct.pack(order + "3f", *p) for p in SQUARE)
        body += struct.pack(order + "8i", 7, 0, 1, 2, -1, 1, 2, 3)
        files[f"strips_{name}"] = ply_header(f"binary_{name}_endian", *strips) + body
    return files


def stl_files() -> dict[str, bytes]:
    """Both encodings."""
    corners = [[SQUARE[i] for i in face] for face in FACES]
    binary = b"binary".ljust(80) + struct.pack("<I", len(corners))
    text = "solid a square\n"
    for facet in corners:
        binary += struct.pack("<12fH", 0, 0, 1, *(x for p in facet for x in p), 0)
        text += "facet normal 0 0 1\n  outer loop\n"
        text += "".join(f"    vertex {x} {y} {z}\n" for x, y, z in facet)
        text += "  endloop\nendfacet\n"
    precise = text.replace("1.0", "0.123456789012345")
    return {
        "binary": binary,
        "ascii": (text + "endsolid a square\n").encode(),
        "double": ("\ufeff" + precise + "endsolid\nsolid\nendsolid\n").encode(),
    }


def obj_files() -> dict[str, bytes]:
    """Polygons, relative and textured indices, colours, continued lines; materials."""
    return {
        "polygons": b"# a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n0\nv 0.5 .1 0\n"
        b"f 1/1 2//2 3/3/3 -1 -2\nf 1 2 3\nf 3 4 -1 1\n",
        "materials": b"mtllib a.mtl\nv 0 0 0 1 1 1\nv 1 0 0 1 .5 0\nv 1 1 0 0 0 0\n"
        b"vt 0 0\nvn 0 0 1\ng b\ns off\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n\0mtl\0"
        b"newmtl a\nKd 1 .5 0\nKs .5\nNs 100\nd 0.5\nNi 1.5\nillum 7\n"
        b"newmtl b\nTr 0.25\nPr .1\nPm 1\nmap_Kd x.png\nKd spectral x.rfl 1\n",
    }


def off_files() -> dict[str, bytes]:
    """Plain, with everything a vertex may have, in n dimensions, without a keyword."""
    return {
        "plain": b"OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n3 0 2 3\n",
        "full": b"STCNOFF # x\n4 2 0\n0 0 0 0 0 1 1 0 0 .5 .5\n1 0 0 0 0 1 0 .5 0 0 0\n"
        b"1 1 0 0 0 1 1 1 1 0 0\n0 1 0 0 0 1 1 1 1 0 0\n4 0 1 2 3\n3 0 1 2 0.1 0.1 0.1\n",
        "colors": b"COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 1 1 1 1\n3 0 1 2 9\n",
        "homogeneous": b"4OFF 3 1 3\n0 0 0 1\n1 0 0 1\n0 1 0 2\n3 0 1 2 255 0 0\n",
        "dimensions": b"nOFF 3\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "binary": b"OFF BINARY\n" + struct.pack(">3i", 0, 0, 0),
    }


def png() -> bytes:
    """A picture of two by two pixels."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">2I5B", 2, 2, 8, 2, 0, 0, 0)
    rows = b"\0\xff\0\0\0\xff\0\0\0\0\xff\x80\x80\x80"
    data = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + data


def gltf_parts() -> tuple[dict[str, object], bytes]:
    """Positions, colours, texture coordinates, indices, sparse values, images."""
    flat = [x for p in SQUARE for x in p]
    parts = [
        struct.pack("<12f", *flat),
        bytes([128] * 16),
        struct.pack("<8f", 0, 0, 1, 0, 0, 1, 0.5, 0.5),
        struct.pack("<6H", 0, 1, 2, 3, 0, 1),
        bytes([1, 3, 0, 0]),
        struct.pack("<6f", 2, 2, 2, 3, 3, 3),
        png(),
        JPEG.read_bytes(),
    ]
    views = []
    binary = b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + b"\0" * (-len(part) % 4)

    def accessor(view: int, component: int, count: int, kind: str) -> dict[str, object]:
        part = {"bufferView": view, "componentType": component, "count": count, "type": kind}
        return part | ({"normalized": True} if component == 5121 else {})

    sparse = {
        "count": 2,
        "indices": {"bufferView": 4, "componentType": 5121},
        "values": {"bufferView": 5},
    }
    attributes = {"POSITION": 0, "COLOR_0": 1, "TEXCOORD_0": 2}
    textured = [{"baseColorTexture": {"index": i}} for i in (0, 1)]
    document: dict[str, object] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 2]}],
        "nodes": [
            {"mesh": 0, "children": [1]},
            {"mesh": 1, "scale": [2, -2, 2], "rotation": [0, 0, 1, 0], "translation": [1, 0, 0]},
            {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1], "mesh": 1},
        ],
        "meshes": [
            {"primitives": [{"attributes": attributes, "indices": 3, "material": 0}]},
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "mode": 5, "material": 1},
                    {"attributes": {"POSITION": 4}, "mode": 6},
                ]
            },
        ],
        "accessors": [
            accessor(0, 5126, 4, "VEC3"),
            accessor(1, 5121, 4, "VEC4"),
            accessor(2, 5126, 4, "VEC2"),
            accessor(3, 5123, 6, "SCALAR"),
            {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse},
        ],
        "materials": [
            {"pbrMetallicRoughness": textured[0], "emissiveFactor": [1, 0, 0]},
            {"pbrMetallicRoughness": textured[1] | {"metallicFactor": 0}, "alphaMode": "BLEND"},
        ],
        "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"bufferView": 6, "mimeType": "image/png"}, {"bufferView": 7}],
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return document, binary


def compact(document: object) -> bytes:
    """JSON without blanks."""
    return json.dumps(document, separators=(",", ":")).encode()


def gltf_files() -> dict[str, bytes]:
    """A document with its data in it, one with files beside it, a binary one."""
    document, binary = gltf_parts()
    text = compact(document)
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    glb = struct.pack("<4s2I", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary))
    glb += struct.pack("<I4s", len(text), b"JSON") + text
    glb += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    inside = document | {"buffers": [{"byteLength": len(binary), "uri": uri}]}
    primitive = {"attributes": {"POSITION": 0}, "material": 0}
    beside = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "a.jpg"}],
        "bufferViews": [{"buffer": 0, "byteLength": 128, "byteStride": 16}],
        "buffers": [{"byteLength": 256, "uri": "a.bin"}],
    }
    return {"inside": compact(inside), "beside": compact(beside), "binary": glb}


def gzip_files() -> dict[str, bytes]:
    """A byte for the name, four for the kind of wrapping, its numbers, the content.

    That is how the target's `arbitrary` understands them: it takes a kind from the upper bits of
    32, so each of four kinds is a quarter of the range.
    """
    contents = {
        0: ply_files()["little"],
        1: stl_files()["ascii"],
        2: obj_files()["polygons"],
        3: off_files()["full"],
        4: gltf_files()["beside"],
    }
    kinds = {
        "whole": struct.pack("<IB", 0, 100),
        "damaged": struct.pack("<IBHB", 1 << 30, 100, 30, 1),
        "short": struct.pack("<IBB", 2 << 30, 100, 9),
    }
    files = {
        f"{kind}_{name}": bytes([name]) + numbers + content
        for kind, numbers in kinds.items()
        for name, content in contents.items()
        if kind == "whole" or name == 0
    }
    stream = zlib.compressobj(wbits=31)
    file = stream.compress(contents[1]) + stream.flush()
    return files | {"raw": bytes([6]) + struct.pack("<I", 3 << 30) + file}


def npy_files() -> dict[str, bytes]:
    """Every type of number, order and version; the first byte is the target's own."""

    def file(version: int, dtype: str, fortran: bool, columns: int) -> bytes:
        shape = (3, columns)
        header = f"{{'descr': '{dtype}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n"
        length = struct.pack("<H" if version == 1 else "<I", len(header))
        data = struct.pack(
            dtype[0] + str(3 * columns) + ("f" if dtype[2] == "4" else "d"), *range(3 * columns)
        )
        start = b"\x93NUMPY" + bytes([version, 0]) + length + header.encode()
        return bytes([1]) + start + data

    return {
        "single": file(1, "<f4", False, 6),
        "double": file(2, "<f8", False, 8),
        "big": file(3, ">f4", True, 8),
        "columns": file(1, ">f8", True, 6),
    }


def build_query_files() -> dict[str, bytes]:
    """Bytes at random: the target makes a mesh and rays of any."""
    source = random.Random(1)
    return {f"random_{size}": source.randbytes(size) for size in (100, 300, 600, 1200)}


def main() -> None:
    """Writes all seeds."""
    targets = {
        "ply": ply_files(),
        "stl": stl_files(),
        "obj": obj_files(),
        "off": off_files(),
        "gltf": gltf_files(),
        "gzip": gzip_files(),
        "npy": npy_files(),
        "build_query": build_query_files(),
        "build_query_any": build_query_files(),
    }
    for target, files in targets.items():
        folder = SEEDS / target
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
