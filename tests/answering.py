"""A process that answers lines of JSON by lines of JSON: a file of the tests that runs as a program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Self


class Answering:
    """The process; a context, at whose end it ends. ``env``: what it has besides this one's environment."""

    def __init__(self, file: str, env: Mapping[str, str]) -> None:
        self._file, self._env = file, os.environ | dict(env)

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            [sys.executable, self._file], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=self._env
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.communicate()

    def ask(self, question: Any) -> Any:
        """Write a line, and return what the next one says."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()
        return self.answer()

    def answer(self) -> Any:
        """Return what the next line says."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, f"{self._file} has ended: its error is above"
        return json.loads(line)
