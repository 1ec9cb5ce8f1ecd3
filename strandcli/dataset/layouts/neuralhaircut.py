"""NeuralHaircut (Sklyarova et al. 2023): pictures of one head from all sides, with NeuS's cameras.

Sources: SamsungLabs/NeuralHaircut, preprocess_custom_data/readme.md (folders), calc_orientation_maps.py,
scale_scene_into_sphere.py, colmap_parsing.py, src/models/dataset.py (`Dataset`, `MonocularDataset`).

Its folders are ``image``, ``mask`` (the whole person, hair too), ``hair_mask``, ``orientation_maps`` and
``confidence_maps``, which hold variances. `cameras.npz` has the matrices under the names of both of its loaders.
`scale.pickle` puts the scene into the unit ball, with the same margin as its script. Pictures are square.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence

from ...cameras import transforms
from ...cameras.pinhole import Pinhole
from ..layout import Cloud, PhotographLayout, Pieces

MARGIN = 1.1
"""By which NeuralHaircut's script divides the farthest point's distance: that comes to lie at 1.1."""


class NeuralHaircut(PhotographLayout):
    """Pictures, masks, orientations and NeuS's cameras."""

    name = "neuralhaircut"
    paths = (
        "image/{}.png", "hair_mask/{}.png", "mask/{}.png", "orientation_maps/{}.png", "confidence_maps/{}.npy",
    )  # fmt: skip

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """Cameras, and where the unit ball is."""
        radius = cloud.radius / MARGIN
        ball = {"scale": radius, "translation": cloud.middle.tolist()}
        return {
            "cameras.npz": [transforms.neus_written(views, cloud.middle, radius)],
            "scale.pickle": [pickle.dumps(ball, protocol=2)],
        }


DRIVER = NeuralHaircut()
