"""The command `strandcli`: a group whose commands are imported when they are called, and one place for all errors."""

from __future__ import annotations

import atexit
import errno
import gc
import importlib
import io
import json
import os
import sys
import warnings
from collections.abc import Sequence
from dataclasses import asdict

import click
import click.shell_completion

from .. import __version__
from ..compiling import runtime
from ..errors import DONE, FAILED, REFUSED, USAGE, StrandError
from . import signals
from .progress import printable

# name of a command and of its module here: what --help says. Commands for pictures first, tools after.
COMMANDS = {
    "render": "Simulate and draw a preset as PNG frames.",
    "simulate": "Simulate a preset and write the positions only.",
    "export": "Write the strands that a preset draws, for other programs.",
    "plan": "Report what would run, what is left out and why; run nothing.",
    "new": "Write a commented preset that draws as it is.",
    "farm": "Write job files for Slurm, GNU parallel or Open Job Description.",
    "presets": "List, show or copy the presets that come with strandcli.",
    "schema": "Print the JSON Schema of presets, for editors.",
    "bench": "Time every stage on the thesis's headline scene.",
    "study": "Error against run time: table, chart, the cheapest setting under an error.",
    "claims": "Measure what the thesis claims, beside its own figures.",
    "stress": "Run the solvers through every extreme and judge them.",
    "golden": "Check or update golden images.",
    "compare": "Compare two images.",
    "info": "Describe a file of strands: counts, sizes, faults, guesses.",
    "convert": "Write a file of strands in another format, scaled, thinned, mended.",
    "dataset": "Draw labelled views of grooms, in the layouts that training reads.",
    "sheet": "Put images on one labelled contact sheet.",
    "completion": "Print what a shell needs to complete commands, presets and keys.",
    "doctor": "Check this machine and installation, and say how to mend faults.",
    "warmup": "Compile ahead of the first run.",
}

FEW_COLLECTIONS = (100_000, 20, 100)
"""A hundred times fewer than Python's: imports and kernels make a million objects and next to no garbage, and to look
at them all takes a tenth of a second each time, and once more when the process ends."""
LIGHT = ("presets", "schema", "completion", "doctor")
"""Commands that need no kernels, or tell themselves what is wrong with them."""


