"""What holds for a whole process of our own: whether tracebacks are shown, and when Python looks for garbage in cycles.

Imports and kernels make a million objects, and next to no garbage: to look at them all takes a tenth of a second each
time, and once more when the process ends.
"""

from __future__ import annotations

import atexit
import gc
from dataclasses import dataclass

import click

FEW_COLLECTIONS = (100_000, 20, 100)
"""Python looks a hundred times less often."""


@dataclass(slots=True)
class State:
    """What outlives the commands: whether the traceback of an unexpected error is wanted."""

    debug: bool = False


def set_debug(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    """Callback of every ``--debug``."""
    if value:
        ctx.ensure_object(State).debug = True


def seldom() -> None:
    """Look seldom from now on, and not again when the process ends."""
    gc.set_threshold(*FEW_COLLECTIONS)
    atexit.register(gc.freeze)


def put_off() -> None:
    """Do not look before `resume`."""
    if gc.get_threshold() == FEW_COLLECTIONS:
        gc.disable()


def resume() -> None:
    """Look again, but not at what is there already."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()
