"""Checkpoints: the whole state of a simulation every so many frames, from which a later run goes on to the very same
bits.

They lie in the folder ``checkpoints`` of a run's results, ``frame_0024.state`` for a scene and ``panel_2_frame_0024``
for one of its panels. What else must be the same is in a key: all of the scene that moves strands, the files that it
names, the text of every module that simulates, and the versions and instructions that machine code follows from.

The state of a simulation at frame 1, kept beside compiled kernels from one run to the next.

What a preset lets pass before its first frame takes longer than to draw that frame, and is the same in every run that
changes the picture alone: `hair` falls into place for twelve seconds. A later run begins where the first one had come
to, with the very same bits; a state is of one key (see `key_of`), and nothing else is believed of it.
"""

from __future__ import annotations

import hashlib
import json
import platform
import re
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import said
from ..jit import kept
from ..output.files import prepare_folder, remove_strays
from ..output.state_file import DamagedError, ForeignError, read_state, write_state
from .fingerprint import motion_values

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .stages import Notify

FOLDER = "checkpoints"
CODE = ("strandcli.run.stages", "strandcli.simulate.thesis.solver", "strandcli.simulate.rod", "strandcli.groom.emit")
"""Modules that simulate, with all that they import."""
KIND = "first-frame"
LEAST = 0.2
"""Seconds that it takes to come to frame 1, below which its state is not kept."""


class Checkpoints:
    """The checkpoints of a run, in the folder of its results."""

    of_all_strands = True
    """A state holds all strands, for whichever frames are asked for later."""

    def __init__(
        self, results: Path, every: int = 0, warn: Callable[[str], None] | None = None, name: str = ""
    ) -> None:
        """``every``: frames from one checkpoint to the next; 0 reads those that are there and writes none but in
        place of damaged ones. ``warn`` hears of damaged and foreign ones. ``name``: what names of files begin with."""
        self.folder = results / FOLDER
        self.every = every
        self.warn = warn
        self._name = name
        self._key: str | None = None
        self._bad: set[int] = set()
        """Frames whose checkpoint is to be made again."""
        self._told = False
        self._prepared = False

    def of_panel(self, number: int) -> Checkpoints:
        """Return those of a panel of the scene, counted from 1."""
        return Checkpoints(self.folder.parent, self.every, self.warn, f"panel_{number}_")

    def path(self, frame: int) -> Path:
        """Return the file of a frame's checkpoint."""
        return self.folder / f"{self._name}frame_{frame:04d}.state"

    def go_on(self, solver: Any, after: int, last: int) -> int:
        """Bring a solver to the latest checkpoint of the frames ``after`` + 1 to ``last``; return its frame, or
        ``after`` where there is none that fits."""
        for frame in sorted(self._frames(after, last), reverse=True):
            try:
                state = read_state(self.path(frame), self.key(solver.scene), solver.state_arrays())
                solver.check(state, frame)
                solver.restore(state)
            except FileNotFoundError:
                continue
            except ForeignError:
                self._bad.add(frame)
                self._tell_foreign()
            except (DamagedError, OSError, ValueError) as error:
                self._bad.add(frame)
                self._say(f"{self.path(frame)}: checkpoint is not used: {said(error)}; it will be made again")
            else:
                return frame
        return after

    def keep(self, solver: Any, frame: int) -> None:
        """Write a frame's checkpoint if it is to have one. Raises `RefusedError` where that cannot be."""
        due = self.every > 0 and frame % self.every == 0
        if not due and frame not in self._bad:
            return
        arrays = solver.state_arrays()
        if not arrays:
            return
        if not self._prepared:
            prepare_folder(self.folder, sum(one.nbytes for one in arrays.values()))
            self._prepared = True
        write_state(self.path(frame), self.key(solver.scene), arrays)
        self._bad.discard(frame)

    def key(self, scene: Scene) -> str:
        """Return the hash of all that a state's bits depend on."""
        if self._key is None:
            self._key = key_of(scene)
        return self._key

    def _frames(self, after: int, last: int) -> Iterable[int]:
        pattern = re.compile(re.escape(self._name) + r"frame_(\d{4,9})\.state")
        try:
            found = [pattern.fullmatch(path.name) for path in self.folder.iterdir()]
        except OSError:
            return []
        frames = {int(one[1]) for one in found if one is not None}
        return [one for one in frames if after < one <= last and one not in self._bad]

    def _tell_foreign(self) -> None:
        if not self._told:
            self._say(
                f"{self.folder}: holds checkpoints of another scene, version or machine; they are not used and will be "
                "made again"
            )
        self._told = True

    def _say(self, words: str) -> None:
        if self.warn is not None:
            self.warn(words)


