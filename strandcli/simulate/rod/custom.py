"""The step of rods among solids without kernels of their own: a module written for their kinds."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

from ... import runtime
from ...solids.shapes.other_code import module_for
from ...written import module_of

TEXT = '''\
"""A step of rods, written by strandcli.simulate.rod.custom."""

from typing import Any, NamedTuple

from strandcli.jit import device, function
from strandcli.simd import fused_pointer
from strandcli.simulate.rod.kernels.step import contact_of, work
from {solids} import Others, deepest, distance, drift, normal


class Custom(NamedTuple):
    """Solids without kernels of their own, as `strandcli.simulate.contact.kernels.custom` takes them."""

    all: Any
    last: Any
    columns: Any


Custom.distance, Custom.normal, Custom.deepest, Custom.drift = distance, normal, deepest, drift


@device
def custom_of(solids):
    rows = solids[4]
    return Custom(Others(fused_pointer(rows){data}), rows.size, rows.shape[1])


@function
def step(state, material, drive, step, needs, solids, scratch, queue, worker):
    work(state, material, drive, step, needs, contact_of(solids, custom_of(solids)), scratch, queue, worker)
'''


def step_among(others: Sequence[Any]) -> Any:
    """`kernels.step.run` among solids of these kinds, whose rows and data follow those of others."""
    module = module_for(others)
    data = "".join(f", solids[{5 + place}]" for place in range(len(module.Others._fields) - 1))
    return _load(TEXT.format(solids=module.__name__, data=data)).step


@functools.cache
def _load(text: str) -> Any:
    return module_of(text, "rod", runtime.cache_folder())
