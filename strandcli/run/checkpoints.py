"""States of a simulation, from which a later run goes on to the very same bits: checkpoints every so many frames, and
that of frame 1.

Checkpoints lie in the folder ``checkpoints`` of a run's results, ``frame_0024.state`` for a scene and
``panel_2_frame_0024`` for one of its panels. What a preset lets pass before frame 1 takes longer than to draw that
frame, and is the same in every run that changes the picture alone (`hair` falls into place for twelve seconds): its
state is cached beside compiled kernels. Each state is of one key, the hash of all of the scene that moves strands, the
files that it names, the text of every module that simulates, and the versions and instructions that machine code
follows from.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import said
from ..jit import array_cache
from ..output.files import prepare_folder, remove_strays
from ..output.state_file import DamagedError, ForeignError, read_state, write_state
from .fingerprint import motion_values

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .stages import Notify

FOLDER = "checkpoints"
CODE = ("strandcli.run.stages", "strandcli.simulate.thesis.solver", "strandcli.simulate.rod", "strandcli.groom.emit")
"""Modules that simulate, with all that they import."""
LEAST = 0.2
"""Seconds that it takes to come to frame 1, below which its state is not cached."""


class Checkpoints:
    """The states that a run goes on from, and those that it leaves."""

    def __init__(
        self, results: Path | None, every: int = 0, warn: Notify | None = None, notify: Notify | None = None,
        name: str = "",
    ) -> None:  # fmt: skip
        """``results``: the run's folder; None for the state of frame 1 alone. ``every``: frames from one checkpoint to
        the next; 0 reads those that are there and writes none but in place of damaged ones. ``warn`` hears of damaged
        and foreign ones, ``notify`` where frame 1 comes from. ``name``: what names of files begin with."""
        self.folder = None if results is None else results / FOLDER
        self.every = every
        self._warn = warn or (lambda words: None)
        self._notify = notify or (lambda words: None)
        self._name = name
        self._key: str | None = None
        self._bad: set[int] = set()
        """Frames whose checkpoint is to be made again."""
        self._warned = self._prepared = False
        self._began: float | None = None
        """When the simulation of frame 1 began, where its state is not known."""

    @property
    def of_all_strands(self) -> bool:
        """Whether a state holds all strands, for whichever frames are asked for later."""
        return self.folder is not None

    def of_panel(self, number: int) -> Checkpoints:
        """Return those of a panel of the scene, counted from 1."""
        results = None if self.folder is None else self.folder.parent
        return Checkpoints(results, self.every, self._warn, self._notify, f"panel_{number}_")

    def path(self, frame: int) -> Path:
        """Return the file of a frame's checkpoint."""
        assert self.folder is not None
        return self.folder / f"{self._name}frame_{frame:04d}.state"

    def go_on(self, solver: Any, after: int, last: int) -> int:
        """Bring a solver to the latest state of the frames ``after`` + 1 to ``last``; return its frame, or ``after``
        where there is none that fits."""
        for frame in sorted(self._frames(after, last), reverse=True):
            try:
                _restore(solver, read_state(self.path(frame), self.key(solver.scene), solver.state_arrays()), frame)
            except FileNotFoundError:
                continue
            except ForeignError:
                self._bad.add(frame)
                self._warn_of_foreign()
            except (DamagedError, OSError, ValueError) as error:
                self._bad.add(frame)
                self._warn(f"{self.path(frame)}: checkpoint is not used: {said(error)}; it will be made again")
            else:
                return frame
        return 1 if after < 1 <= last and self._begin_at_first(solver) else after

    def keep(self, solver: Any, frame: int) -> None:
        """Write a frame's checkpoint if it is to have one, and cache the state of frame 1 if it took long to come to.
        Raises `RefusedError` where a checkpoint cannot be written."""
        began, self._began = self._began, None
        if frame == 1 and began is not None and time.perf_counter() - began >= LEAST:
            array_cache.keep(array_cache.STATES, self._first_key(solver), solver.state_arrays())
        due = self.every > 0 and frame % self.every == 0
        arrays = solver.state_arrays() if self.folder is not None and (due or frame in self._bad) else {}
        if not arrays:
            return
        if not self._prepared:
            prepare_folder(self.path(frame).parent, sum(one.nbytes for one in arrays.values()))
            self._prepared = True
        write_state(self.path(frame), self.key(solver.scene), arrays)
        self._bad.discard(frame)

    def key(self, scene: Scene) -> str:
        """Return the hash of all that a state's bits depend on."""
        if self._key is None:
            self._key = key_of(scene)
        return self._key

    def _begin_at_first(self, solver: Any) -> bool:
        """Bring a solver to the cached state of frame 1, where there is one."""
        if solver.scene.time.preroll <= 0:
            return False
        arrays = solver.state_arrays()
        state = array_cache.find(array_cache.STATES, self._first_key(solver), arrays) if arrays else None
        try:
            if state is not None:
                _restore(solver, state, 1)
        except ValueError:  # it is made again
            state = None
        if state is None:
            self._began = time.perf_counter()
        else:
            self._notify("frame 1 as an earlier run left it")
        return state is not None

    def _first_key(self, solver: Any) -> str:
        return array_cache.key_of(array_cache.STATES, (__name__,), (self.key(solver.scene), solver.groom.strands))

    def _frames(self, after: int, last: int) -> Iterable[int]:
        pattern = re.compile(re.escape(self._name) + r"frame_(\d{4,9})\.state")
        try:
            found = [] if self.folder is None else [pattern.fullmatch(path.name) for path in self.folder.iterdir()]
        except OSError:
            return []
        frames = {int(one[1]) for one in found if one is not None}
        return [one for one in frames if after < one <= last and one not in self._bad]

    def _warn_of_foreign(self) -> None:
        if not self._warned:
            self._warn(
                f"{self.folder}: holds checkpoints of another scene, version or machine; they are not used and will be "
                "made again"
            )
        self._warned = True


def _restore(solver: Any, state: Any, frame: int) -> None:
    solver.check(state, frame)
    solver.restore(state)


def of_run(
    results: Path, every: int | None, warn: Callable[[str], None] | None, notify: Notify | None = None
) -> Checkpoints:
    """Return the states of a run that writes into a folder; checkpoints where they are asked for or are there already.
    What a killed run has begun is removed, though this one may have nothing left to simulate."""
    there = (results / FOLDER).is_dir()
    if there:
        remove_strays(results / FOLDER)
    return Checkpoints(results if there or every is not None else None, every or 0, warn, notify)


def key_of(scene: Scene) -> str:
    """Return 64 hexadecimal digits: the hash of all that the bits of a simulation's state depend on."""
    from ..simulate.rules import registry

    rules = {getattr(registry()[use.name], "__name__", type(registry()[use.name]).__module__) for use in scene.rules}
    return array_cache.key_of(FOLDER, (*CODE, *sorted(rules)), (__version__, motion_values(scene)))
