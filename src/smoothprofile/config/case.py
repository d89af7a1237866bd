"""A whole case: its tables, and what must hold between them."""

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, field_validator, model_validator

from smoothprofile.config.contact import Contact
from smoothprofile.config.domain import Domain, Faces
from smoothprofile.config.fluid import Fluid
from smoothprofile.config.output import Output
from smoothprofile.config.particle import Particle, shown_signal
from smoothprofile.config.placement import check_placement
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.tomltext import document
from smoothprofile.config.values import (
    COUNT,
    COUNTS,
    POSITIVE,
    Count,
    Counts,
    Positive,
    Table,
    is_finite,
)
from smoothprofile.profiles import PROFILES
from smoothprofile.schemes import SCHEMES


def _retract(value: Any) -> bool | str:
    if isinstance(value, bool) or (isinstance(value, str) and value in ("planar", "radial")):
        return value
    raise ValueError("no such retraction")


def _step(value: Any) -> float | str:
    if isinstance(value, str) and value == "auto":
        return value
    if is_finite(value) and value > 0:
        return float(value)
    raise ValueError("no such step")


def _known(names: Any) -> PlainValidator:
    def check(value: Any) -> str:
        if not isinstance(value, str) or value not in names:
            raise ValueError("no such name")
        return value

    return PlainValidator(check)


class Profile(Table):
    """[profile]: the indicator function, its thickness ξ, and how surfaces are moved for it."""

    kind: Annotated[str, _known(PROFILES)] = Field(
        "tanh", description=f"one of {', '.join(PROFILES)}"
    )
    thickness: Positive = Field(description=POSITIVE)
    retract: Annotated[bool | str, PlainValidator(_retract)] = Field(
        True, description='true, false, "planar" or "radial"'
    )


class Time(Table):
    """[time]: step, scheme and coupling, and when to stop.

    `steady_tolerance` stops a run when max|∂u/∂t|/max|u| falls below it, per unit time.
    """

    step: Annotated[float | str, PlainValidator(_step)] = Field(
        "auto", description='"auto" or a finite number above 0'
    )
    scheme: Annotated[str, _known(SCHEMES)] = Field(
        "backward-euler", description=f"one of {', '.join(SCHEMES)}"
    )
    coupling: Literal["incremental", "thesis"] = Field(
        "incremental", description='"incremental" or "thesis"'
    )
    end: Positive = Field(description=POSITIVE)
    steady_tolerance: Positive | None = Field(None, description=POSITIVE)
    max_steps: Count | None = Field(None, description=COUNT)


class Start(Table):
    """[[start]]: a coarser run whose result starts the next; what is left out is the case's own."""

    cells: Counts = Field(description=COUNTS)
    thickness: Positive | None = Field(None, description=POSITIVE)
    step: Annotated[float | str, PlainValidator(_step)] | None = Field(
        None, description='"auto" or a finite number above 0'
    )
    end: Positive | None = Field(None, description=POSITIVE)
    steady_tolerance: Positive | None = Field(None, description=POSITIVE)


class Case(Table):
    """Everything a run is told; equal cases give equal runs."""

    title: str = Field("Untitled case", description="a text in quotes")
    reference: str | None = Field(None, description="the name of a reference in quotes")
    domain: Domain = Field(description="a table [domain] with lengths, cells and boundaries")
    fluid: Fluid = Field(description="a table [fluid] with density and viscosity")
    profile: Profile | None = Field(None, description="a table [profile] with thickness")
    particles: Annotated[tuple[Particle, ...], Field(strict=False)] = Field(
        (), description="a list of tables, each under [[particles]]"
    )
    contact: Contact = Field(Contact(), description="a table [contact]")
    time: Time = Field(description="a table [time] with end")
    start: Annotated[tuple[Start, ...], Field(strict=False)] = Field(
        (), description="a list of tables, each under [[start]]"
    )
    output: Output = Field(Output(), description="a table [output]")

    def to_toml(self) -> str:
        """The case as TOML with every default spelled out; loading it gives an equal case."""
        return document(self.model_dump(exclude_none=True))

    def stages(self) -> tuple["Case", ...]:
        """The runs to make in order: the preliminary ones of `start`, then the case itself."""
        return (
            *(self._stage(start) for start in self.start),
            self.model_copy(update={"start": ()}),
        )

    def _stage(self, start: Start) -> "Case":
        times = start.model_dump(include={"step", "end", "steady_tolerance"}, exclude_none=True)
        changes = {
            "domain": self.domain.model_copy(update={"cells": start.cells}),
            "time": self.time.model_copy(update=times),
            "start": (),
        }
        if self.profile is not None and start.thickness is not None:
            changes["profile"] = self.profile.model_copy(update={"thickness": start.thickness})
        return self.model_copy(update=changes)

    @field_validator("particles")
    @classmethod
    def _all_named(cls, particles: tuple[Particle, ...]) -> tuple[Particle, ...]:
        named = []
        for number, particle in enumerate(particles):
            plain = particle.shape if len(particles) == 1 else f"{particle.shape} {number}"
            named.append(particle.model_copy(update={"name": particle.name or plain}))
        return tuple(named)

    @model_validator(mode="after")
    def _tables_agree(self) -> "Case":
        self.fluid.check(self.domain)
        self.output.check(self.domain)
        self._check_names()
        self._check_thickness()
        self._check_start_cells()
        self._check_start()
        check_placement(self.particles, self.domain)
        return self

    def _check_start(self) -> None:
        """Refusal of a coarse start for bodies that travel: it would leave them elsewhere."""
        for number, particle in enumerate(self.particles if self.start else ()):
            allowed = "a case with [[start]] may not have bodies that travel"
            if particle.motion == "free":
                raise Refusal(f"particles.{number}.motion", "free", allowed)
            if particle.shape != "plane" and particle.velocity.maximum.any():
                key = f"particles.{number}.velocity"
                raise Refusal(key, shown_signal(particle.velocity), allowed)

    def _check_start_cells(self) -> None:
        for axis, stretching in enumerate(self.domain.stretching):
            cells = self.domain.cells[axis]
            for number, start in enumerate(self.start):
                if isinstance(stretching, Faces) and start.cells[axis] != cells:
                    allowed = f"domain.stretching.{axis} lists the faces of {cells} cells"
                    raise Refusal(f"start.{number}.cells", start.cells, allowed)

    def _check_names(self) -> None:
        seen = set()
        for number, particle in enumerate(self.particles):
            if particle.name in seen:
                raise Refusal(
                    f"particles.{number}.name", particle.name, "another body has that name"
                )
            seen.add(particle.name)

    def _check_thickness(self) -> None:
        if not self.particles:
            return
        if self.profile is None:
            raise Refusal(
                "profile", MISSING, "a case with particles needs [profile] with thickness"
            )
        thicknesses = {"profile.thickness": self.profile.thickness}
        for number, start in enumerate(self.start):
            if start.thickness is not None:
                thicknesses[f"start.{number}.thickness"] = start.thickness
        sizes = [(*particle.thinnest[::-1], n) for n, particle in enumerate(self.particles)]
        smallest, name, number = min(sizes)
        for key, thickness in thicknesses.items():
            if thickness > smallest:
                what = f"particles.{number}.{name}"
                allowed = (
                    f"it may not exceed {smallest:g}, the smallest radius or half side, of {what}"
                )
                raise Refusal(key, thickness, allowed)
