"""The option `--no-memory-check` of commands that refuse what takes too much memory."""

from __future__ import annotations

import click

option = click.option(
    "--no-memory-check", "memory_check", is_flag=True, flag_value=False, default=True,
    help="Run even if the plan needs over 80 % of free memory.",
)  # fmt: skip
