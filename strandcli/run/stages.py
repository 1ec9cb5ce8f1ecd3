"""The first stage of a frame: strands are moved to where they belong, in the order of the frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..constants import W
from ..errors import SimulationError, UsageError
from ..groom.blocks import arranged, lanes, pack, unpack
from ..groom.children import Children
from ..groom.combed import Combed
from ..groom.deforming import at_start
from ..groom.emit import emit
from ..groom.followers import Followers
from ..groom.record import Groom
from ..scene.detail import needed_strands, tiers_of
from ..scene.model import MeshShape, Scene
from .frame import Frame

if TYPE_CHECKING:
    from .checkpoints import Checkpoints

Notify = Callable[[str], None]
Positions = Callable[[int], NDArray[np.float32]]
STRETCH = 0.01
"""Of a strand that follows guides, from which on a frame is warned of."""


@dataclass(frozen=True)
class RunOptions:
    """What a run keeps, what it does when it goes wrong, and whom it tells."""

    draw: bool = True
    keep_positions: bool = False
    keep_going: bool = False
    """Strands that are no numbers are left out, and the run goes on."""
    notify: Notify | None = None
    """Is handed what is being done."""
    warn: Notify | None = None
    """Is handed what is hardly meant, once for all panels."""
    checkpoints: Checkpoints | None = None
    """From where the simulation goes on, and where it leaves its state."""
    heard: set[str] = field(default_factory=set)
    """What ``warn`` was handed."""

    def of_panel(self, number: int) -> RunOptions:
        """Return the options of a panel of the scene, counted from 1."""
        return replace(self, checkpoints=self.checkpoints.of_panel(number)) if self.checkpoints else self


@dataclass
class MovedStrands:
    """A frame's strands where they belong, to be drawn."""

    frame: Frame
    positions: NDArray[np.float32]
    lengths: NDArray[np.float32]
    tones: NDArray[np.float32]
    before: NDArray[np.float32] | None
    """The strands a frame earlier, where the shutter is open."""
    ids: NDArray[np.int32] | None = None
    """Of each strand its place in the order of emission, where they do not stand in it."""
    groom: Groom | None = None
    """Strands that are not those at first; else None."""


