"""Kinds of files that `fuzz` damages besides strands, meshes and cameras."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import fuzz_written as written
from fuzz_changes import mutated, mutated_archive, mutated_json, mutated_png
from fuzz_pictures import attempt_picture, pictures
from fuzz_presets import attempt_preset, files, mutated_preset


class Kind(NamedTuple):
    """Whole files, a way to damage one, and what is done with it, in a folder."""

    files: Callable[[], list[bytes]]
    mutated: Callable[[bytes, np.random.Generator], bytes]
    attempt: Callable[[bytes, Path], str]
    """What becomes of one with this content: "read", "refused", or what is wrong."""


def of_run(run: str, name: str) -> list[bytes]:
    """One file of a run."""
    return [written.files_of_run(run)[name]]


POSITIONS = "positions_0001.npz"
KINDS: dict[str, Kind] = {
    "preset": Kind(files, mutated_preset, attempt_preset),
    **{
        f"picture{end}": Kind(
            lambda end=end: pictures()[end],
            mutated_png if end == ".png" else mutated,
            partial(attempt_picture, suffix=end),
        )
        for end in (".png", ".jpg", ".hdr", ".any")
    },
    "positions": Kind(
        partial(of_run, "simulate", POSITIONS), mutated_archive, partial(written.attempt_positions, name=POSITIONS)
    ),
    "manifest": Kind(
        partial(of_run, "simulate", "manifest.json"),
        mutated_json,
        partial(written.attempt_positions, name="manifest.json"),
    ),
    "checkpoint": Kind(lambda: [written.rods()[1]], written.mutated_state, written.attempt_checkpoint),
    "study": Kind(written.studies, mutated_json, written.attempt_study),
    "report": Kind(partial(of_run, "render", "report.json"), mutated_json, written.attempt_report),
    "kernel": Kind(lambda: [written.kernel()[1]], mutated, written.attempt_kernel),
}
