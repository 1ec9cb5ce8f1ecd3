"""HairStep (Zheng et al. 2023): strand maps and depth maps for hair from a single picture.

Sources: GAP-LAB-CUHK-SZ/HairStep, README.md (table of files), scripts/img2strand.py, scripts/img2depth.py,
scripts/recon3D.py (`load_hairstep`, `load_calib`), lib/util/opt_lmk.py; and PAULYZHENG/DiffHairStrandsRender,
hair_renderer/render_orien.py, which drew the maps that HairStep was trained with.

A strand map is red 255 where there is hair, 127 where there is body without hair, else 0. Of a direction (x right, y
down) from root to tip green is (1 + y) / 2 and blue (1 − x) / 2, of 255, the rest cut off: hair that falls straight
down is (255, 255, 127), to the viewer's left (255, 127, 255), to the right (255, 127, 0). Depth runs over the hair of a
picture from 0, the farthest, to 1, the nearest, and is 0 elsewhere.

The camera is orthographic. Its file is a pickled mapping, as HairStep's scripts want it: a point p is seen at
s · diag(1, −1, 1) · R (p − center), s = scale / ortho_ratio / 512, whose first two numbers run from −1 to 1 over the
picture, right and down, and whose third grows toward the camera. `center` is in the middle of the hair's depth.
"""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...cameras.pinhole import Pinhole
from ...output import png
from ..layout import Cloud, Labels, Layout, Pieces, mask_png, npy

ORTHO_RATIO = 0.2
"""As in all of HairStep's cameras."""
HALF_RENDERED = 512
"""Pixels: half of the size that HairStep's scripts measure cameras in."""
HAIR, BODY = 255, 127


class HairStep(Layout):
    """Files as HiSa and HiDa have them and HairStep's scripts read them."""

    name = "hairstep"
    perspective = False
    square = True
    own_light = True
    paths = (
        "img/{}.png", "seg/{}.png", "body_img/{}.png", "strand_map/{}.png", "depth_map/{}.npy", "param/{}.npy",
    )  # fmt: skip

    def encode(self, labels: Labels) -> Sequence[Pieces]:
        """Picture, mask of hair (one channel), mask of the whole body (three), strand map, depth, camera."""
        body = np.repeat(np.where(labels.body, np.uint8(255), np.uint8(0))[..., None], 3, axis=2)
        return (
            png.encode(labels.image), mask_png(labels.hair), png.encode(body), png.encode(strand_map(labels)),
            npy(depth_map(labels)), camera(labels.view, middle_depth(labels)),
        )  # fmt: skip

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """Nothing: each view stands by itself."""
        return {}


def strand_map(labels: Labels) -> NDArray[np.uint8]:
    """(height, width, 3) hair and body, and direction, as colour."""
    x, y = labels.direction[..., 0], labels.direction[..., 1]
    out = np.zeros((*labels.hair.shape, 3), np.uint8)
    out[..., 0] = np.where(labels.hair, HAIR, np.where(labels.body, BODY, 0))
    for channel, along in ((1, y), (2, -x)):
        out[..., channel] = np.where(labels.hair, 255 * np.clip(0.5 + 0.5 * along, 0, 1), 0)
    return out


def depth_map(labels: Labels) -> NDArray[np.float32]:
    """(height, width) 0 to 1, nearer is larger; 0 where there is no hair."""
    out = np.zeros(labels.hair.shape, np.float32)
    found = labels.depth[labels.hair]
    if found.size:
        near, far = float(found.min()), float(found.max())
        out[labels.hair] = (far - found) / (far - near) if far > near else 1.0
    return out


def middle_depth(labels: Labels) -> float:
    """Metres: the middle of the hair's depths; 0 where there is no hair."""
    found = labels.depth[labels.hair]
    return 0.5 * (float(found.min()) + float(found.max())) if found.size else 0.0


def camera(view: Pinhole, depth: float) -> list[bytes]:
    """The pickled mapping of an orthographic view, whose center is at a depth, metres."""
    right, down, ahead = view.rotation
    size = view.width
    off = (np.array([size / 2, size / 2]) - view.centre) / view.focal
    middle = view.eye + off[0] * right + off[1] * down + depth * ahead
    parameters = {
        "ortho_ratio": ORTHO_RATIO,
        "scale": np.array([view.focal / (size / 2) * HALF_RENDERED * ORTHO_RATIO]),
        "center": middle.reshape(3, 1),
        "R": np.stack([right, -down, -ahead]),
    }
    file = io.BytesIO()
    np.save(file, parameters, allow_pickle=True)  # type: ignore[arg-type]
    return [file.getvalue()]


DRIVER = HairStep()
