"""Where compiling takes its time: processor seconds of each kernel, by what Numba tells its listeners."""

from __future__ import annotations

import inspect
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from numba.core import event

from ..compiling.folder import cache
from ..compiling.service import service
from .dispatcher import KernelDispatcher

KINDS = ("numba:compile", "numba:run_pass", "numba:llvm_lock")


@dataclass(slots=True)
class KernelCost:
    """Processor seconds of a kernel, without those of kernels that it calls; ``functions``: that were typed and lowered
    for it, the first kernel that calls them; LLVM's ``instructions`` and ``bytes`` of machine code at last; how often
    it was ``compiled``, for which differences between arguments (``why``)."""

    name: str
    typing: float = 0.0
    lowering: float = 0.0
    llvm: float = 0.0
    functions: int = 0
    instructions: int = 0
    bytes: int = 0
    compiled: int = 0
    why: list[str] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        return self.typing + self.lowering + self.llvm

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "seconds": self.seconds}


class Profile(event.Listener):
    """Adds up what is compiled while it listens."""

    def __init__(self) -> None:
        self._costs: dict[KernelDispatcher, KernelCost] = {}
        self._stack: list[tuple[KernelCost, str]] = []
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

    def costs(self) -> list[KernelCost]:
        """Of each kernel, the dearest first."""
        for kernel, cost in self._costs.items():
            cost.compiled, cost.why = len(kernel.signatures), _why(kernel)
            libraries: list[Any] = [one.library for one in kernel.overloads.values()]  # type: ignore[attr-defined]
            text = "\n".join(one.get_llvm_str() for one in libraries)
            cost.instructions = text.count("\n  ")
            cost.bytes = sum(len(one._get_compiled_object()) for one in libraries)
        return sorted(self._costs.values(), key=lambda one: -one.seconds)

    def _begin(self, dispatcher: Any) -> None:
        if isinstance(dispatcher, KernelDispatcher):
            name = f"{dispatcher.py_func.__module__.removeprefix('strandcli.')}.{dispatcher.py_func.__name__}"
            cost = self._costs.setdefault(dispatcher, KernelCost(name))
        elif self._stack:
            cost = self._stack[-1][0]
        else:  # somebody else's
            cost = KernelCost("")
        cost.functions += 1
        self._stack.append((cost, "typing"))

    def _count_time(self) -> None:
        now = time.thread_time()
        if self._stack:
            cost, kind = self._stack[-1]
            setattr(cost, kind, getattr(cost, kind) + now - self._since)
        self._since = now


@contextmanager
def profiled() -> Iterator[Profile]:
    """A block in which every kernel is compiled anew, in this process, and kept nowhere."""
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
    first, *others = kernel.signatures or [()]
    return [
        ", ".join(f"{name}: {a}, not {b}" for name, a, b in zip(names, other, first, strict=False) if a != b)
        for other in others
    ]
