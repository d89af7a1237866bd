"""[fluid] of a case: the liquid, what drives it, and how the walls move."""

from typing import Literal

from pydantic import Field

from smoothprofile.config.domain import Domain
from smoothprofile.config.refusals import Refusal
from smoothprofile.config.values import (
    AXES,
    FLAG,
    NUMBER,
    NUMBERS,
    POSITIVE,
    SIDES,
    VELOCITY,
    Positive,
    Table,
    Vector,
    Velocity,
)
from smoothprofile.signals import Signal

STOKES = "stokes"


class WallVelocity(Table):
    """[fluid.wall_velocity]: how each wall moves along itself; one left out is at rest."""

    x_low: Velocity | None = Field(None, description=VELOCITY)
    x_high: Velocity | None = Field(None, description=VELOCITY)
    y_low: Velocity | None = Field(None, description=VELOCITY)
    y_high: Velocity | None = Field(None, description=VELOCITY)
    z_low: Velocity | None = Field(None, description=VELOCITY)
    z_high: Velocity | None = Field(None, description=VELOCITY)

    def given(self) -> dict[str, Signal]:
        """The signals that were given, by side."""
        return {side: signal for side in SIDES if (signal := getattr(self, side)) is not None}


class MeanVelocity(Table):
    """[fluid.mean_velocity]: held by a body force; an axis left out is free."""

    x: float | None = Field(None, description=NUMBER)
    y: float | None = Field(None, description=NUMBER)
    z: float | None = Field(None, description=NUMBER)

    def given(self) -> dict[int, float]:
        """The mean velocities that were given, by axis number."""
        values = (self.x, self.y, self.z)
        return {axis: value for axis, value in enumerate(values) if value is not None}


class Fluid(Table):
    """[fluid]: density, dynamic viscosity, body force per unit volume, and what is held.

    Gravity, an acceleration, pulls free bodies by what they weigh more than the fluid; the
    hydrostatic pressure that balances the fluid's own weight is left out.

    flow = "stokes" leaves all inertia out: what moves is at any time what the forces at that time
    make it. There, tolerance is that of each solve, and density is for weights and numbers alone.
    """

    flow: Literal["inertial", STOKES] = Field("inertial", description=f'"inertial" or "{STOKES}"')
    tolerance: Positive | None = Field(None, description=POSITIVE)
    density: Positive = Field(description=POSITIVE)
    viscosity: Positive = Field(description=POSITIVE)
    body_force: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    gravity: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    initial_velocity: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    advection: bool = Field(True, description=FLAG)
    mean_velocity: MeanVelocity = Field(MeanVelocity(), description="a table such as { x = 1.0 }")
    wall_velocity: WallVelocity = Field(
        WallVelocity(), description="a table such as { y_high = [1.0, 0.0, 0.0] }"
    )

    def check(self, domain: Domain) -> None:
        """Refusal of what the ends of the domain do not allow."""
        if self.tolerance is not None and self.flow != STOKES:
            allowed = f'only flow = "{STOKES}" has one'
            raise Refusal("fluid.tolerance", self.tolerance, allowed)
        for side, signal in self.wall_velocity.given().items():
            key, value = f"fluid.wall_velocity.{side}", signal.constant
            kind, axis = domain.sides[side], AXES.index(side[0])
            if kind != "wall":
                raise Refusal(key, value, f'only a "wall" can move, and {side} is "{kind}"')
            if signal.maximum[axis] > 0.0:
                shown = value if value[axis] else signal.amplitude
                allowed = f"a wall moves only along itself, so its {side[0]} component must be 0"
                raise Refusal(key, shown, allowed)
        for axis, value in self.mean_velocity.given().items():
            if not domain.periodic[axis]:
                allowed = f"it can be held only along a periodic axis, and {AXES[axis]} has walls"
                raise Refusal(f"fluid.mean_velocity.{AXES[axis]}", value, allowed)
            if self.body_force[axis]:
                allowed = f"along {AXES[axis]} the mean velocity is held, whatever drives it"
                raise Refusal("fluid.body_force", list(self.body_force), allowed)
        for axis, value in enumerate(self.initial_velocity):
            if value and not domain.periodic[axis]:
                allowed = f"its {AXES[axis]} component must be 0, for {AXES[axis]} has walls"
                raise Refusal("fluid.initial_velocity", self.initial_velocity, allowed)
