"""How hard bodies push each other, and how that follows from a case."""

import math
from dataclasses import dataclass

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.particles.contact_law import Law, damping_ratio


@dataclass(frozen=True, eq=False)
class ContactParameters:
    """range s; touch_force F₀ (n,), that of a pair 1/F₀ = 1/F₁ + 1/F₂, a wall's infinite;
    restitution e in (0, 1]; friction μ with its speed v₀; most sub-steps in a step.

    Lubrication is on where viscosity > 0: below outer_gap, no stronger than at inner_gap.
    """

    range: float
    touch_force: np.ndarray
    restitution: float = 0.5
    friction: float = 0.0
    slip_speed: float = 1.0
    viscosity: float = 0.0
    outer_gap: float = 0.0
    inner_gap: float = 0.0
    most_substeps: int = 1000

    def __post_init__(self):
        wrong = {
            "contact.range": (self.range, self.range > 0.0, "above 0"),
            "contact.touch_force": (
                float(np.min(self.touch_force, initial=np.inf)),
                bool(np.all(np.asarray(self.touch_force) > 0.0)),
                "above 0",
            ),
            "contact.restitution": (
                self.restitution,
                0.01 <= self.restitution <= 1.0,
                "between 0.01 and 1",
            ),
            "contact.friction": (self.friction, self.friction >= 0.0, "0 or more"),
            "contact.slip_speed": (self.slip_speed, self.slip_speed > 0.0, "above 0"),
            "contact.inner_gap": (
                self.inner_gap,
                self.viscosity == 0.0 or 0.0 < self.inner_gap < self.outer_gap,
                f"above 0 and below the outer gap, {self.outer_gap:g}",
            ),
        }
        for key, (value, right, allowed) in wrong.items():
            if not right:
                raise CaseError(f"{key} is {value:g}; it must be {allowed}.")

    @property
    def law(self) -> Law:
        return Law(
            float(self.range),
            math.sqrt(3.0) * damping_ratio(self.restitution),
            float(self.friction),
            float(self.slip_speed),
            float(self.viscosity),
            float(self.outer_gap),
            float(self.inner_gap),
        )


def default_parameters(
    cell: float,
    speed: float,
    mass: np.ndarray,
    weight: np.ndarray,
    restitution: float = 0.5,
    friction: float = 0.0,
    viscosity: float = 0.0,
) -> ContactParameters:
    """s = Δx,  F₀ = max(6mU²/s, 4W),  v₀ = U/100,  h_c = Δx,  h_min = Δx/100.

    Below one cell Δx the grid sees no fluid between surfaces. The work up to touch, F₀s/3, is then
    at least 2mU²: a body of mass m (with its added mass) touches a wall only above twice the
    expected speed U, and an equal one only if both come at U, since the F₀ of a pair relates to
    those of its bodies as the reduced mass does to theirs. At rest under its weight W in the fluid
    a body keeps s(1 − √(W/F₀)) ≥ s/2 from the floor. `mass` and `weight` (n,) of the bodies, inf
    for what is held or moved; `cell` Δx and `speed` U in the case's units.
    CaseError unless cell and speed are above 0.
    """
    for name, value in (("cell", cell), ("speed", speed)):
        if not (value > 0.0 and math.isfinite(value)):
            raise CaseError(f"contact's {name} is {value:g}; it must be finite and above 0.")
    mass, weight = np.broadcast_arrays(np.asarray(mass, float), np.abs(np.asarray(weight, float)))
    return ContactParameters(
        range=cell,
        touch_force=np.maximum(6.0 * mass * speed**2 / cell, 4.0 * weight),
        restitution=restitution,
        friction=friction,
        slip_speed=0.01 * speed,
        viscosity=viscosity,
        outer_gap=cell,
        inner_gap=0.01 * cell,
    )
