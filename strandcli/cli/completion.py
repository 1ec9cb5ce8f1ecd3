"""`strandcli completion`: what a shell reads once, so that the tabulator completes commands, presets and keys; and how
bash, zsh and fish are answered."""

from __future__ import annotations

import os

import click
from click.shell_completion import (
    BashComplete,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
    split_arg_string,
)

from . import complete, options

VARIABLE = "_STRANDCLI_COMPLETE"
BASH = """\
%(complete_func)s() {
    local IFS=$'\\n' line="${COMP_LINE:0:COMP_POINT}" one kind value typed before=""
    typed="${line##*[[:space:]]}"
    # Readline takes = and : for ends of words: what stands before the last of them is there already
    if [[ $COMP_WORDBREAKS == *=* && $typed == *=* ]]; then before="${typed%%=*}="; fi
    COMPREPLY=()
    for one in $(env COMP_LINE="$line" %(complete_var)s=bash_complete "$1"); do
        kind="${one%%%%,*}"; value="${one#*,}"
        if [[ $kind == dir ]]; then compopt -o dirnames
        elif [[ $kind == file ]]; then compopt -o default
        else
            COMPREPLY+=("${value#"$before"}")
            if [[ $value == *[./=] ]]; then compopt -o nospace; fi
        fi
    done
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""
ZSH = """\
#compdef %(prog_name)s
%(complete_func)s() {
    local -a plain described parts response
    local kind key note
    (( ! $+commands[%(prog_name)s] )) && return 1
    response=("${(@f)$(env COMP_WORDS="${words[*]}" COMP_CWORD=$((CURRENT-1)) %(complete_var)s=zsh_complete \
%(prog_name)s)}")
    for kind key note in ${response}; do
        if [[ $kind == dir ]]; then _path_files -/
        elif [[ $kind == file ]]; then _path_files -f
        elif [[ $key == *[./=] ]]; then parts+=("$key")
        elif [[ $note == _ ]]; then plain+=("$key")
        else described+=("$key:$note")
        fi
    done
    [[ -n $described ]] && _describe -V unsorted described -U
    [[ -n $plain ]] && compadd -U -V unsorted -a plain
    [[ -n $parts ]] && compadd -S '' -U -V unsorted -a parts
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then %(complete_func)s "$@"
else compdef %(complete_func)s %(prog_name)s
fi
"""


class Remembering(ShellComplete):
    """Tells `complete` which words stand before the one that is completed."""

    def get_completion_args(self) -> tuple[list[str], str]:
        complete.typed[:], incomplete = super().get_completion_args()
        return list(complete.typed), incomplete


class Bash(Remembering, BashComplete):
    """Takes the line as it is typed: Bash's own list of words is cut at = and at :."""

    source_template = BASH

    @staticmethod
    def _check_version() -> None:
        """The script works with Bash 4.4 and newer, which any system of today has; click would start one to ask."""

    def get_completion_args(self) -> tuple[list[str], str]:
        line = os.environ["COMP_LINE"]
        complete.typed[:] = split_arg_string(line)[1:]
        incomplete = complete.typed.pop() if complete.typed and not line[-1:].isspace() else ""
        return list(complete.typed), incomplete


class Zsh(Remembering, ZshComplete):
    """Adds no space after a part of a key."""

    source_template = ZSH


class Fish(Remembering, FishComplete):
    """As click has it."""


CLASSES: dict[str, type[ShellComplete]] = {"bash": Bash, "zsh": Zsh, "fish": Fish}


def register() -> None:
    """Have click answer shells by these classes."""
    for name, one in CLASSES.items():
        add_completion_class(one, name)


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
