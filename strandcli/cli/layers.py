"""Options of the layers that frames have beside their picture."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from ..errors import UsageError
from .complete import listed
from .options import together
from .values import Parsed, layers

if TYPE_CHECKING:
    from ..scene.model import Scene


def _names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from ..scene.model import AOVS

    return listed(AOVS, incomplete)


layer_options = together(
    click.option(
        "--aov", "aovs", type=Parsed("LAYERS", layers), metavar="LAYERS", shell_complete=_names,
        help="Also write layers as .npz and PNG: depth, mask, solid, tangent, orientation, strand_id, shadow, linear.",
    ),
    click.option("--exr", is_flag=True, help="Also write frame_0001.exr: linear light, and the layers of --aov."),
)  # fmt: skip


def with_layers(scene: Scene, exr: bool) -> Scene:
    """The scene with what EXR files hold; raises ``UsageError`` where its layers cannot be written."""
    if (exr or scene.image.aovs) and scene.panels:
        asked = "--exr" if exr else "image.aovs"
        raise UsageError(f"{asked}: a preset of several panels has no layers; draw one without panels")
    if not exr:
        return scene
    from ..output.layers import require_exr

    require_exr(scene.drawn_strands)
    if "linear" in scene.image.aovs:
        return scene
    return replace(scene, image=replace(scene.image, aovs=(*scene.image.aovs, "linear")))
