"""The option `--checkpoint` of commands that simulate."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import Whole

if TYPE_CHECKING:
    from ..run.checkpoints import Checkpoints

option = click.option(
    "--checkpoint", type=Whole(1), metavar="N",
    help="Save the simulation's state every N frames in DIR/checkpoints, for later runs to start from.",
)  # fmt: skip


def of_run(folder: Path, every: int | None, warn: Callable[[str], None]) -> Checkpoints | None:
    """The checkpoints of a run that writes into a folder, None where there are none and none are asked for."""
    from ..run import checkpoints

    return checkpoints.of_run(folder, every, warn)
