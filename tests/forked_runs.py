"""Many runs of strandcli from one process that has imported it and forks for each: a run costs its own work alone.

A fork has run no kernel and started no thread before. It loads kernels as any process does, and compiles those that are
missing in place, in the way of the processes that strandcli starts for it.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from answering import Answering

ROOT = Path(__file__).resolve().parents[1]


class Forks(Answering):
    """The process that forks, with a cache folder; a context. Kernels that are missing are compiled in each fork."""

    def __init__(self, cache: Path) -> None:
        super().__init__(
            __file__, {"PYTHONPATH": str(ROOT), "STRANDCLI_CACHE_DIR": str(cache), "STRANDCLI_COMPILERS": "0"}
        )

    def start(self, jobs: Sequence[Sequence[str]]) -> list[int]:
        """Run strandcli with each of several lists of arguments, all at once; their process numbers."""
        return list(self.ask(jobs))

    def codes(self) -> list[int]:
        """Wait for those of the last start: their exit codes, negative for the signals that ended them."""
        return list(self.answer())

    def run(self, jobs: Sequence[Sequence[str]]) -> list[int]:
        """Start and wait."""
        self.start(jobs)
        return self.codes()


def fork(arguments: list[str]) -> int:
    """The process number of a run that was started."""
    number = os.fork()
    if number:
        return number
    code = 1
    with contextlib.suppress(BaseException):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        from strandcli.cli.main import main

        code = main(arguments)
    os._exit(code)


def main() -> None:
    """Import what draws and simulates, and answer every line of the standard input."""
    import strandcli.cli.render
    import strandcli.draw.renderer
    import strandcli.run.pipeline  # noqa: F401
    from strandcli.compiling import faster

    faster.patch()
    for line in sys.stdin:
        numbers = [fork(one) for one in json.loads(line)]
        print(json.dumps(numbers), flush=True)
        print(json.dumps([os.waitstatus_to_exitcode(os.waitpid(one, 0)[1]) for one in numbers]), flush=True)


if __name__ == "__main__":
    main()
