"""The state of a simulation at one frame, in memory: for a process that draws this frame again and again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..output.state_file import FREE
from .checkpoints import key_of
from .fingerprint import scene_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..groom.children import Children
    from ..scene.model import Scene


class Remembered:
    """Stands for `Checkpoints`: a frame whose motion is that of the last time is not simulated again, and children of
    the same strands are not placed again."""

    of_all_strands = False

    def __init__(self, frame: int) -> None:
        self._frame = frame
        self._panels: dict[int, Remembered] = {}
        self._scene: Scene | None = None
        self._key = ""
        self._kept: dict[int, tuple[Any, dict[str, NDArray[Any]]]] = {}
        """By frame: what it depends on, and the state."""
        self._children: tuple[Any, Children] | None = None
        """Those of the last time, with what they depend on."""

    def of_panel(self, number: int) -> Remembered:
        """Return that of a panel of the scene, counted from 1."""
        return self._panels.setdefault(number, Remembered(self._frame))

    def go_on(self, solver: Any, after: int, last: int) -> int:
        """Bring a solver to the latest state of the frames ``after`` + 1 to ``last``; return its frame, or ``after``
        where there is none that fits."""
        for frame in sorted(self._kept, reverse=True):
            of, state = self._kept[frame]
            if after < frame <= last and of == self._depends_on(solver):
                solver.restore({name: one.copy() for name, one in state.items()})
                return frame
        return after

    def keep(self, solver: Any, frame: int) -> None:
        """Remember a state if its frame is the one, or, for an open shutter, the one before."""
        if frame not in (self._frame - 1, self._frame):
            return
        if arrays := solver.state_arrays():
            self._kept[frame] = self._depends_on(solver), {name: np.array(one) for name, one in arrays.items()}

    def share(self, children: Children) -> None:
        """Hand children what the last ones have found, if that is the same."""
        values = scene_values(children.scene)
        of = [children.groom.strands, *(values[name] for name in ("emitter", "children", "seed"))]
        if self._children is not None and self._children[0] == of:
            children.adopt(self._children[1])
        self._children = of, children

    def _depends_on(self, solver: Any) -> Any:
        """What the bits of a state depend on: level of detail decides how many strands are simulated."""
        if solver.scene is not self._scene:
            self._scene, self._key = solver.scene, key_of(solver.scene)
        shapes = [(name, one.shape) for name, one in solver.state_arrays().items() if not name.startswith(FREE)]
        return self._key, solver.groom.strands, shapes
