"""How commands speak: tables and progress for people, one JSON object for programs, exit codes."""

import math
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Timer
from typing import TYPE_CHECKING, Any, NoReturn

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from smoothprofile.errors import BlowUpError, CaseError, OutputError, StoppedError
from smoothprofile.jsontext import to_json

if TYPE_CHECKING:
    from smoothprofile.runs import Run

DONE, BAD_INPUT, BLEW_UP, STOPPED = 0, 2, 3, 4
SECONDS_BETWEEN_LINES = 5.0
PREPARING = "Preparing. The first run on a machine also compiles, which takes about a minute."


def print_json(data: Any) -> None:
    """One JSON object, alone on standard output."""
    sys.stdout.write(to_json(data) + "\n")


def check_free(path: Path | None, kind: str = "file") -> None:
    """CaseError if the path is taken or lies below a file; to be asked before any work for it."""
    if path is None:
        return
    if path.exists():
        raise CaseError(f"the {kind} {path} exists already; nothing was overwritten.")
    nearest = next(parent for parent in path.parents if parent.exists())
    if not nearest.is_dir():
        raise CaseError(f"the {kind} {path} cannot be made: {nearest} is not a directory.")


def answer(data: Any, json: bool, out: Path | None) -> bool:
    """Give `data` as JSON on standard output and to the file `out`, each if asked for.

    Returns whether it is still to be shown to a person.
    """
    if out is not None:
        check_free(out)
        out.write_text(to_json(data) + "\n", encoding="utf-8")
    if json:
        print_json(data)
    return not json


def print_table(
    title: str, heads: tuple[str, ...], rows: list[tuple], folds: str | None = None
) -> None:
    """A table on standard output; the column `folds` alone gives way, all of them if None."""
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        header_style="",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        collapse_padding=folds is not None,
    )
    for head in heads:
        table.add_column(head, overflow="fold", no_wrap=folds not in (None, head))
    for row in rows:
        table.add_row(*(escape(_text(cell)) for cell in row))
    Console().print(table)


def say(line: str) -> None:
    """A line for people on standard error, which never mixes with JSON."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(escape(line))


@contextmanager
def exit_codes(json: bool) -> Iterator[None]:
    """Turn the ways a command ends badly into one sentence and an exit code."""
    try:
        yield
    except BrokenPipeError:
        raise
    except (
        CaseError,
        BlowUpError,
        KeyboardInterrupt,
        OSError,
        OutputError,
        MemoryError,
    ) as error:
        leave(error, json)


def leave(
    error: BaseException, json: bool, directory: Path | None = None, report: Path | None = None
) -> NoReturn:
    """Say in one sentence how a command ended, and where the run directory is that it leaves.

    The notes of the error, what may be done now, come after it.
    """
    status, code, message = _ending(error)
    left = {} if directory is None else {"directory": str(directory)}
    if report is not None:
        left["report"] = str(report)
    if json:
        print_json({"status": status, "error": message, "exit_code": code, **left})
    say(message)
    for note in getattr(error, "__notes__", ()):
        say(note)
    if left:
        say(f"What was computed is in {directory}" + (f"; open {report}." if report else "."))
    raise typer.Exit(code)


def _ending(error: BaseException) -> tuple[str, int, str]:
    """Status, exit code and sentence."""
    if isinstance(error, BlowUpError):
        return "blew_up", BLEW_UP, str(error)
    if isinstance(error, StoppedError):
        return "interrupted", STOPPED, str(error)
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", STOPPED, "Stopped by a signal."
    if isinstance(error, MemoryError):
        return "refused", BAD_INPUT, "The memory of this machine is too small."
    if isinstance(error, OSError) and error.filename:
        return "refused", BAD_INPUT, f"{error.strerror}: {error.filename}."
    if isinstance(error, OutputError):
        return "failed", BAD_INPUT, str(error)
    return "refused", BAD_INPUT, str(error)


class Watcher:
    """Shows how far a run has come: a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, quiet: bool):
        self._live = sys.stderr.isatty() and not quiet
        self._quiet, self._last = quiet, clock.monotonic()
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("t = {task.fields[time]:.4g}"),
            TimeRemainingColumn(),
            console=Console(stderr=True, highlight=False, soft_wrap=True),
            transient=True,
        )
        self._tasks: dict[int, Any] = {}
        self._patience = Timer(SECONDS_BETWEEN_LINES, self._bar.console.print, (PREPARING,))
        self._patience.daemon = True

    def __enter__(self) -> "Watcher":
        if not self._quiet:
            self._patience.start()
        return self

    def __exit__(self, *_) -> None:
        self._patience.cancel()
        if self._live:
            self._bar.stop()

    def __call__(self, simulation: "Run") -> None:
        self._patience.cancel()
        if simulation.case.time is None:
            return
        end = simulation.case.time.end
        shape = "×".join(str(n) for n in simulation.grid.shape)
        if self._live:
            self._bar.start()
            if id(simulation) not in self._tasks:
                task = self._bar.add_task(shape, total=end, time=0.0)
                self._tasks[id(simulation)] = task
            self._bar.update(
                self._tasks[id(simulation)], completed=simulation.time, time=simulation.time
            )
        elif not self._quiet and clock.monotonic() - self._last > SECONDS_BETWEEN_LINES:
            self._last = clock.monotonic()
            rate = simulation.extremes.rate(simulation.time_step)
            say(
                f"{shape}: step {simulation.steps}, t = {simulation.time:.4g} of {end:.4g}, "
                f"rate of change {rate:.2g}"
            )


def _text(cell: Any) -> str:
    if cell is None:
        return "–"
    if isinstance(cell, float):
        return f"{cell:.5g}" if math.isfinite(cell) else "none"
    return str(cell)
