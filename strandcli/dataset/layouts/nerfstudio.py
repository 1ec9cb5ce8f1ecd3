"""nerfstudio: pictures with transforms.json.

Sources: nerfstudio-project/nerfstudio, docs/quickstart/data_conventions.md,
nerfstudio/data/dataparsers/nerfstudio_dataparser.py, nerfstudio/data/utils/data_utils.py.

Cameras are OpenGL's in a world whose z is up. Depth is along the camera's axis, in thousandths of the scene's unit
(`depth_unit_scale_factor` is 1e-3 there), 0 where nothing is. Masks are white where rays are taken: ``mask_path`` is
that of the hair; one of the whole body is beside it, under a key that nerfstudio passes over.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from ... import __version__
from ...cameras import transforms
from ...cameras.pinhole import Pinhole
from ...output import png
from ..layout import Cloud, Labels, Layout, Pieces, mask_png, npy

MILLI = 1000.0
IMAGE, DEPTH, HAIR, BODY = "images/{}.png", "depths/{}.npy", "masks/hair/{}.png", "masks/body/{}.png"


class Nerfstudio(Layout):
    """Pictures, depths, masks and transforms.json."""

    name = "nerfstudio"
    paths = (IMAGE, DEPTH, HAIR, BODY)

    def encode(self, labels: Labels) -> Sequence[Pieces]:
        """Picture, depth and masks."""
        depth = np.where(np.isfinite(labels.depth), np.float32(MILLI) * labels.depth, np.float32(0))
        return png.encode(labels.image), npy(depth), mask_png(labels.hair), mask_png(labels.body)

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """Cameras, with the paths of their files."""
        beside = {"file_path": IMAGE, "depth_file_path": DEPTH, "mask_path": HAIR, "body_mask_path": BODY}
        data = transforms.written(views, beside, __version__)
        return {"transforms.json": [json.dumps(data, indent=1, allow_nan=False).encode(), b"\n"]}


DRIVER = Nerfstudio()
