"""Kinds of files that `fuzz` damages besides strands, meshes and cameras: presets, and what strandcli has written and
reads again: positions and checkpoints."""

from __future__ import annotations

import hashlib
import shutil
import struct
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from fuzz_changes import mutated, mutated_archive, mutated_json
from fuzz_presets import attempt_preset, command, files, mutated_preset
from strandcli.cli.main import main
from strandcli.groom.emit import emit
from strandcli.output import positions, state_file
from strandcli.run.checkpoints import FOLDER, Checkpoints
from strandcli.scene import loads
from strandcli.simulate.grid import strand_grid
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry

TINY = """\
time: {frames: 3}
emitter: {strands: 6, particles: 5}
image: {size: [12, 10]}
rules: [gravity, elasticity]
"""
ROD = """\
time: {frames: 4, substeps: 2}
solver: rod
emitter: {strands: 9, particles: 5}
rules: [emitter_motion, gravity, {interaction: {}}]
"""
FEW_CELLS = 100_000


@cache
def files_of_run() -> dict[str, bytes]:
    """The files of a folder of `simulate`."""
    with tempfile.TemporaryDirectory() as place:
        preset, out = Path(place, "tiny.yaml"), Path(place, "out")
        preset.write_text(TINY)
        assert main(["simulate", str(preset), "-f", "1-2", "-o", str(out), "-q", "--threads", "1"]) == 0
        assert main([*drawn(preset, out), "-o", str(Path(place, "drawn"))]) == 0  # nothing is compiled after
        return {path.name: path.read_bytes() for path in out.glob("*.*") if path.is_file()}


def drawn(preset: Path, positions: Path) -> list[str]:
    """The command that draws them."""
    return ["render", str(preset), "--from-cache", str(positions), "-f", "1-2", "--overwrite", "--threads", "1", "-q"]


def laid(folder: Path, name: str, content: bytes) -> tuple[Path, Path]:
    """A preset, and a folder of a run of it in which one file has another content."""
    preset, out = folder / "tiny.yaml", folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    preset.write_text(TINY)
    for other, data in files_of_run().items():
        (out / other).write_bytes(content if other == name else data)
    return preset, out


def attempt_positions(content: bytes, folder: Path, name: str) -> str:
    """Read a folder in which this file is one of positions' run; some are drawn."""
    preset, out = laid(folder, name, content)
    if len(content) % 50 == 0:
        return command(*drawn(preset, out), "-o", folder / "drawn")
    frames = positions.cached_frames(out)
    read = positions.PositionCache(out, frames, 6, 5)
    found = [read(frame) for frame in frames]
    sound = all(np.isfinite(one).all() and one.shape == (6, 5, 3) for one in found)
    return "read" if sound else "positions that are none"


@cache
def rods() -> tuple[RodSolver, bytes]:
    """A solver that has state of every type, and the checkpoint of its third frame."""
    scene = loads(ROD, rules=registry(), name="rods.yaml")
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    solver.advance(3)
    with tempfile.TemporaryDirectory() as name:
        kept = Checkpoints(Path(name), 3)
        kept.keep(solver, 3)
        return solver, kept.path(3).read_bytes()


def signed(content: bytes) -> bytes:
    """The same with the hash of what it holds."""
    whole = content[: -state_file.DIGEST]
    return whole + hashlib.sha256(whole).digest()


def mutated_state(content: bytes, generator: np.random.Generator) -> bytes:
    """A checkpoint that is damaged; half of them do not tell: they hold other numbers, of which the hash is."""
    if generator.random() < 0.5:
        return mutated(content, generator)
    begin = content.index(b"\n", len(state_file.MAGIC)) + 1
    data = bytearray(content)
    odd = (np.nan, np.inf, -1.0, 0.0, 1e30, -1e30, 1e-30)
    for _ in range(generator.integers(1, 6)):
        at = int(generator.integers(begin, len(data) - state_file.DIGEST - 8))
        at -= (at - begin) % 4
        if generator.random() < 0.5:
            data[at : at + 4] = struct.pack("<f", odd[int(generator.integers(len(odd)))])
        else:
            data[at : at + 8] = struct.pack("<q", int(generator.integers(-(2**40), 2**40)))
    return signed(bytes(data))


def attempt_checkpoint(content: bytes, folder: Path) -> str:
    """Go on from it where that is done, by a step."""
    solver, whole = rods()
    told: list[str] = []
    kept = Checkpoints(folder, 3, told.append)
    (folder / FOLDER).mkdir(exist_ok=True)
    kept.path(3).write_bytes(content)
    if kept.go_on(solver, 0, 4) == 0:
        return "refused" if len(told) == 1 and told[0].isprintable() else f"{told}"
    if content not in (whole, signed(content)):
        return "a damaged one was believed"
    if content[-1] % 8 == 0:
        # numbers that nobody would have written; where strands fly apart the grid between them would grow to its most,
        # more than the little that may be taken here: with a lower one the step is refused sooner
        with np.errstate(all="ignore"), patch.object(strand_grid, "MOST_CELLS", FEW_CELLS):
            solver.step(0.2, 0.01)
    return "read"


class Kind(NamedTuple):
    """Whole files, a way to damage one, and what is done with it, in a folder."""

    files: Callable[[], list[bytes]]
    mutated: Callable[[bytes, np.random.Generator], bytes]
    attempt: Callable[[bytes, Path], str]
    """What becomes of one with this content: "read", "refused", or what is wrong."""


def kind_of_run(name: str, change: Callable[[bytes, np.random.Generator], bytes]) -> Kind:
    """One file of a folder of positions."""
    return Kind(lambda: [files_of_run()[name]], change, partial(attempt_positions, name=name))


KINDS: dict[str, Kind] = {
    "preset": Kind(files, mutated_preset, attempt_preset),
    "positions": kind_of_run("positions_0001.npz", mutated_archive),
    "manifest": kind_of_run("manifest.json", mutated_json),
    "checkpoint": Kind(lambda: [rods()[1]], mutated_state, attempt_checkpoint),
}
