"""How commands speak: tables and progress for people, one JSON object for programs, exit codes."""

import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.output import to_json
from smoothprofile.simulation import Simulation

DONE, BAD_INPUT, BLEW_UP, STOPPED = 0, 2, 3, 4
SECONDS_BETWEEN_LINES = 5.0


def print_json(data: Any) -> None:
    """One JSON object, alone on standard output."""
    sys.stdout.write(to_json(data) + "\n")


def print_table(title: str, heads: tuple[str, ...], rows: list[tuple]) -> None:
    """A table on standard output."""
    table = Table(title=title, title_justify="left", title_style="bold", header_style="")
    for head in heads:
        table.add_column(head, overflow="fold")
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
    except CaseError as error:
        _leave(json, "refused", str(error), BAD_INPUT)
    except BlowUpError as error:
        _leave(json, "blew_up", str(error), BLEW_UP)
    except KeyboardInterrupt:
        _leave(json, "interrupted", "Stopped by a signal.", STOPPED)
    except OSError as error:
        what = f"{error.strerror}: {error.filename}" if error.filename else str(error)
        _leave(json, "refused", f"{what}.", BAD_INPUT)
    except MemoryError:
        _leave(json, "refused", "The memory of this machine is too small.", BAD_INPUT)


def _leave(json: bool, status: str, message: str, code: int) -> None:
    if json:
        print_json({"status": status, "error": message, "exit_code": code})
    say(message)
    raise typer.Exit(code)


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
            console=Console(stderr=True),
            transient=True,
        )
        self._tasks: dict[int, Any] = {}

    def __enter__(self) -> "Watcher":
        if self._live:
            self._bar.start()
        return self

    def __exit__(self, *_) -> None:
        if self._live:
            self._bar.stop()

    def __call__(self, simulation: Simulation) -> None:
        end = simulation.case.time.end
        shape = "×".join(str(n) for n in simulation.grid.shape)
        if self._live:
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
    return f"{cell:.5g}" if isinstance(cell, float) else str(cell)
