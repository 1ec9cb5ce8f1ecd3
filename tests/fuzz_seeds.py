"""Whole files of each format that `fuzz` damages, small ones."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

import abc_kit
import camera_kit
import exchange_kit as kit
import mesh_kit
import usd_kit
from strandcli.cameras import colmap, transforms, usd

MESH = "mesh"
"""What formats of meshes begin with: they are the ends of names, as those of strands."""
CAMERA = "camera "
"""Likewise of cameras, before whole names."""
COLMAP = ("cameras.txt", "images.txt")
"""Files that are read together."""


def grooms() -> Iterator[list[kit.Strand]]:
    """Small ones: equal strands, others, of one point, none."""
    generator = np.random.default_rng(5)
    yield list(generator.normal(size=(6, 5, 3)).astype(np.float32))
    yield [generator.normal(size=(count, 3)).astype(np.float32) for count in (3, 1, 9, 2, 30)]
    yield []


def npz(packed: bool, **arrays: object) -> bytes:
    file = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(file, **arrays)
    return file.getvalue()


def npy(values: object) -> bytes:
    file = io.BytesIO()
    np.save(file, values)
    return file.getvalue()


@cache
def seeds() -> dict[str, list[bytes]]:
    """Whole files of each format."""
    even, uneven, none = grooms()
    colours = np.ones((30, 3), "<f4").tobytes()
    positions = np.stack(even)
    usds = [usd_kit.text(even), usd_kit.text(uneven[2:], basis="bspline", wrap="pinned"), usd_kit.moving(even)]
    return {
        ".usd": [*(usd_kit.binary(one) for one in usds), *(one.encode() for one in usds)],
        ".hair": [kit.hair(even), kit.hair(uneven), kit.hair(none), kit.hair(even, more=colours, flags=16)],
        ".data": [kit.data(even), kit.data(uneven), kit.data(none)],
        ".bin": [kit.data(even, 4), kit.data(uneven, 4)],
        ".tfx": [kit.tfx3(even), kit.tfx4(even), kit.tfx4(even, uv=False)],
        ".ply": [
            *(kit.ply(groom, order, told=told) for groom in (even, uneven) for order in ("<", ">", "")
              for told in ("strand", "edge")),
            kit.ply(even, kind="double"), kit.ply(even, "", told="nothing"), kit.ply(even, told="nothing"),
        ],
        ".npz": [
            npz(False, positions=positions), npz(True, positions=positions.astype(np.float16)),
            npz(False, positions=np.asfortranarray(positions), root_uv=np.ones((6, 2))),
            npz(True, points=kit.of(uneven).points, first=kit.of(uneven).first, words=np.array(["a"])),
        ],
        ".abc": [abc_kit.rich(even), abc_kit.archive(uneven), abc_kit.rich(uneven), abc_kit.FROM_BLENDER.read_bytes()],
        ".npy": [npy(positions), npy(np.asfortranarray(positions.astype(">f8"))), npy(np.ones((4, 3, 4), "<f2"))],
        ".obj": [kit.obj(even), kit.obj(uneven), kit.obj(even, segments=True), kit.obj(uneven, back=True)],
        **mesh_seeds(),
        **camera_seeds(),
    }  # fmt: skip


def mesh_seeds() -> dict[str, list[bytes]]:
    """Whole files of each format of meshes, small ones."""
    box = mesh_kit.mesh("box")
    count = box.vertices.shape[0]
    seamed = replace(box, uv=np.random.default_rng(1).random((12, 3, 2)).round(2).astype(np.float32))
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7, 5]]
    more = {"density": np.ones(count, np.float32), **dict.fromkeys(("red", "green", "blue"), np.zeros(count, np.uint8))}
    tree, buffer = mesh_kit.gltf_tree(box, COLOR_0=np.ones((count, 3), "<f4"), TEXCOORD_0=np.ones((count, 2), "<f4"))
    inner = {**tree, "buffers": [{"uri": "data:;base64," + base64.b64encode(buffer).decode()}]}
    back = b"v 0 0 0\nv 1 0 0 1 0 0\nvn 0 0 1\nv 0 1 0\no a\nusemtl b\ns 1\nf -3//1 -2//1 -1//1\nv 1 1 0\nf 2 3 4 1\n"
    return {
        f"{MESH}.obj": [mesh_kit.obj(box), mesh_kit.obj(seamed), back],
        f"{MESH}.ply": [
            *(mesh_kit.ply(box, order, shape, more) for order in ("<", ">", "") for shape in (None, faces)),
            mesh_kit.ply(box),
        ],
        f"{MESH}.stl": [mesh_kit.stl(box), mesh_kit.stl(box, text=True)],
        f"{MESH}.glb": [mesh_kit.glb(tree, buffer), mesh_kit.glb(*mesh_kit.gltf_tree(box))],
        f"{MESH}.gltf": [json.dumps(inner).encode(), json.dumps(inner, indent=1).encode()],
    }


def camera_seeds() -> dict[str, list[bytes]]:
    """Whole files of each format of cameras, of a few views."""
    views, one = camera_kit.VIEWS[:3], [camera_kit.view(7, middle=True)]
    top = {"camera_angle_x": 0.6, "frames": [{"file_path": "a", "transform_matrix": np.eye(4).tolist()}]}
    nerf = [transforms.written(some, {"file_path": "images/{}.png"}, "1") for some in (views, one)]
    own = [{"views": [{"camera": view.as_dict()} for view in some]} for some in (views, one)]
    texts = [colmap.written(some, camera_kit.POINTS[:3]) for some in (views, one)]
    return {
        f"{CAMERA}a.usda": [usd.written(some) for some in (views, one, [camera_kit.view(8, perspective=False)])],
        f"{CAMERA}transforms.json": [json.dumps(tree).encode() for tree in (*nerf, top)],
        f"{CAMERA}dataset.json": [json.dumps(tree).encode() for tree in own],
        **{f"{CAMERA}{name}": [text[name] for text in texts] for name in COLMAP},
    }
