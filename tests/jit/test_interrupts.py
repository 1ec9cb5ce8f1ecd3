"""A signal that comes while a kernel is loaded is raised when it is there; where a worker is waited for, at once."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable

import pytest

from strandcli.cli import signals
from strandcli.compiling.interrupts import interrupts


def interrupted(work: Callable[[list[str]], None], number: int = signal.SIGINT) -> list[str]:
    """What ``work``, in which a signal comes, had done when that was raised."""
    done: list[str] = []
    kind = signals.Terminated if number == signal.SIGTERM else KeyboardInterrupt
    with signals.handled(), pytest.raises(kind):
        work(done)
    return done


def test_it_is_raised_at_the_end_of_the_block() -> None:
    def work(done: list[str]) -> None:
        with interrupts.held():
            with interrupts.held():
                os.kill(os.getpid(), signal.SIGTERM)
                done.append("inner")
            done.append("outer")
        done.append("never")

    assert interrupted(work, signal.SIGTERM) == ["inner", "outer"]


def test_where_it_is_allowed_it_is_raised_at_once() -> None:
    def work(done: list[str]) -> None:
        with interrupts.held(), interrupts.allowed():
            os.kill(os.getpid(), signal.SIGINT)
            done.append("never")

    assert interrupted(work) == []


def test_it_is_raised_where_a_wait_begins() -> None:
    def work(done: list[str]) -> None:
        with interrupts.held():
            os.kill(os.getpid(), signal.SIGINT)
            done.append("loading")
            with interrupts.allowed():
                done.append("never")

    assert interrupted(work) == ["loading"]
