"""Steps of rods among solids without kernels of their own: modules written for them."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from .. import runtime
from ..solids.shapes.other_code import module_for
from ..written import module_of

HEAD = '''\
"""A step of rods, written by strandcli.simulate.rod_others."""

from typing import Any, NamedTuple

import numpy as np

from strandcli.jit import device, function
from strandcli.simd import array_at
from strandcli.simulate.kernels.rod_descriptor import DATA, others_of, solids_of
from strandcli.simulate.kernels.rod_step import work
'''

AMONG = '''\
from {solids} import Others, deepest, distance, drift, normal


class Met(NamedTuple):
    """Solids without kernels of their own, as `strandcli.simulate.kernels.contact_others` takes them."""

    all: Any
    last: Any
    columns: Any


Met.distance, Met.normal, Met.deepest, Met.drift = distance, normal, deepest, drift


@device
def all_of(kind, descriptor):
    a, b, c, d = solids_of(kind, descriptor)
    rows, last, columns = others_of(kind, descriptor)
    return a, b, c, d, Met(Others(rows{data}), last, columns)
'''

STEP = """\


@function
def step(descriptor, worker):
    work(np.{kind}, descriptor, worker, all_of, {crowded})
"""


def module_among(others: Sequence[Any], data: Sequence[NDArray[Any]], kind: str, crowded: bool) -> Any:
    """The module whose ``step`` is that among solids of these kinds with such arrays, as those of
    `strandcli.simulate.kernels.rod_step`: of a floating type; ``crowded``: as in `Flags`."""
    arrays, place = "", 0
    for one in data:
        shape = "".join(f"descriptor[DATA + {place + 1 + axis}], " for axis in range(one.ndim))
        arrays += f", array_at(np.{one.dtype}, descriptor[DATA + {place}], ({shape}))"
        place += 1 + one.ndim
    among = AMONG.format(solids=module_for(others).__name__, data=arrays)
    return _load(HEAD + among + STEP.format(kind=kind, crowded=True if crowded else None))


@functools.cache
def _load(text: str) -> Any:
    return module_of(text, "rod", runtime.cache_folder())
