"""The stress on walls that slide past each other, and what bears it between them.

    τ = ½(τ_low + τ_high) = μγ̇ + ΣD/V − Σz·Fᶜ/V − Σz·Fᵉ/V + inertia

z is the height of a body above the middle between the walls, Fᶜ and Fᵉ along the slide what contact
and the field do to it, the walls being bodies at z = ±L/2 that rub on others; and D = ∮z'σ·n dS,
z' from the body's own height: of the tractions of the fluid the stresslet and half the torque
across. For a pair −Σz·F is −(z_i − z_j)F_ij (Batchelor, J. Fluid Mech. 83, 1977). On equipotential
walls the Maxwell stress bears no shear, so that −Σz·Fᵉ/V is its mean over the whole box, but for
what the field's torque adds; on spheres it exerts none.

It is the balance of ∫ρz u dV, exact on the grid for bodies that are free of other loads. What is
left out, as inertia, is its rate of change in the fluid outside of bodies and −ρ⟨u'w'⟩; gravity,
given forces and held bodies would add terms of their own. The contact part has the lubrication
that `contact.lubrication` adds.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from smoothprofile.grid import AXIS_NAMES


@dataclass(frozen=True, eq=False)
class Slide:
    """Walls across `axis` slide past each other along `direction` (3,), at ΔU over a height L."""

    axis: int
    direction: np.ndarray
    speed: float
    height: float

    @property
    def rate(self) -> float:
        """γ̇ = ΔU/L."""
        return self.speed / self.height


def slide_of(simulation: Any) -> Slide | None:
    """None unless one axis alone has walls, both no-slip, and they slide past each other."""
    grid, walls = simulation.grid, simulation.walls
    walled = [d for d in range(3) if not grid.axes[d].periodic]
    if len(walled) != 1 or walls.kinds[walled[0]] != ("wall", "wall"):
        return None
    (axis,) = walled
    low, high = walls.velocities(simulation.time)[axis]
    speed = float(np.linalg.norm(high - low))
    if not speed:
        return None
    return Slide(axis, (high - low) / speed, speed, grid.axes[axis].length)


def stress_on_walls(simulation: Any, slide: Slide) -> float:
    """τ: the mean of the shear stresses on both walls, of the fluid and of what rubs on them."""
    forces, name = simulation.wall_force, AXIS_NAMES[slide.axis]
    drag = 0.5 * (forces[f"{name}_low"] - forces[f"{name}_high"]) @ slide.direction
    return float(drag * slide.height / simulation.grid.volume) + _rubbing(simulation, slide)


def _rubbing(simulation: Any, slide: Slide) -> float:
    """½(F_low − F_high)L/V of the friction of bodies on the walls in the last step."""
    low, high = simulation.bodies.free.wall_impulse[slide.axis] / simulation.time_step
    return float(0.5 * (low - high) @ slide.direction * slide.height / simulation.grid.volume)


def apparent_viscosity(simulation: Any) -> float | None:
    """μ_app = τ/γ̇; None where no walls slide past each other."""
    slide = slide_of(simulation)
    return None if slide is None else stress_on_walls(simulation, slide) / slide.rate


def history_row(simulation: Any) -> dict[str, float]:
    """τ and its viscous, contact and electric parts; nothing but in shear with free bodies."""
    rows, slide = simulation.bodies.free.rows, slide_of(simulation)
    if slide is None or not rows.size:
        return {}
    return {"wall_stress": stress_on_walls(simulation, slide), **_parts(simulation, slide)}


def _parts(simulation: Any, slide: Slide) -> dict[str, float]:
    bodies, volume = simulation.bodies, simulation.grid.volume
    state, rows = bodies.state, bodies.free.rows
    normal, along = np.eye(3)[slide.axis], slide.direction
    middle = simulation.grid.axes[slide.axis].low + 0.5 * slide.height
    height = state.position[rows, slide.axis] - middle
    bounded = np.isfinite(bodies.painter.forms.volume)
    moments = bodies.stresslets()[bounded] @ along @ normal
    moments = moments + 0.5 * state.torque[bounded] @ np.cross(normal, along)
    contact = np.zeros((rows.size, 3))
    if bodies.free.contact_impulses:
        contact = bodies.free.contact_impulses[0][:, :3] / simulation.time_step
    field = bodies.free.pulls[0][:, :3]
    return {
        "viscous_stress": float(
            simulation.case.fluid.viscosity * slide.rate + moments.sum() / volume
        ),
        "contact_stress": float(_rubbing(simulation, slide) - (height @ contact @ along) / volume),
        "electric_stress": float(-(height @ field @ along) / volume),
    }
