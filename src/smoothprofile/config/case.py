"""A whole case: its tables, and what must hold between them."""

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, ValidationInfo, field_validator, model_validator

from smoothprofile.config.contact import Contact
from smoothprofile.config.domain import Domain, Faces
from smoothprofile.config.electric import Electric
from smoothprofile.config.fluid import Fluid
from smoothprofile.config.output import ELECTRIC_FIELDS, FLOW_FIELDS, Output, plane_that_shows
from smoothprofile.config.particle import Particle, shown_signal
from smoothprofile.config.placement import check_placement
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.stokes import check_stokes, is_stokes, with_meaning
from smoothprofile.config.tomltext import document
from smoothprofile.config.units import Units
from smoothprofile.config.values import (
    COUNT,
    COUNTS,
    POSITIVE,
    Count,
    Counts,
    Positive,
    Table,
    is_finite,
    known,
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


class Profile(Table):
    """[profile]: the indicator function, its thickness ξ, and how surfaces are moved for it."""

    kind: Annotated[str, known(PROFILES)] = Field(
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
    scheme: Annotated[str, known(SCHEMES)] = Field(
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
    """Everything a run is told; equal cases give equal runs.

    A case has [fluid] and [time], and what flows is stepped in time, in an electric field if it
    has [electric] too; or it has [electric] alone, and is one field around bodies that are held.
    """

    title: str = Field("Untitled case", description="a text in quotes")
    reference: str | None = Field(None, description="the name of a reference in quotes")
    units: Units | None = Field(None, description="a table [units] with length, time and mass")
    domain: Domain = Field(description="a table [domain] with lengths, cells and boundaries")
    fluid: Fluid | None = Field(None, description="a table [fluid] with density and viscosity")
    electric: Electric | None = Field(
        None, description="a table [electric] with a field or electrodes"
    )
    profile: Profile | None = Field(None, description="a table [profile] with thickness")
    particles: Annotated[tuple[Particle, ...], Field(strict=False)] = Field(
        (), description="a list of tables, each under [[particles]]"
    )
    contact: Contact = Field(Contact(), description="a table [contact]")
    time: Time | None = Field(None, description="a table [time] with end")
    start: Annotated[tuple[Start, ...], Field(strict=False)] = Field(
        (), description="a list of tables, each under [[start]]"
    )
    output: Output = Field(Output(), description="a table [output]")

    def to_toml(self) -> str:
        """The case as TOML with every default spelled out; loading it gives an equal case."""
        return document(self.data())

    def data(self) -> dict[str, Any]:
        """The case as plain data with every default spelled out."""
        data = self.model_dump(exclude_none=True)
        return with_meaning(data) if is_stokes(self) else data

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

    @model_validator(mode="before")
    @classmethod
    def _fields_that_there_are(cls, data: Any) -> Any:
        """What is written if the case does not say: the fields of its physics."""
        if not isinstance(data, dict) or not isinstance(data.get("output", {}), dict):
            return data
        flow = FLOW_FIELDS if "fluid" in data else ()
        electric = ELECTRIC_FIELDS if "electric" in data else ()
        output = {"fields": [*flow, "indicator", *electric], **data.get("output", {})}
        data = {**data, "output": output}
        if flow and isinstance(data.get("electric"), dict):
            # Warm starts make each step's error small beside that of the last, and steps are many.
            data["electric"] = {"tolerance": 1e-4, "effective": False, **data["electric"]}
        return data

    @field_validator("particles")
    @classmethod
    def _all_named(cls, particles: tuple[Particle, ...]) -> tuple[Particle, ...]:
        named = []
        for number, particle in enumerate(particles):
            plain = particle.shape if len(particles) == 1 else f"{particle.shape} {number}"
            named.append(particle.model_copy(update={"name": particle.name or plain}))
        return tuple(named)

    @field_validator("output")
    @classmethod
    def _plane_to_look_at(cls, output: Output, info: ValidationInfo) -> Output:
        if "plane" in output.model_fields_set:
            return output
        plane = plane_that_shows(info.data.get("fluid"), info.data.get("electric"))
        return output.model_copy(update={"plane": plane})

    @model_validator(mode="after")
    def _tables_agree(self) -> "Case":
        self._check_physics()
        if self.fluid is not None:
            self.fluid.check(self.domain)
            self._check_thickness()
            if is_stokes(self):
                check_stokes(self)
        if self.electric is not None:
            self.electric.check(self.domain, self.particles, self.fluid is not None)
        self.contact.check(self.domain)
        self.output.check(self.domain)
        self._check_names()
        self._check_start_cells()
        self._check_start()
        check_placement(self.particles, self.domain)
        return self

    def _check_physics(self) -> None:
        """Refusal of tables without the physics that they belong to."""
        if self.fluid is not None and self.time is None:
            raise Refusal("time", MISSING, "a case with [fluid] needs [time] with end")
        if self.fluid is None and self.electric is None:
            raise Refusal(
                "fluid", MISSING, "a case needs [fluid] with density and viscosity, or [electric]"
            )
        if self.fluid is None:
            self._check_still()
        for number, name in enumerate(self.output.fields):
            needs = "fluid" if name in FLOW_FIELDS else "electric"
            if name != "indicator" and getattr(self, needs) is None:
                allowed = f"a case without [{needs}] has no {name}"
                raise Refusal(f"output.fields.{number}", name, allowed)
        for number, particle in enumerate(self.particles if self.electric is None else ()):
            if particle.permittivity is not None:
                key = f"particles.{number}.permittivity"
                raise Refusal(key, particle.permittivity, "a case without [electric] has none")

    def _check_still(self) -> None:
        """Refusal of what moves, in a case of a field alone."""
        output, usual = self.output, Contact()
        for key, value, what in (
            ("profile.thickness", self.profile and self.profile.thickness, "profile"),
            ("time.end", self.time and self.time.end, "time"),
            ("start.0.cells", self.start and self.start[0].cells, "start"),
            ("output.lines.0.name", output.lines and output.lines[0].name, "output.lines"),
            ("output.wall_line.wall", output.wall_line and output.wall_line.wall, "flow at walls"),
            ("output.fields_every", output.fields_every, "time"),
            *((f"contact.{k}", v, "contact") for k, v in self.contact if v != getattr(usual, k)),
        ):
            if value:
                raise Refusal(key, value, f"a case without [fluid] has no {what}")
        for number, particle in enumerate(self.particles):
            if particle.motion != "held":
                allowed = 'bodies of a case without [fluid] are "held"'
                raise Refusal(f"particles.{number}.motion", particle.motion, allowed)

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
