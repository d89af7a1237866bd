"""[domain] of a case: the box, its cells, what lies at its ends."""

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, field_validator, model_validator

from smoothprofile.config.refusals import Refusal, read_table
from smoothprofile.config.values import (
    COUNTS,
    LENGTHS,
    NUMBER,
    NUMBERS,
    SIDES,
    Counts,
    Lengths,
    Table,
    Vector,
)


class Focus(Table):
    """Cells that cluster: the widest is `ratio` times the narrowest, which lies at `focus`.

    Up to `core` from the focus cells are equal.
    """

    focus: float = Field(description=NUMBER)
    ratio: Annotated[float, Field(ge=1.0, le=1000.0)] = Field(description="a number from 1 to 1000")
    core: Annotated[float, Field(ge=0.0)] = Field(0.0, description="zero or a positive number")


class Faces(Table):
    """Cells given by the coordinates of their faces, one more than there are cells."""

    faces: Annotated[tuple[float, ...], Field(strict=False)] = Field(
        description="a list of finite numbers that rise"
    )

    @field_validator("faces")
    @classmethod
    def _rise(cls, faces: tuple[float, ...]) -> tuple[float, ...]:
        if any(low >= high for low, high in pairwise(faces)):
            raise ValueError("not rising")
        return faces


def _boundary(value: Any) -> str | tuple[str, str]:
    if isinstance(value, str) and value in ("periodic", "wall", "slip"):
        return value
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("neither a name nor a pair")
    if any(end not in ("wall", "slip") for end in value):
        raise ValueError("no such end")
    return tuple(value)


def _stretching(value: Any) -> str | Focus | Faces:
    if isinstance(value, Focus | Faces) or (isinstance(value, str) and value == "uniform"):
        return value
    if not isinstance(value, dict):
        raise ValueError("neither uniform nor a table")
    return read_table(Faces if "faces" in value else Focus, value)


Boundary = Annotated[Any, PlainValidator(_boundary)]
Stretching = Annotated[Any, PlainValidator(_stretching)]


class Domain(Table):
    """[domain]: lengths, cells and boundaries along x, y, z; `origin` is the low corner."""

    lengths: Lengths = Field(description=LENGTHS)
    cells: Counts = Field(description=COUNTS)
    origin: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    boundaries: Annotated[tuple[Boundary, Boundary, Boundary], Field(strict=False)] = Field(
        description='three entries, each "periodic", "wall", "slip" or a pair ["wall", "slip"]'
    )
    stretching: Annotated[tuple[Stretching, Stretching, Stretching], Field(strict=False)] = Field(
        ("uniform", "uniform", "uniform"),
        description=(
            'three entries, each "uniform", { focus = x, ratio = r, core = c } or { faces = [..] }'
        ),
    )
    precision: Literal["double", "single"] = Field("double", description='"double" or "single"')

    @property
    def high(self) -> tuple[float, float, float]:
        """The corner opposite to `origin`."""
        return tuple(low + length for low, length in zip(self.origin, self.lengths, strict=True))

    @property
    def periodic(self) -> tuple[bool, bool, bool]:
        """Which axes are periodic."""
        return tuple(boundary == "periodic" for boundary in self.boundaries)

    @property
    def sides(self) -> dict[str, str]:
        """The kind of each side, "periodic", "wall" or "slip", by its name: x_low to z_high."""
        pairs = ((end, end) if isinstance(end, str) else end for end in self.boundaries)
        return dict(zip(SIDES, (kind for pair in pairs for kind in pair), strict=True))

    def contains(self, axis: int, coordinate: float) -> bool:
        """Whether a coordinate lies in the box along that axis, its ends counted in."""
        return self.origin[axis] <= coordinate <= self.high[axis]

    def reach(self, axis: int) -> str:
        """The two ends of an axis, in words."""
        return f"{self.origin[axis]:g} to {self.high[axis]:g}"

    @model_validator(mode="after")
    def _stretching_fits(self) -> "Domain":
        for axis, stretching in enumerate(self.stretching):
            if isinstance(stretching, Focus) and not self.contains(axis, stretching.focus):
                key, allowed = f"stretching.{axis}.focus", f"it must lie within {self.reach(axis)}"
                raise Refusal(key, stretching.focus, allowed)
            if isinstance(stretching, Faces):
                self._faces_fit(axis, stretching.faces)
        return self

    def _faces_fit(self, axis: int, faces: tuple[float, ...]) -> None:
        key, wanted = f"stretching.{axis}.faces", self.cells[axis] + 1
        if len(faces) != wanted:
            allowed = f"{self.cells[axis]} cells have {wanted} faces, and these are {len(faces)}"
            raise Refusal(key, faces, allowed)
        # Faces are typed by hand or printed by a program: nine digits are enough to be the end.
        near = 1e-9 * self.lengths[axis]
        if abs(faces[0] - self.origin[axis]) > near or abs(faces[-1] - self.high[axis]) > near:
            raise Refusal(key, faces, f"they must reach from {self.reach(axis)}")
