"""`strandcli completion`: what a shell reads once, so that the tabulator completes commands, presets and keys; how
bash, zsh and fish are answered; and what is offered for the word that is being typed.

Imports neither numpy nor numba: a shell waits for it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
    split_arg_string,
)  # fmt: skip

if TYPE_CHECKING:
    from ..scene.fields import Setting
    from ..scene.model import Scene


def presets(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped presets; and files, which the shell completes."""
    return [*shipped(ctx, param, incomplete), CompletionItem(incomplete, type="file")]


def shipped(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Shipped presets."""
    from ..scene.library import describe, list_presets

    return [CompletionItem(name, help=describe(path)) for name, path in list_presets() if name.startswith(incomplete)]


def clusters(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """What stands for a Dask cluster: workers of this machine, or how schedulers' addresses begin."""
    known = {"local": "workers of this machine, for this run", "tcp://": "a scheduler's address"}
    return [CompletionItem(word, help=words) for word, words in known.items() if word.startswith(incomplete)]


def keys(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Dotted paths of settings, a part at a time, and after = the values of those that have few."""
    path, given, value = incomplete.partition("=")
    head, dot, begin = path.rpartition(".")
    found = dict(_inside(_scene(ctx), head.split(".") if head else []))
    if not given:
        return [CompletionItem(f"{head}{dot}{key}", help=words) for key, (words, _) in found.items()
                if key.startswith(begin)]  # fmt: skip
    values = found.get(f"{begin}=", ("", ()))[1]
    return [CompletionItem(f"{path}={one}") for one in values if one.startswith(value)]


def _scene(ctx: click.Context) -> Scene:
    """The preset that the command line names; one of defaults with all rules where there is none that can be read."""
    import strandcli

    from ..scene import RuleUse
    from ..scene.model import Scene
    from ..simulate.rules import registry

    for word in (ctx.params.get("preset"), *ctx.args):  # click parses no arguments where an option lacks its value
        if word and not word.startswith("-") and "=" not in word:
            try:
                return strandcli.load(word)
            except Exception:  # a shell's completion is silent; it may be the value of an option
                continue
    return Scene(rules=tuple(RuleUse(name, rule.Parameters(), name) for name, rule in registry().items()))


def _inside(scene: Scene, parts: list[str]) -> Iterator[tuple[str, tuple[str, tuple[str, ...]]]]:
    """What may follow a path, with `.` or `=` at its end: what each means, and its values where they are few."""
    from ..scene.fields import made, settings_of
    from ..scene.rule_type import first_paragraph

    rules = {use.path: use.parameters for use in scene.rules}
    node: Any = scene
    for depth, part in enumerate(parts):
        if isinstance(node, tuple):
            named = [one for one in node if getattr(one, "name", None) == part]
            node = next(iter(named or node[int(part) :][:1] if part.isdecimal() or named else ()), None)
        elif depth == 0 and part in rules:
            node = rules[part]
        else:
            node = getattr(node, part, None) or (None if node is None else made(node, part))
    if isinstance(node, tuple):
        for one in (*(one.name for one in node if getattr(one, "name", "")), *range(len(node))):
            yield f"{one}.", ("", ())
        return
    kind: type = type(node)
    if not hasattr(kind, "__dataclass_fields__"):
        return
    for key, setting in settings_of(kind).items():
        if node is not scene or key != "panels":
            yield _offered(key, setting)
    if node is scene:
        yield from ((f"{name}.", (_doc(first_paragraph(type(one).__doc__)), ())) for name, one in rules.items())


def _offered(key: str, setting: Setting) -> tuple[str, tuple[str, tuple[str, ...]]]:
    """A key with `.` after what has settings or entries of its own and else `=`; what it means; values of few."""
    from ..scene import specs

    spec = setting.spec
    deeper = isinstance(spec, specs.ModelSpec | specs.UnionSpec | specs.ItemsSpec | specs.RulesSpec)
    options = spec.options if isinstance(spec, specs.ChoiceSpec) else ()
    values = ("true", "false") if isinstance(spec, specs.BooleanSpec) else options
    return f"{key}{'.' if deeper else '='}", (_doc(spec.doc), values)


def _doc(words: str) -> str:
    """The first sentence of what a setting means."""
    return words.split(". ")[0].split(": ")[0].strip(".")


def listed(choices: Iterable[str], incomplete: str) -> list[CompletionItem]:
    """Words of a list with commas in between: the choices that are not there yet, after the last comma."""
    done, comma, begin = incomplete.rpartition(",")
    taken = done.split(",")
    return [CompletionItem(f"{done}{comma}{one}") for one in choices if one.startswith(begin) and one not in taken]


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


class Bash(BashComplete):
    """Takes the line as it is typed: Bash's own list of words is cut at = and at :."""

    source_template = BASH

    @staticmethod
    def _check_version() -> None:
        """The script works with Bash 4.4 and newer, which any system of today has; click would start one to ask."""

    def get_completion_args(self) -> tuple[list[str], str]:
        line = os.environ["COMP_LINE"]
        typed = split_arg_string(line)[1:]
        incomplete = typed.pop() if typed and not line[-1:].isspace() else ""
        return typed, incomplete


class Zsh(ZshComplete):
    """Adds no space after what is offered without a description, such as a part of a key."""

    source_template = ZshComplete.source_template.replace("compadd -U", "compadd -S '' -U")

    def format_completion(self, item: CompletionItem) -> str:
        return super().format_completion(CompletionItem(item.value) if item.value.endswith((".", "=")) else item)


CLASSES: dict[str, type[ShellComplete]] = {"bash": Bash, "zsh": Zsh, "fish": FishComplete}


def register() -> None:
    """Have click answer shells by these classes."""
    for name, one in CLASSES.items():
        add_completion_class(one, name)


@click.command()
@click.argument("shell", required=False, type=click.Choice(tuple(CLASSES)))
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
