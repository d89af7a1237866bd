"""[output] of a case: what is written, and what the report draws."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from smoothprofile.config.domain import Domain
from smoothprofile.config.electric import Electric
from smoothprofile.config.fluid import Fluid
from smoothprofile.config.refusals import Refusal
from smoothprofile.config.values import (
    AXES,
    AXIS,
    COUNT,
    NAME,
    NUMBER,
    POSITIVE,
    AxisName,
    Count,
    Name,
    Positive,
    Side,
    Table,
)

FieldName = Literal["velocity", "pressure", "indicator", "potential", "electric_field"]
FLOW_FIELDS, ELECTRIC_FIELDS = ("velocity", "pressure"), ("potential", "electric_field")


class PlaneCut(Table):
    """output.plane: the plane `axis` = `at` of the mid-plane figure."""

    axis: AxisName = Field("z", description=AXIS)
    at: float | None = Field(None, description=f"{NUMBER}, or left out for the middle")


def plane_that_shows(fluid: Fluid | None, electric: Electric | None) -> PlaneCut:
    """The middle plane across the last axis along which nothing acts and no sliding wall lies.

    What acts is the field, gravity, body force, a mean velocity, and walls that slide, whose normal
    counts too: chains, wakes and profiles of shear are seen from the side. z if no axis is left.
    """
    taken = np.zeros(3, dtype=bool)
    if electric is not None:
        taken |= np.array(electric.field, dtype=bool) | np.array(electric.quadrature, dtype=bool)
        if electric.electrodes is not None:
            taken[AXES.index(electric.electrodes.axis)] = True
    if fluid is not None:
        taken |= np.array(fluid.gravity, dtype=bool) | np.array(fluid.body_force, dtype=bool)
        taken[[axis for axis, value in fluid.mean_velocity.given().items() if value]] = True
        for side, signal in fluid.wall_velocity.given().items():
            slides = signal.maximum > 0
            taken |= slides
            taken[AXES.index(side[0])] |= slides.any()
    left = np.flatnonzero(~taken)
    return PlaneCut(axis=AXES[left[-1]] if left.size else "z")


class Line(Table):
    """[[output.lines]]: a velocity component along `axis`, through the other two coordinates."""

    name: Name = Field(description=NAME)
    axis: AxisName = Field(description=AXIS)
    through: Annotated[tuple[float, float], Field(strict=False)] = Field(
        description="two finite numbers, the other coordinates in the order x, y, z"
    )
    component: AxisName = Field("x", description=AXIS)


class WallLine(Table):
    """output.wall_line: ∂u_component/∂n on a wall, along one of its axes at the other's `at`."""

    wall: Side = Field(description="one of x_low, x_high, y_low, y_high, z_low and z_high")
    component: AxisName = Field("x", description=AXIS)
    along: AxisName = Field("x", description=AXIS)
    at: float = Field(description=NUMBER)


class Output(Table):
    """[output]: history every so many steps, fields every so much time, cuts for the report.

    A checkpoint is written every `checkpoint_every` seconds of wall clock, and a run that has gone
    on for `stop_after` seconds stops with one.
    """

    every: Count = Field(1, description=COUNT)
    fields: Annotated[tuple[FieldName, ...], Field(strict=False)] = Field(
        ("velocity", "pressure", "indicator"),
        description='a list of "velocity", "pressure", "indicator", "potential" and '
        '"electric_field"',
    )
    fields_every: Positive | None = Field(None, description=POSITIVE)
    checkpoint_every: Positive = Field(300.0, description=POSITIVE)
    stop_after: Positive | None = Field(None, description=POSITIVE)
    plane: PlaneCut = Field(PlaneCut(), description='a table such as { axis = "z", at = 0.0 }')
    lines: Annotated[tuple[Line, ...], Field(strict=False)] = Field(
        (), description="a list of tables, each under [[output.lines]]"
    )
    wall_line: WallLine | None = Field(
        None, description="a table with the keys wall, component, along and at"
    )

    def check(self, domain: Domain) -> None:
        """Refusal of cuts that miss the domain or make no sense in it."""
        if self.plane.at is not None:
            _within(domain, AXES.index(self.plane.axis), "output.plane.at", self.plane.at)
        names = [line.name for line in self.lines]
        for number, line in enumerate(self.lines):
            if line.name in names[:number]:
                key, allowed = f"output.lines.{number}.name", "another line has that name"
                raise Refusal(key, line.name, allowed)
            across = [axis for axis in range(3) if AXES[axis] != line.axis]
            for place, axis in enumerate(across):
                key = f"output.lines.{number}.through.{place}"
                _within(domain, axis, key, line.through[place])
        if self.wall_line is not None:
            self._check_wall_line(domain, self.wall_line)

    def _check_wall_line(self, domain: Domain, line: WallLine) -> None:
        normal = line.wall[0]
        if domain.sides[line.wall] == "periodic":
            allowed = f"{normal} is periodic and has no walls"
            raise Refusal("output.wall_line.wall", line.wall, allowed)
        for key, axis in (("component", line.component), ("along", line.along)):
            if axis == normal:
                allowed = f"it must be an axis along the wall, and {normal} is across it"
                raise Refusal(f"output.wall_line.{key}", axis, allowed)
        (other,) = {0, 1, 2} - {AXES.index(normal), AXES.index(line.along)}
        _within(domain, other, "output.wall_line.at", line.at)


def _within(domain: Domain, axis: int, key: str, value: float) -> None:
    if not domain.contains(axis, value):
        allowed = f"it must lie within the domain, {domain.reach(axis)} along {AXES[axis]}"
        raise Refusal(key, value, allowed)
