"""GaussianHaircut (Zakharov et al. 2024): pictures of one head from all sides, with COLMAP's cameras as text.

Sources: eth-ait/GaussianHaircut, run.sh, src/utils/camera_utils.py (`loadCam`), src/scene/dataset_readers.py
(`readColmapSceneInfo`), src/preprocessing/calc_orientation_maps.py, calc_masks.py, colmap_parsing.py and
preprocess_synthetic_scene.py.

Masks are 0 and 255; that of the body is of the whole person, hair too. Orientations are those of
`strandcli.dataset.layout`. Training reads ``images_2``, ``masks_2`` and ``orientations_2``, which here are links
to the folders without the number. It reads the angle of view alone and takes the principal point to be the middle of
the picture, and wants points to begin with.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...cameras import colmap
from ...cameras.pinhole import Pinhole
from ..layout import Cloud, PhotographLayout, Pieces

FOLDER = "sparse/0"


class GaussianHaircut(PhotographLayout):
    """Pictures, masks, orientations and COLMAP's text files."""

    name = "gaussianhaircut"
    centred = True
    paths = (
        "images/{}.png", "masks/hair/{}.png", "masks/body/{}.png", "orientations/angles/{}.png",
        "orientations/vars/{}.npy",
    )  # fmt: skip

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """Cameras, poses and points."""
        return {f"{FOLDER}/{name}": [data] for name, data in colmap.written(views, cloud.points).items()}

    def links(self) -> dict[str, str]:
        """Names that training looks for."""
        return {f"{folder}_2": folder for folder in ("images", "masks", "orientations")}


DRIVER = GaussianHaircut()
