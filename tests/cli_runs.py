"""How tests call the command line: in this process for speed, in one of its own where signals or imports matter."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from strandcli.cli.main import main
from strandcli.cli.progress import COMPILING

ROOT = Path(__file__).resolve().parent.parent

TINY = """\
title: a few strands for tests
time: {frames: 12}
emitter: {strands: 150, particles: 5, length: 0.6}
image: {size: [64, 48]}
rules:
  - gravity: {}
  - wind: {strength: 2}
  - elasticity: {}
"""


class Result:
    """The exit code and what was printed."""

    def __init__(self, code: int, out: str, err: str) -> None:
        self.code, self.out, self.err = code, out, err

    def error(self) -> str:
        """The single line of an error; fails where there are more or none."""
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert "Traceback" not in self.err
        return lines[0]


class Runner:
    """Calls the command in a folder of its own, which holds tiny.yaml."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self.capsys = folder, capsys

    def __call__(self, *arguments: object) -> Result:
        self.capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        out, err = self.capsys.readouterr()
        return Result(code, out, told(err))

    def fine(self, *arguments: object) -> Result:
        """Call it; fails where it does not end well."""
        result = self(*arguments)
        assert result.code == 0, result.err
        return result

    def refused(self, *arguments: object, code: int = 2) -> str:
        """The single line of an error with which a call ends; fails where it ends with another code."""
        result = self(*arguments)
        assert result.code == code, result.err
        return result.error()


def report(folder: str) -> dict[str, Any]:
    """The report of a run in a folder."""
    data = json.loads(Path(folder, "report.json").read_text())
    assert isinstance(data, dict)
    return data


def told(err: str) -> str:
    """What was told on stderr, whether or not this process had kernels to compile first, which is a line of its own."""
    return "".join(line for line in err.splitlines(keepends=True) if COMPILING not in line)


def environment() -> dict[str, str]:
    """The environment of a child that finds this checkout."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}


def listen() -> None:
    """In a child: a closed terminal is told to it, though tests be run under nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def child(folder: Path, *arguments: object, **settings: Any) -> subprocess.Popen[str]:
    """The command in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "strandcli", *map(str, arguments)],
        cwd=folder,
        env=environment(),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=listen,
        **settings,
    )
