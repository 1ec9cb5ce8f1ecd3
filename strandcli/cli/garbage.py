"""When Python looks for garbage in cycles, in a process of our own.

Imports and kernels make a million objects, and next to no garbage: to look at them all takes a tenth of a second each
time, and once more when the process ends.
"""

from __future__ import annotations

import atexit
import gc

FEW_COLLECTIONS = (100_000, 20, 100)
"""Python looks a hundred times less often."""


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
