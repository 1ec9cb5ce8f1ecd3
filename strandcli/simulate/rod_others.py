"""The step of rods among solids of other packages: a module written for their distance, compiled as any other."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

from .. import runtime
from ..solids.shapes.other import module_for
from ..written import module_of
from .kernels import work_queue

TEMPLATE = '''\
"""The step of rods among solids of other packages, written by strandcli.simulate.rod_others."""

import numpy as np

from strandcli.jit import device, function
from strandcli.simulate.kernels.rod_step import others_of, solids_of, work
from {solids} import distance_at


@device
def all_of(kind, descriptor):
    a, b, c, d = solids_of(kind, descriptor)
    return a, b, c, d, others_of(kind, descriptor), distance_at


@function
def single(descriptor, worker):
    work(np.float32, descriptor, worker, all_of)


@function
def double(descriptor, worker):
    work(np.float64, descriptor, worker, all_of)
'''


def code_among(others: Sequence[Any], double: bool) -> int:
    """Address of the step, compiled for a precision and the kinds of these solids."""
    module = _load(TEMPLATE.format(solids=module_for(others).__name__))
    return work_queue.address(module.double if double else module.single)


@functools.cache
def _load(text: str) -> Any:
    return module_of(text, "rod", runtime.cache_folder())
