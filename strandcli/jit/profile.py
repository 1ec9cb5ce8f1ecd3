"""Where compiling takes its time: processor seconds of each kernel, by what Numba tells its listeners."""

from __future__ import annotations

import inspect
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba.core import event

from ..compiling.folder import cache
from ..compiling.service import service
from .dispatcher import KernelDispatcher

KINDS = ("numba:compile", "numba:run_pass", "numba:llvm_lock")


class Profile(event.Listener):
    """Adds up what is compiled while it listens."""

    def __init__(self) -> None:
        self._costs: dict[KernelDispatcher, Counter[str]] = {}
        self._stack: list[tuple[Counter[str], str]] = []
        """The kernel that is compiled, and what with, from the outermost one to the one that takes time now."""
        self._since = 0.0

    def on_start(self, event: Any) -> None:
        self._count_time()
        if event.kind == "numba:compile":
            self._begin(event.data["dispatcher"])
        elif self._stack:
            kind = "llvm" if event.kind == "numba:llvm_lock" else _kind(event.data["name"])
            self._stack.append((self._stack[-1][0], kind))

    def on_end(self, event: Any) -> None:
        self._count_time()
        if self._stack:
            self._stack.pop()

    def costs(self) -> list[dict[str, Any]]:
        """A row a kernel, the dearest first: processor seconds without those of kernels that it calls; ``functions``
        that were typed and lowered for it, the first kernel that calls them; LLVM's ``instructions`` and ``bytes`` of
        machine code at last; how often it was ``compiled``, and for which differences between arguments (``why``)."""
        rows = []
        for kernel, cost in self._costs.items():
            libraries: list[Any] = [one.library for one in kernel.overloads.values()]  # type: ignore[attr-defined]
            rows.append({
                "name": f"{kernel.py_func.__module__.removeprefix('strandcli.')}.{kernel.py_func.__name__}",
                "seconds": cost["typing"] + cost["lowering"] + cost["llvm"],
                **{name: cost[name] for name in ("typing", "lowering", "llvm", "functions")},
                "instructions": sum(one.get_llvm_str().count("\n  ") for one in libraries),
                "bytes": sum(len(one._get_compiled_object()) for one in libraries),
                "compiled": len(libraries), "why": _why(kernel),
            })  # fmt: skip
        return sorted(rows, key=lambda row: -row["seconds"])

    def _begin(self, dispatcher: Any) -> None:
        cost = self._stack[-1][0] if self._stack else Counter[str]()
        if isinstance(dispatcher, KernelDispatcher):
            cost = self._costs.setdefault(dispatcher, Counter())
        cost["functions"] += 1
        self._stack.append((cost, "typing"))

    def _count_time(self) -> None:
        now = time.thread_time()
        if self._stack:
            cost, kind = self._stack[-1]
            cost[kind] += now - self._since  # type: ignore[assignment]
        self._since = now


@contextmanager
def profiled() -> Iterator[Profile]:
    """A block in which every kernel is compiled anew, in this process, and stored nowhere."""
    found, enabled, before = Profile(), service.enabled, (cache.path, [str(one.path) for one in cache.read_only])
    for kind in KINDS:
        event.register(kind, found)
    service.enabled = False
    try:
        with tempfile.TemporaryDirectory(prefix="strandcli-") as place:
            cache.use(Path(place))
            yield found
    finally:
        cache.use(*before)
        service.enabled = enabled
        for kind in KINDS:
            event.unregister(kind, found)


def _kind(name: str) -> str:
    return "lowering" if "lowering" in name.partition(" ")[0] else "typing"


def _why(kernel: KernelDispatcher) -> list[str]:
    """How the types of each further signature differ from the first one's."""
    names = list(inspect.signature(kernel.py_func).parameters)
    first, *rest = kernel.signatures or [()]
    return [
        ", ".join(f"{name}: {a}, not {b}" for name, a, b in zip(names, other, first, strict=False) if a != b)
        for other in rest
    ]
