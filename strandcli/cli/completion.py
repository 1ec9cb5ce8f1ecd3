"""`strandcli completion`: what a shell reads once, so that the tabulator completes commands, presets and keys."""

from __future__ import annotations

import os

import click

from . import options
from .shells import CLASSES, VARIABLE


@click.command()
@click.argument("shell", required=False, type=click.Choice(tuple(CLASSES)))
@options.debug
def command(shell: str | None) -> None:
    """Print what SHELL (bash, zsh or fish; by default yours) reads to complete commands, presets and keys of --set.

    \b
    bash:  eval "$(strandcli completion bash)"     in ~/.bashrc
    zsh:   eval "$(strandcli completion zsh)"      in ~/.zshrc, after compinit
    fish:  strandcli completion fish > ~/.config/fish/completions/strandcli.fish
    """
    name = shell or os.path.basename(os.environ.get("SHELL", ""))
    if name not in CLASSES:
        raise click.UsageError("SHELL names none of these: name bash, zsh or fish")
    group = click.get_current_context().find_root().command
    click.echo(CLASSES[name](group, {}, "strandcli", VARIABLE).source(), nl=False)
