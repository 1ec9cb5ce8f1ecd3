"""The step of rods among solids without kernels of their own: a module written for their shapes."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

from .. import runtime
from ..solids.shapes.other import module_for
from ..written import module_of
from .kernels import work_queue

TEMPLATE = '''\
"""The step of rods among solids without kernels of their own, written by strandcli.simulate.rod_others."""

from typing import Any, NamedTuple

import numpy as np

from strandcli.jit import device, function
from strandcli.simulate.kernels.rod_step import others_of, solids_of, work
from {solids} import deepest_at, distance_at, normal_at


class Others(NamedTuple):
    """Solids without kernels of their own, as `strandcli.simulate.kernels.contact_others` takes them."""

    rows: Any
    last: Any
    columns: Any


Others.distance, Others.normal, Others.deepest = distance_at, normal_at, deepest_at


@device
def all_of(kind, descriptor):
    a, b, c, d = solids_of(kind, descriptor)
    rows, last, columns = others_of(kind, descriptor)
    return a, b, c, d, Others(rows, last, columns)


@function
def single(descriptor, worker):
    work(np.float32, descriptor, worker, all_of)


@function
def double(descriptor, worker):
    work(np.float64, descriptor, worker, all_of)
'''


def code_among(others: Sequence[Any], double: bool) -> int:
    """Address of the step, compiled for a precision and the kinds of these solids."""
    module = module_among(others)
    return work_queue.address(module.double if double else module.single)


def module_among(others: Sequence[Any]) -> Any:
    """The module that holds the step among solids of these kinds, `single` and `double`."""
    return _load(TEMPLATE.format(solids=module_for(others).__name__))


@functools.cache
def _load(text: str) -> Any:
    return module_of(text, "rod", runtime.cache_folder())
