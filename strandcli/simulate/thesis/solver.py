"""The source's solver: the rules in the preset's order, once a step (thesis §2), fused into one loop.

The source of a module with one call for each pass is written to the cache folder and imported: Numba then compiles and
caches it as any other file, and absent rules are neither run nor compiled. The solver has no velocity, so nothing has
inertia; a rule's strength depends on the step; the shape depends on the number of particles. These flaws of the source
stay, so that they can be seen and measured.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ... import solids
from ...compiling import runtime
from ...compiling.folder import module_of
from ...errors import UsageError
from ...groom.blocks import lanes
from ...groom.record import Groom
from ..rules import Moment, Pass, passes_of
from ..solver import Solver

if TYPE_CHECKING:
    from ...scene.model import Scene

TEMPLATE = '''\
"""One solver step, written by strandcli.simulate.thesis.solver for: {title}."""

from strandcli.constants import W
from strandcli.jit import function, parallel, prange

{imports}
{loops}
@parallel
def step(positions, lengths, rest{arguments}):
    """Move every strand by one step, in place.

    positions (blocks, n + 1, 3 W) float32, metres: row 0 is one segment before the root, row 1 the root;
    lengths (blocks, W) segment rest lengths; rest (blocks, 2, 3 W): rows 0 and 1 in the emitter's own frame;
    then one float32 array for each pass.
    """
    for b in prange(positions.shape[0]):
        block = positions[b]
        length = lengths[b]
        n = block.shape[0] - 1
        root = block[1]
{roots}        for i in range(1, n):
            x = block[i + 1]
            parent = block[i]
            grandparent = block[i - 1]
{particles}'''

LOOP = """
@function
def lanes_{number}(x, parent, grandparent, length, i{arguments}):
    # numbers, not arrays: nothing that the loop writes can be one of them
{numbers}    for k in range(W):
        a = (x[k], x[W + k], x[2 * W + k])
        b = (parent[k], parent[W + k], parent[2 * W + k])
        c = (grandparent[k], grandparent[W + k], grandparent[2 * W + k])
{calls}        x[k], x[W + k], x[2 * W + k] = a