class LazyGroup(click.Group):
    """Knows its commands by name and imports one when it is called for; `--help` imports none."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f".{cmd_name}", __package__)
        command: click.Command = module.command
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[click.shell_completion.CompletionItem]:
        """Commands as `--help` lists them, of which none is imported."""
        if incomplete.startswith("-"):
            return super().shell_complete(ctx, incomplete)
        item = click.shell_completion.CompletionItem
        return [item(name, help=words) for name, words in COMMANDS.items() if name.startswith(incomplete)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            from difflib import get_close_matches

            close = get_close_matches(name, COMMANDS, n=1)
            hint = f"did you mean '{close[0]}'?" if close else f"commands are {', '.join(COMMANDS)}"
            raise click.UsageError(f"no command '{name}'; {hint}", ctx)
        if name not in LIGHT and not ctx.resilient_parsing and not {"-h", "--help"} & set(args):
            runtime.require_addresses()
            runtime.require_threads()
        return super().resolve_command(ctx, args)


@click.command(
    cls=LazyGroup,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    epilog="Exit codes: 0 done, 1 failed, 2 usage or preset, 3 a check did not match, 4 refused or stopped for disk, "
    "memory or permission, 129, 130 and 143 ended by a signal.",
)
@click.version_option(__version__, "--version", prog_name="strandcli", message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, expose_value=False, help="Show tracebacks of bugs.")
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Simulate and draw strands: hair, fur, grass. Needs no GPU and no display."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help(), err=True)
        ctx.exit(USAGE)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; prints every error as one line on stderr. Without
    ``arguments``, those of the process, it ends with them."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by a shell or a service manager
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - as long as the process
    if isinstance(sys.stdout, io.TextIOWrapper):  # as stderr is: a path's bytes may be no text
        sys.stdout.reconfigure(errors="backslashreplace")
    if arguments is None:
        if not sys.warnoptions:  # of libraries, which would stand before the one line of an error
            warnings.simplefilter("ignore")
        runtime.still_idle_threads()
        runtime.give_back_large()
        gc.set_threshold(*FEW_COLLECTIONS)
        atexit.register(gc.freeze)
    with signals.handled(last=arguments is None):
        return _main(arguments)


def _main(arguments: Sequence[str] | None) -> int:
    given = sys.argv[1:] if arguments is None else arguments
    words = [word for word in given if word != "--debug"]  # which may stand anywhere
    debug = bool(os.environ.get("STRANDCLI_DEBUG")) or len(words) < len(given)
    if arguments is None and "_STRANDCLI_COMPLETE" in os.environ:
        from .completion import register

        register()
    try:
        code = cli.main(
            args=words,
            prog_name="strandcli",
            standalone_mode=False,
            color=False if os.environ.get("NO_COLOR") else None,
        )
        sys.stdout.flush()
        return code if isinstance(code, int) else DONE
    except SystemExit as end:  # click's way out of shell completion and of a closed pipe
        _abandon_stdout()
        return end.code if isinstance(end.code, int) else FAILED
    except BrokenPipeError:
        _abandon_stdout()
        return FAILED
    except BaseException as error:
        return report(error, debug, "--json" in words)


_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_REFUSALS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.ENAMETOOLONG)


def report(error: BaseException, debug: bool, as_json: bool = False) -> int:
    """Print ``error`` for the person in front of the terminal, or ``as_json`` for a program, and return the exit code
    it stands for."""
    if debug and not isinstance(error, click.ClickException | click.Abort | KeyboardInterrupt):
        import traceback

        traceback.print_exception(error)
    code, words = _outcome(error, debug)
    faults = getattr(error, "faults", ()) if isinstance(error, StrandError) else ()
    if as_json and words:
        data = {"error": _one_line(words), "exit_code": code, "faults": [asdict(fault) for fault in faults]}
        click.echo(json.dumps(data), err=True)
    elif faults:
        for fault in faults:
            click.echo(_one_line(fault), err=True)
    elif words:
        label = click.style("error:", fg="red", bold=True)
        color = False if os.environ.get("NO_COLOR") else None
        click.echo(f"strandcli: {label} {_one_line(words)}", err=True, color=color)
    return code


def _outcome(error: BaseException, debug: bool) -> tuple[int, str]:
    """The exit code that an error stands for, and its message; "" for an interruption, which has none."""
    match error:
        case StrandError():
            return error.exit_code, str(error)
        case click.UsageError():
            command = error.ctx.command_path if error.ctx is not None else "strandcli"
            return USAGE, f"{_usage(error)} (see '{command} --help')"
        case click.ClickException():
            return USAGE, error.format_message()
        case click.Abort() | KeyboardInterrupt():
            return signals.exit_code(error.__cause__ if isinstance(error, click.Abort) else error), ""
        case NotImplementedError() if runtime.lacks_compiler(error):
            return USAGE, runtime.NO_COMPILER
        case MemoryError():
            limit = runtime.address_limit()
            least = "" if limit is None else f" ('ulimit -v' leaves {limit / 1e6:,.0f} MB of addresses)"
            smaller = "ask for fewer --strands or --particles or a smaller --size"
            return REFUSED, f"out of memory{least}; {smaller} ('strandcli plan' estimates the need)"
        case OSError() if error.errno in _REFUSALS:
            return REFUSED, _os_error(error)
        case OSError() if error.strerror:
            return FAILED, _os_error(error)
        case _:
            hint = "" if debug else "; please report it with the output of the same command with --debug"
            return FAILED, f"unexpected {type(error).__name__}: {error}{hint}"


def _usage(error: click.UsageError) -> str:
    """Wrong usage in words, with what to do where help alone does not tell."""
    words = error.format_message().rstrip(".")
    if isinstance(error, click.MissingParameter) and error.param is not None and error.param.name == "preset":
        return f"{words}: name one that 'strandcli presets' lists, or a file, such as 'strandcli new mine' writes"
    if isinstance(error, click.NoSuchOption) and (meant := _meant(error)):
        return f"{error.message.rstrip('.')}; did you mean {meant}?"
    return words


def _meant(error: click.NoSuchOption) -> str | None:
    """The setting, or the option for it, that other programs have an option of this name for, or that has this name
    itself; None where there is none, or the command has no ``--set``."""
    from ..scene.suggest import ELSEWHERE, settings_by_name

    known = {name for one in error.ctx.command.params for name in one.opts} if error.ctx is not None else set()
    name = error.option_name.lstrip("-").replace("-", "_")
    found = ELSEWHERE.get(name) or next((f"{path}=…" for path in settings_by_name({}).get(name, ())), None)
    if found is None or "--set" not in known:
        return None
    own = f"--{found.partition('=')[0].rpartition('.')[2]}"
    return own if own in known else f"--set {found}"


def _os_error(error: OSError) -> str:
    if error.filename is None and error.errno in _FULL:  # files have names, or refusals of their own
        return f"standard output: {error.strerror}"
    return f"{error.filename}: {error.strerror}" if error.filename is not None else str(error.strerror)


def _one_line(text: object) -> str:
    return printable(" ".join(str(text).split("\n")))


def _abandon_stdout() -> None:
    """Nobody reads stdout any more: let the interpreter's last flush go nowhere, in silence."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):
        return