class SimulationStage:
    """The strands of a scene, moved from frame to frame."""

    def __init__(self, scene: Scene, frames: Sequence[int], given: Positions | None, options: RunOptions) -> None:
        """``given``: positions that were simulated before, by frame number."""
        from ..simulate import solver_of
        from ..simulate.advice import warnings

        draw = options.draw
        self.scene = scene
        self.options = options
        self.groom = self._at_rest(frames)
        self.children: Children | Followers | None = None
        """What is drawn in place of the strands that are simulated."""
        if draw and scene.children is not None:
            self.children = Children(scene, self.groom)
        self.combed = None
        if draw and scene.emitter.tie is not None:
            drawn = self.children.every if isinstance(self.children, Children) else self.groom
            self.combed = Combed(scene, drawn)
        self.solver = solver_of(scene)(scene, self.groom)
        if draw and scene.emitter.followers is not None:
            from ..groom_file import guided

            self.children = Followers(scene, guided(scene).following, self.solver.positions)
        self.snapshots = False
        """Whether strands move on while a frame is drawn."""
        self._given = given
        self._done = 0
        self._went_on: int | None = None
        """The frame at which the simulation last went on from what an earlier run left."""
        self._wrong = False
        self._reported: set[str] = set()
        """Errors that a line was said of."""
        self._stretch = STRETCH / 2
        """Stretch of followers that a line was said of."""
        if given is None:
            for words in warnings(scene, self.groom):
                self._warn(words)

    def _at_rest(self, frames: Sequence[int]) -> Groom:
        """The strands that some frames need, neighbours together."""
        scene = self.scene
        if scene.emitter.groom is None:
            if isinstance(scene.emitter.shape, MeshShape):
                from ..groom.on_mesh import notes

                for words in notes(scene.emitter):
                    self._warn(words)
            checkpoints = self.options.checkpoints
            needed = self.options.draw and (checkpoints is None or not checkpoints.of_all_strands)
            strands = needed_strands(scene, frames) if needed else None
            return at_start(scene, arranged(emit(scene.emitter, scene.seed, strands), tiers_of(scene)))
        from ..groom_file import from_scene, guided, notes_of

        found = from_scene(scene)
        for words in (*found.notes, *notes_of(scene, found.moments, frames)):
            self._warn(words)
        return found.groom if scene.emitter.followers is None else guided(scene).guides

    def begin(self, number: int) -> MovedStrands:
        """Move on to a frame. Raises `SimulationError` where it has gone wrong."""
        solver, draw = self.solver, self.options.draw
        given = self._given
        before = of_before = self._went_on = None
        seconds: dict[str, float | None] = {"simulate": None if given is not None else 0.0}
        # frames that are not drawn are looked at too: a run that has gone wrong stops there
        for passed in [number] if given is not None else self._to_simulate(number):
            began = time.perf_counter()
            if draw and self.scene.camera.shutter > 0 and passed == number > 1:
                self._move(number - 1)
                before, of_before = solver.positions.copy(), solver.groom
            self._move(passed)
            if given is None:
                seconds["simulate"] = (seconds["simulate"] or 0.0) + time.perf_counter() - began
            error = solver.errors(passed)
            self._examine(passed, error)
            if self.options.checkpoints is not None and given is None and not self._wrong:
                self.options.checkpoints.keep(solver, passed)
        self._done = number
        groom = solver.groom
        if groom is not self.groom:
            self._report_changing_strands()
        if of_before is not groom:
            before = None
        counts = {"strands": groom.strands, "particles": groom.strands * self.scene.emitter.particles}
        particles = solver.particles() if self.options.keep_positions else None
        frame = Frame(number, None, particles, {"frame": number, "seconds": seconds, "counts": counts, "error": error})
        if self._went_on is not None:
            frame.report["went_on_from"] = self._went_on
        if self._wrong and draw:
            return self._drop_nonfinite(frame, before)
        positions = solver.positions.copy() if self.snapshots else solver.positions
        own = None if groom is self.groom else groom
        moved = MovedStrands(frame, positions, solver.lengths, groom.tones, before, groom.places, own)
        return self._of_frame(moved) if draw else moved

    def _of_frame(self, moved: MovedStrands) -> MovedStrands:
        """The strands of the tiers that a frame is drawn from, whichever are simulated for the rest."""
        count = needed_strands(self.scene, [moved.frame.number])
        if count >= min(self.groom.strands, self.scene.emitter.strands):
            return moved
        blocks = count // W
        return replace(
            moved, positions=moved.positions[:blocks], lengths=moved.lengths[:blocks], tones=moved.tones[:count],
            before=None if moved.before is None else moved.before[:blocks],
            ids=None if moved.ids is None else moved.ids[:count],
        )  # fmt: skip

    def _report_changing_strands(self) -> None:
        """Say once that strands come and go."""
        if self.options.keep_positions and not self.options.draw:
            raise UsageError("emitter.groom.file: strands come and go with time; their positions cannot be stored")
        if "changing" not in self._reported:
            blur = ", and without motion blur" if self.scene.camera.shutter > 0 else ""
            self._warn(f"strands of the file come and go with time: each frame has those of the moment before it{blur}")
        self._reported.add("changing")

    def _to_simulate(self, number: int) -> range:
        """Return the frames to simulate up to one that is asked for, after the last that is known."""
        if self.solver.independent:
            return range(number, number + 1)
        checkpoints = self.options.checkpoints
        if checkpoints is not None and not self._wrong:
            before = 1 if self.options.draw and self.scene.camera.shutter > 0 and number > 1 else 0
            found = checkpoints.go_on(self.solver, self._done, number - before)
            if found > self._done:
                self._went_on = found
            self._done = min(found, number - 1)  # its errors are measured anew
        return range(self._done + 1, number + 1)

    def _move(self, number: int) -> None:
        """Bring the solver to a frame."""
        if self._given is None:
            self.solver.advance(number)
        else:
            self.solver.take(number, self._given(number))

    def _examine(self, number: int, error: dict[str, Any]) -> None:
        """Stop, or go on, where a frame with these errors has gone wrong."""
        from ..simulate.health import crowding, examine, interpenetration

        if self._wrong:
            return
        for about, words in (
            ("closeness", interpenetration(self.solver, number, error)),
            ("density", crowding(self.solver)),
        ):
            if words and about not in self._reported:
                self._reported.add(about)
                self._warn(words)
        trouble = examine(self.solver, number, error, simulated=self._given is None and not self.solver.independent)
        if trouble is None:
            return
        if not self.options.keep_going:
            raise SimulationError(f"{trouble.message}, or continue regardless (--keep-going)", trouble)
        self._wrong = True
        self._warn(f"{trouble.message}; going on")

    def warn_of_stretch(self, frame: Frame) -> None:
        """Warn of a frame whose followers would have changed their length by more than `STRETCH`, and again of one
        where it is twice as much."""
        found = frame.report["error"].get("follow_stretch_max") or 0.0
        if found > 2 * self._stretch:
            self._stretch = found
            self._warn(
                f"frame {frame.number}: guides would change the length of a strand that follows them by "
                f"{100 * found:.2g} %, which is put right but bends it; take more emitter.groom.guides, or more "
                "emitter.particles where strands curl"
            )

    def _warn(self, words: str) -> None:
        options, label = self.options, self.scene.label
        if options.warn is not None and words not in options.heard:
            options.heard.add(words)
            options.warn(f"{label}: {words}" if label else words)

    def _drop_nonfinite(self, frame: Frame, before: NDArray[np.float32] | None) -> MovedStrands:
        """The strands alone that can be drawn, of those that level of detail draws: so many that were emitted first."""
        from ..scene.detail import strands_needed
        from ..simulate.health import drawable

        solver, groom = self.solver, self.solver.groom
        strands = groom.strands
        own = None if groom is self.groom else groom
        guiding = self.children is not None
        seconds = (frame.number - 1) / self.scene.time.fps
        first = strands if guiding else min(strands_needed(self.scene, seconds), strands)
        fine = drawable(solver)
        fine[first:] = False
        finite = np.flatnonzero(groom.placed(fine))
        if not len(finite):
            raise SimulationError(f"frame {frame.number}: no strand is left that could be drawn; mend the preset")
        frame.report["counts"]["left_out"] = first - len(finite)
        if guiding:  # children leave out the strands that follow one that is no number
            marked = np.full((strands, solver.positions.shape[1], 3), np.nan, np.float32)
            marked[finite] = unpack(solver.positions, strands)[finite]
            return MovedStrands(frame, pack(marked), solver.lengths, groom.tones, None)
        positions = pack(unpack(solver.positions, strands)[finite])
        lengths = lanes(solver.lengths.reshape(-1)[finite, None])
        if before is not None:
            before = pack(unpack(before, strands)[finite])
            before = before if np.isfinite(before).all() else None
        ids = finite.astype(np.int32) if groom.places is None else groom.places[finite]
        return MovedStrands(frame, positions, lengths, groom.tones[finite], before, ids, own)
