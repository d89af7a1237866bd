"""The coarser runs before a case's own: one after the other, each from the end of the one before.

They can be saved between two steps, as the run itself can.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any


class PreliminaryRuns:
    """Those of one case; `rows` tells what the ones that are done took."""

    def __init__(self, cases: Sequence[Any], make: Callable[[Any], Any]):
        """make: case -> the run of it."""
        self._cases, self._make = cases, make
        self.current: Any = None
        self.rows: list[dict[str, Any]] = []

    def run(self, observer: Callable[[Any], None] | None) -> Any:
        """Run what is left of them; the last one, at its end."""
        previous, waiting = self.current, self.current is not None
        for case in self._cases[len(self.rows) :]:
            if waiting:
                run, waiting = previous, False
            else:
                run = self._make(case)
                if previous is not None:
                    run.continue_from(previous)
            self.current = run
            run.run(observer)
            self.rows.append(_row(run))
            previous = run
        self.current = None
        return previous

    def saved(self) -> dict[str, Any]:
        """The one under way, and what is told of those before it."""
        return {"rows": self.rows, "current": self.current.saved()}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take back what `saved` gave; `run` then goes on from there."""
        self.rows = list(saved["rows"])
        self.current = self._make(self._cases[len(self.rows)])
        self.current.restore(saved["current"])


def _row(run: Any) -> dict[str, Any]:
    return {
        "cells": list(run.grid.shape),
        "steps": run.steps,
        "time": run.time,
        "status": run.status,
        "wall_seconds": run.wall_seconds,
        "retries": run.retries,
    }
