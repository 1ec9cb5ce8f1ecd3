"""All that is looked at, in the order in which it is told."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import BROKEN, Finding, kernels, machine, self_test, software

CHECKS: dict[str, Callable[[], Iterator[Finding]]] = {
    "versions": software.versions, "numba": software.numba_settings, "threading": software.threading_layers,
    "processor": machine.processor, "threads": machine.threads, "memory": machine.memory, "disk": machine.disk,
    "cache": kernels.kept, "presets": software.presets,
    "bytecode": software.bytecode, "extras": software.optional, "self-test": self_test.picture,
}  # fmt: skip


def examine() -> Iterator[Finding]:
    """Findings one by one; what a check raises is one, too. Without Numba nothing is drawn."""
    drawable = True
    for name, check in CHECKS.items():
        if name == "self-test" and not drawable:
            yield Finding(name, BROKEN, "not run", "mend numba first")
            continue
        try:
            for one in check():
                drawable = drawable and not (one.check in ("numba", "versions", "threads") and one.state == BROKEN)
                yield one
        except Exception as error:  # a doctor that dies of the disease tells nothing
            yield Finding(name, BROKEN, f"{type(error).__name__}: {error}", "report it with this output")
