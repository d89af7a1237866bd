"""What a study finds: rows of numbers beside the thesis' and the exact ones, curves, figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from smoothprofile.figures import Picture

AGREES, DIFFERS, NEW = "agrees", "differs", "new"

HEADS = ("quantity", "thesis", "exact or confirmed", "ours", "difference", "verdict", "remark")


@dataclass(frozen=True)
class Row:
    """One number of a study.

    thesis     what the thesis prints: a number, words where it only has a figure, None for nothing
    exact      the closed form's or the confirmed value; None where there is none
    tolerance  how far ours may lie from exact: half a unit of the last digit that exact is known to
    remark     why the thesis' number is wrong where it is, or what else a reader must know
    """

    quantity: str
    thesis: float | str | None
    exact: float | None
    ours: float
    tolerance: float
    remark: str = ""

    @property
    def difference(self) -> float | None:
        return None if self.exact is None else self.ours - self.exact

    @property
    def verdict(self) -> str:
        """agrees or differs; new where there is nothing to compare with."""
        if self.exact is None:
            return NEW
        return AGREES if abs(self.difference) <= self.tolerance else DIFFERS

    def cells(self) -> tuple:
        """The row under HEADS."""
        return (
            *(self.quantity, self.thesis, self.exact, self.ours),
            *(self.difference, self.verdict, self.remark),
        )


@dataclass(frozen=True, eq=False)
class Study:
    """A finished study.

    introduction  a few sentences: what is solved, with which equations and parameters
    findings      what was found, a sentence each
    rows          the table
    curves        the data behind the figures: CSV file name (no suffix) -> columns of one length
    pictures      the figures
    """

    title: str
    source: str
    introduction: str
    findings: Sequence[str]
    rows: Sequence[Row]
    curves: Mapping[str, Mapping[str, np.ndarray]]
    pictures: Sequence[Picture] = field(default=())

    @property
    def agrees(self) -> bool:
        """Whether every number that can be compared agrees."""
        return all(row.verdict != DIFFERS for row in self.rows)