class FirstFrame:
    """Stands for `Checkpoints`, and hands on to those of the run where there are any."""

    def __init__(self, checkpoints: Checkpoints | None, notify: Notify | None) -> None:
        """``notify`` hears where the state comes from."""
        self._checkpoints = checkpoints
        self._notify = notify
        self._began: float | None = None
        """When the simulation of frame 1 began, where its state is not known."""
        self.of_all_strands = checkpoints is not None and checkpoints.of_all_strands

    def of_panel(self, number: int) -> FirstFrame:
        """Return that of a panel of the scene, counted from 1."""
        return FirstFrame(self._checkpoints.of_panel(number) if self._checkpoints else None, self._notify)

    def go_on(self, solver: Any, after: int, last: int) -> int:
        """Bring a solver to the latest known state of the frames ``after`` + 1 to ``last``; return its frame, or
        ``after`` where there is none."""
        found = self._checkpoints.go_on(solver, after, last) if self._checkpoints is not None else after
        if found > 0 or last < 1 or solver.scene.time.preroll <= 0:
            return found
        arrays = solver.state_arrays()
        state = kept.find(KIND, _key(solver), arrays) if arrays else None
        try:
            if state is not None:
                solver.check(state, 1)
                solver.restore(state)
        except ValueError:  # it is made again
            state = None
        if state is None:
            self._began = time.perf_counter()
            return found
        if self._notify is not None:
            self._notify("frame 1 as an earlier run left it")
        return 1

    def keep(self, solver: Any, frame: int) -> None:
        """Keep the state of frame 1, if it took long to come to."""
        if self._checkpoints is not None:
            self._checkpoints.keep(solver, frame)
        if frame == 1 and self._began is not None and time.perf_counter() - self._began >= LEAST:
            kept.keep(KIND, _key(solver), solver.state_arrays())
        self._began = None


def of_run(results: Path, every: int | None, warn: Callable[[str], None] | None) -> Checkpoints | None:
    """Return the checkpoints of a run that writes into a folder: where they are asked for or are there already. What a
    killed run has begun is removed, though this one may have nothing left to simulate."""
    if (results / FOLDER).is_dir():
        remove_strays(results / FOLDER)
    elif every is None:
        return None
    return Checkpoints(results, every or 0, warn)


def key_of(scene: Scene) -> str:
    """Return 64 hexadecimal digits: the hash of all that the bits of a simulation's state depend on."""
    import llvmlite.binding as llvm
    import numba
    import numpy as np

    from ..jit import sources
    from ..simulate.rules import registry

    rules = sorted(
        {getattr(registry()[use.name], "__name__", type(registry()[use.name]).__module__) for use in scene.rules}
    )
    parts = [
        __version__, motion_values(scene), [sources.digest(one) for one in (*CODE, *rules)],
        platform.machine(), llvm.get_host_cpu_name(), platform.libc_ver(),
        numba.__version__, llvm.llvm_version_info, np.__version__,
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=repr).encode()).hexdigest()


def _key(solver: Any) -> str:
    return kept.key_of(KIND, (__name__,), (key_of(solver.scene), solver.groom.strands))