"""


def source(passes: Sequence[Pass]) -> str:
    """Return the source of the module that runs these passes; equal scenes have equal text.

    Raises `UsageError` for a function that an import statement cannot reach (a method, a closure, a lambda).
    """
    imports: list[str] = []
    loops: list[str] = []
    roots: list[str] = []
    particles: list[str] = []
    lanes: list[tuple[int, Pass]] = []  # neighbours that become one loop

    def close() -> None:
        if lanes:
            arguments = "".join(f", p_{j}" for j, _ in lanes)
            particles.append(f"            lanes_{len(loops)}(x, parent, grandparent, length, i{arguments})\n")
            loops.append(_loop(len(loops), lanes, arguments))
            lanes.clear()

    compiled: dict[Callable[..., None], int] = {}
    for j, one in enumerate(passes):
        function = one.function
        where, what = function.__module__, function.__qualname__
        if where not in sys.modules or getattr(sys.modules[where], what, None) is not function:
            raise UsageError(f"rule function {where}.{what}: must be a plain function of a module that can be imported")
        digest = hashlib.sha256(inspect.getsource(sys.modules[where]).encode()).hexdigest()[:12]
        if function in compiled:
            imports.append(f"pass_{j} = pass_{compiled[function]}\n")
        else:
            imports.append(
                f"from {where} import {what} as function_{j}  # {digest}\npass_{j} = function(function_{j})\n"
            )
        compiled.setdefault(function, j)
        if one.stage == "lane":
            lanes.append((j, one))
        elif one.stage == "root":
            roots.append(f"        pass_{j}(block[0], root, rest[b, 0], rest[b, 1], p_{j})\n")
        else:
            close()
            particles.append(f"            pass_{j}(x, parent, grandparent, root, length, p_{j}, i, n)\n")
    close()
    return TEMPLATE.format(
        title=", ".join(f"{one.function.__module__.rpartition('.')[2]}.{one.function.__name__}" for one in passes),
        imports="".join(imports),
        loops="".join(loops),
        arguments="".join(f", p_{j}" for j in range(len(passes))),
        roots="".join(roots),
        particles="".join(particles) or "            pass\n",
    )


def _loop(number: int, lanes: Sequence[tuple[int, Pass]], arguments: str) -> str:
    """Return the source of one loop over the lanes for consecutive lane passes."""
    numbers, calls = [], []
    for j, one in lanes:
        row = "i, " if one.per_particle else ""
        read = "".join(f"p_{j}[{row}{k}], " for k in range(one.numbers))
        numbers.append(f"    q_{j} = ({read})\n")
        calls.append(f"        a = pass_{j}(a, b, c, length[k], q_{j})\n")
    return LOOP.format(number=number, arguments=arguments, numbers="".join(numbers), calls="".join(calls))


def step_for(passes: Sequence[Pass], folder: Path) -> Callable[..., None]:
    """Return the compiled step of these passes; its module is written to ``folder`` unless it exists."""
    return _load(source(passes), folder)


@functools.lru_cache(maxsize=64)
def _load(text: str, folder: Path) -> Callable[..., None]:
    step: Callable[..., None] = module_of(text, "step", folder).step
    return step


GOLDEN = (math.sqrt(5) - 1) / 2
"""Whose multiples are spread evenly over 0 to 1, modulo 1."""


class ThesisSolver(Solver):
    """Strands that the rules of a scene move, fused into one step."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        super().__init__(scene, groom)
        self.passes = [one for _, one in passes_of(scene)]
        self._step = step_for(tuple(self.passes), runtime.cache_folder()) if self.passes else None
        self._distinct = list({id(one): one for one in self.passes}.values())
        places = {id(one): place for place, one in enumerate(self._distinct)}
        self._places = [places[id(one)] for one in self.passes]
        self._steady = not (any(one.state for one in self._distinct) or solids.custom_of(scene.solids))
        """Whether the numbers of all passes follow from the moment alone, and are few."""
        self._known: dict[tuple[float, float], list[Any]] = {}

    def announce(self, ends: Sequence[float], dt: float) -> None:
        """As for any solver."""
        if self._steady:
            self._known = {(time, dt): self._prepared(time, dt, copied=True) for time in ends}

    def step(self, time: float, dt: float) -> None:
        """Simulate a step of ``dt`` seconds that ends at ``time``."""
        if self._step is not None and dt > 0:
            self._deform(time)
            prepared = self._known.get((time, dt)) or self._prepared(time, dt)
            self._step(self.positions, self.lengths, self.rest, *prepared)

    def _prepared(self, time: float, dt: float, copied: bool = False) -> list[Any]:
        """Return the numbers of all passes for a step of ``dt`` seconds that ends at ``time``; ``copied``: a rule may
        write over its own at the next moment."""
        moment = Moment(time, dt * self._stretched(time, dt), self.scene)
        prepared = [one.prepare(moment) for one in self._distinct]
        if copied:
            prepared = [one.copy() if isinstance(one, np.ndarray) else one for one in prepared]
        return [prepared[place] for place in self._places]

    def _stretched(self, time: float, dt: float) -> float:
        """Return how many times as long as the mean the step that ends at ``time`` is, by ``time.jitter``: evenly
        spread over 1 - jitter to 1 + jitter, whatever the seed."""
        jitter = self.scene.time.jitter
        return 1 + jitter * (2 * (round(time / dt) * GOLDEN % 1) - 1) if jitter > 0 else 1.0

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the positions, and what rules keep from step to step."""
        state = {f"pass {i}, {j}": one for i, p in enumerate(self._distinct) for j, one in enumerate(p.state)}
        return {**super().state_arrays(), **state}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        super().restore(state)
        for i, one in enumerate(self._distinct):
            for j, array in enumerate(one.state):
                array[...] = state[f"pass {i}, {j}"]

    def place_roots(self, frame: int) -> None:
        """Set the roots by the rules that move them, as `advance` does."""
        roots = [one for one in self.passes if one.stage == "root"]
        if roots and (frame > 1 or self.scene.time.preroll > 0):
            time = self.scene.time
            moment = Moment((frame - 1) / time.fps, 1.0 / (time.fps * time.substeps), self.scene)
            self._deform((frame - 1) / time.fps)
            step = step_for(tuple(roots), runtime.cache_folder())
            step(self.positions, self.lengths, self.rest, *[one.prepare(moment) for one in roots])

    def _deform(self, time: float) -> None:
        """Set the roots in the emitter's frame where they move there."""
        if self.deforming is None:
            return
        roots, directions = self.deforming.at(time)
        lengths = self.lengths.reshape(-1)[: self.strands, None]
        self.rest[:, 0] = lanes(roots - lengths * directions)
        self.rest[:, 1] = lanes(roots)
