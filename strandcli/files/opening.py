"""How files are opened that may be pipes or devices: without waiting for who writes, where the system knows how."""

from __future__ import annotations

import os

READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
"""Flags of `os.open`; Windows has neither of the first two, and would change ends of lines without the last."""
