"""[electric] of a case: what drives the field, how permittivity is smoothed, how it is solved."""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from smoothprofile.config.domain import Domain
from smoothprofile.config.particle import Particle
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.values import (
    AXES,
    AXIS,
    COUNT,
    FLAG,
    NUMBER,
    NUMBERS,
    POSITIVE,
    AxisName,
    Count,
    Positive,
    Table,
    Vector,
    known,
)
from smoothprofile.profiles import PROFILES

ELECTRODES = 'a table such as { axis = "z", low = 0, high = 1 }'
SPECTRAL = "fourier"
LARGEST_RATIO = 1e9
"""Of permittivities, either way round; beyond it no painted radius can be found."""


def has_edges(particle: Particle) -> bool:
    """Whether a body has edges, about which a smoothed layer's normal turns within a cell."""
    return particle.shape in ("box", "cylinder", "union") and particle.bounded


class Electrodes(Table):
    """electric.electrodes: the two walls of an axis, each held at a potential."""

    axis: AxisName = Field(description=AXIS)
    low: float = Field(0.0, description=NUMBER)
    high: float = Field(description=NUMBER)


class Electric(Table):
    """[electric]: the mean field or electrodes, and the permittivity of the fluid.

    Sides that are neither periodic nor electrodes let no flux through. `tolerance` is the relative
    residual, or with the fixed-point method the thesis' error. `effective` asks for the effective
    permittivity tensor of a box with three periodic axes.

    With angular_frequency ω the mean field is field·cos ωt + quadrature·sin ωt, and potentials go
    with cos ωt: two fields of one size at right angles rotate. `every`: steps between two solves.
    """

    field: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    electrodes: Electrodes | None = Field(None, description=ELECTRODES)
    angular_frequency: Positive | None = Field(None, description=POSITIVE)
    quadrature: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    permittivity: Positive = Field(1.0, description=POSITIVE)
    discretisation: Literal["finite-volume", "fourier"] = Field(
        "finite-volume", description='"finite-volume" or "fourier"'
    )
    method: Literal["conjugate-gradients", "fixed-point"] = Field(
        "conjugate-gradients", description='"conjugate-gradients" or "fixed-point"'
    )
    smoothing: Literal["auto", "tensor", "harmonic", "arithmetic"] = Field(
        description='"auto", "tensor", "harmonic" or "arithmetic"'
    )
    profile: Annotated[str, known(PROFILES)] = Field(
        "tanh", description=f"one of {', '.join(PROFILES)}"
    )
    thickness: Positive | None = Field(None, description=POSITIVE)
    retract: bool = Field(description=FLAG)
    tolerance: Annotated[float, Field(ge=1e-14, lt=1)] = Field(
        1e-6, description="a number from 1e-14 to below 1"
    )
    max_iterations: Count = Field(1000, description=COUNT)
    effective: bool = Field(True, description=FLAG)
    every: Count = Field(1, description=COUNT)

    @model_validator(mode="before")
    @classmethod
    def _defaults_of_its_discretisation(cls, data: Any) -> Any:
        """Of the staggered grid, what is most accurate; of its own solver, the thesis'."""
        if not isinstance(data, dict):
            return data
        spectral = data.get("discretisation") == SPECTRAL
        if spectral and data.get("smoothing") == "auto":
            data = {**data, "smoothing": "arithmetic"}
        return {
            "smoothing": "arithmetic" if spectral else "auto",
            "retract": not spectral,
            **data,
        }

    @model_validator(mode="after")
    def _has_one_drive(self) -> "Electric":
        if self.electrodes is None and not any(self.field) and not any(self.quadrature):
            raise Refusal("field", self.field, "a case needs a field other than 0, or electrodes")
        if self.electrodes is not None:
            axis = AXES.index(self.electrodes.axis)
            for key in ("field", "quadrature"):
                if getattr(self, key)[axis] != 0.0:
                    allowed = f"the electrodes already set the field along {self.electrodes.axis}"
                    raise Refusal(key, getattr(self, key), allowed)
            if self.electrodes.low == self.electrodes.high and not any(self.field):
                allowed = "the electrodes need different potentials, or the case another field"
                raise Refusal("electrodes.high", self.electrodes.high, allowed)
        if self.discretisation == SPECTRAL:
            if self.smoothing != "arithmetic":
                allowed = 'discretisation = "fourier" takes "arithmetic" alone'
                raise Refusal("smoothing", self.smoothing, allowed)
            if self.retract:
                allowed = 'discretisation = "fourier" paints surfaces where they are'
                raise Refusal("retract", self.retract, allowed)
        elif self.method != "conjugate-gradients":
            allowed = 'it is a method of discretisation = "fourier"'
            raise Refusal("method", self.method, allowed)
        return self

    def check(self, domain: Domain, particles: Sequence[Particle], flows: bool) -> None:
        """Refusal of what does not suit the box or the bodies; `flows`: with a fluid around."""
        self._check_time(flows)
        if domain.precision != "double":
            allowed = 'a case with [electric] needs "double"'
            raise Refusal("domain.precision", domain.precision, allowed)
        electrodes = self.electrodes
        if electrodes is not None and domain.periodic[AXES.index(electrodes.axis)]:
            allowed = "electrodes need an axis with walls, and that one is periodic"
            raise Refusal("electric.electrodes.axis", electrodes.axis, allowed)
        for axis in range(3):
            if (self.field[axis] or self.quadrature[axis]) and not domain.periodic[axis]:
                allowed = (
                    f"the walls of {AXES[axis]} let no flux through; "
                    f'give electrodes = {{ axis = "{AXES[axis]}", low = .., high = .. }}'
                )
                raise Refusal("electric.field", self.field, allowed)
        if self.discretisation == SPECTRAL:
            self._check_spectral(domain)
        for number, particle in enumerate(particles):
            self._check_body(number, particle)
            if particle.motion == "free" and has_edges(particle):
                key = f"particles.{number}.shape"
                allowed = "a field turns it wrongly about its edges; only round bodies move in one"
                raise Refusal(key, particle.shape, allowed)

    def _check_time(self, flows: bool) -> None:
        if self.angular_frequency is None and any(self.quadrature):
            allowed = "it needs electric.angular_frequency"
            raise Refusal("electric.quadrature", self.quadrature, allowed)
        if not flows and self.angular_frequency is not None:
            allowed = "a case without [fluid] is one field that does not change"
            raise Refusal("electric.angular_frequency", self.angular_frequency, allowed)
        if flows and self.effective:
            allowed = "it takes a field of its own, and a case with [fluid] has none for it"
            raise Refusal("electric.effective", True, allowed)
        if not flows and self.every > 1:
            raise Refusal("electric.every", self.every, "a case without [fluid] has no steps")
        if flows and self.discretisation == SPECTRAL:
            allowed = 'it gives no forces; a case with [fluid] takes "finite-volume"'
            raise Refusal("electric.discretisation", self.discretisation, allowed)

    def _check_spectral(self, domain: Domain) -> None:
        if not all(domain.periodic) or any(kind != "uniform" for kind in domain.stretching):
            allowed = "it needs three periodic axes of equal cells"
            raise Refusal("electric.discretisation", self.discretisation, allowed)

    def _check_body(self, number: int, particle: Particle) -> None:
        key = f"particles.{number}"
        if particle.permittivity is None:
            raise Refusal(f"{key}.permittivity", MISSING, "a case with [electric] needs it")
        ratio = particle.permittivity / self.permittivity
        if not 1.0 / LARGEST_RATIO <= ratio <= LARGEST_RATIO:
            low, high = self.permittivity / LARGEST_RATIO, self.permittivity * LARGEST_RATIO
            allowed = f"beside electric.permittivity it must be from {low:g} to {high:g}"
            raise Refusal(f"{key}.permittivity", particle.permittivity, allowed)
        if particle.shape == "mesh":
            allowed = "a triangulated surface cannot have a permittivity"
            raise Refusal(f"{key}.shape", particle.shape, allowed)
        name, smallest = particle.thinnest
        if self.thickness is not None and math.isfinite(smallest) and self.thickness > smallest:
            allowed = f"it may not exceed {smallest:g}, the smallest radius or half side, of {key}"
            raise Refusal("electric.thickness", self.thickness, f"{allowed}.{name}")
