"""`strandcli golden`: golden images, checked or updated."""

from __future__ import annotations

import functools
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import MismatchError
from . import options
from .progress import Talk, printable

if TYPE_CHECKING:
    from ..study.golden import Result


@click.group(no_args_is_help=False)
def command() -> None:
    """Check or update golden images: a folder with a list of presets, golden.yaml, and a small picture of each.

    On a machine of the class that the pictures were made on they must agree in every bit; elsewhere within the
    tolerance that the documentation states.
    """


directory_argument = click.argument("directory", type=options.PathType(), metavar="DIR")
names_argument = click.argument("names", nargs=-1, metavar="[NAME]...")


@command.command()
@directory_argument
@names_argument
@options.folder("golden-diff in the temporary folder")
@click.option("--junit", "xml", type=options.PathType(), metavar="FILE", help="Also write the results as JUnit XML.")
@options.threads
@options.talk("Say what is compiled, where stderr is no terminal too.")
def check(
    directory: Path, names: tuple[str, ...], output: Path | None, xml: Path | None, threads: int | None, talk: Talk
) -> None:
    """Draw the images of DIR, or only those called NAME, and compare; a mismatch ends in exit code 3."""
    from ..output.files import prepare_folder, write_pieces
    from ..study import golden

    entries = golden.select(golden.read_entries(directory), names)
    if xml is not None:
        prepare_folder(xml.parent, 0)
    output = output or Path(tempfile.gettempdir()) / "golden-diff"
    results, seconds = [], []
    with talk.compiled(len(entries), "golden check", threads) as progress:
        drawer = functools.partial(golden.draw, notify=progress.note, threads=threads)
        for entry in entries:
            began = time.perf_counter()
            result = golden.check(directory, entry, output, drawer)
            results.append(result)
            seconds.append(time.perf_counter() - began)
            progress.step()
            if not (talk.quiet and result.matches):
                place = f" ({result.difference})" if result.difference else ""
                progress.line(f"{'ok      ' if result.matches else 'MISMATCH'} {entry.name}: {result.words}{place}")
    if xml is not None:
        write_pieces(xml, [junit(results, seconds)])
    failed = [result.entry.name for result in results if not result.matches]
    found = [result.as_dict() for result in results]
    talk.data({"machine_class": golden.machine_class(), "mismatches": len(failed), "images": found})
    if failed:
        raise MismatchError(f"{len(failed)} of {len(results)} golden images do not match: {', '.join(failed)}")


@command.command()
@directory_argument
@names_argument
@options.threads
@options.talk("Name the images that did not change, too.")
def update(directory: Path, names: tuple[str, ...], threads: int | None, talk: Talk) -> None:
    """Make what is drawn now the golden images of DIR, or only those called NAME. Look at them before you commit."""
    from ..output.files import prepare_folder
    from ..study import golden

    listed = golden.read_entries(directory)
    entries = golden.select(listed, names)
    prepare_folder(directory, 0)
    changes: dict[str, str] = {}
    with talk.compiled(len(entries), "golden update", threads) as progress:
        drawer = functools.partial(golden.draw, notify=progress.note, threads=threads)
        for entry in entries:
            change = golden.update(directory, entry, drawer)
            progress.step()
            if change is not None:
                changes[entry.name] = change
            if not talk.quiet and (change is not None or talk.verbose):
                progress.line(f"{entry.name}: {change or 'unchanged'}")
    if not names:
        changes |= dict.fromkeys(golden.prune(directory, listed), "removed")
    talk.data({"machine_class": golden.machine_class(), "changes": changes})
    talk.note(f"{directory}: {len(changes)} of {len(entries)} golden images changed")


def junit(results: Sequence[Result], seconds: Sequence[float]) -> bytes:
    """The results as JUnit XML, which CI systems show case by case: a test case an image, with its seconds; a failure
    says why and names the picture of the difference."""
    from xml.etree import ElementTree

    failed = sum(not result.matches for result in results)
    counts = {"tests": str(len(results)), "failures": str(failed), "errors": "0", "time": f"{sum(seconds):.3f}"}
    root = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(root, "testsuite", {"name": "strandcli golden check", **counts})
    for result, took in zip(results, seconds, strict=True):
        name = {"classname": "golden", "name": result.entry.name, "time": f"{took:.3f}"}
        case = ElementTree.SubElement(suite, "testcase", name)
        if not result.matches:
            failure = ElementTree.SubElement(case, "failure", {"message": printable(result.words)})
            failure.text = printable(str(result.difference or ""))
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True)
