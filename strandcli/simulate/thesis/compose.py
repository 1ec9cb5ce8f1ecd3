"""Generation of a fused step of exactly the rules of a scene, in its order.

The source of a module with one call for each pass is written to the cache folder and imported: Numba then compiles and
caches it as any other file, absent rules are neither run nor compiled, and rules of other packages are treated alike.
(Closures over jitted functions would be compiled again in each run, Numba #6264.)
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from ...compiling.written import module_of
from ...errors import UsageError
from ..rules import Pass

TEMPLATE = '''\
"""One solver step, written by strandcli.simulate.thesis.compose for: {title}."""

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
