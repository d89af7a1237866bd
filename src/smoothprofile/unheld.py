"""What a case leaves free that it should rather hold: a box that speeds up as a whole.

d⟨u⟩/dt = (b V + ΣF)/(ρV + Σm),   F = force + m g,   m = (ρ_p − ρ)V_p of free bodies, V the box's
"""

import numpy as np

from smoothprofile.config import AXES, Case, build_shape

BALANCED = 1e-9
"""Of the loads' own size: a sum this small is round-off."""


def speeding_up(case: Case) -> dict[str, float]:
    """d⟨u⟩/dt along the axes, by name, on which nothing ends up balancing the loads; else empty.

    Walls that the fluid sticks to and bodies that do not move freely take momentum from it.
    """
    fluid, domain = case.fluid, case.domain
    if "wall" in domain.sides.values() or any(p.motion != "free" for p in case.particles):
        return {}
    volume = float(np.prod(domain.lengths))
    total = volume * np.array(fluid.body_force)
    size, mass = np.abs(total), fluid.density * volume
    for particle in case.particles:
        excess = (particle.density - fluid.density) * build_shape(particle).volume
        load = np.array(particle.force) + excess * np.array(fluid.gravity)
        total, size, mass = total + load, size + np.abs(load), mass + excess
    held = fluid.mean_velocity.given()
    return {
        AXES[d]: float(total[d] / mass)
        for d in range(3)
        if domain.periodic[d] and d not in held and abs(total[d]) > BALANCED * size[d]
    }
