"""What one step does to the momentum and to the kinetic energy of the fluid, and what is left over.

    d(ρ∫u)/dt = fV − ΣF_walls + ΣB                  d/dt the derivative of the scheme
    d(½ρ∫u²)/dt = f·∫u + W + Σ(V·B + Ω·L) − D − D_b

f drives the fluid, by volume; B and L are force and torque of each body on the fluid, inside it
too; W is the work of the walls, D what viscosity takes (`flow/energy.py`), and

    D_b = Σ(V·B + Ω·L) − ∫ū·(b − (θνΔt/γ)∇²b) dV,   b = (ργ/Δt)φ(u_p − uˢ)

what the impulse takes in the bodies' layers, where fluid slips through them; the term with ∇²b is
there because viscosity acts on uˢ, which is bΔt/ργ away from uⁿ⁺¹. Momentum closes to
round-off. What is left of the energy is what time stepping and advection gain or lose; it vanishes
at a steady state, but for what central advection does not keep.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.flow.energy import kinetic_sums
from smoothprofile.schemes import Scheme

NEARLY = 2.0
"""Times the tolerance of the steady state: closer than that, each step may be the last."""


ROUND_OFF = 100.0
"""Of the sums over all cells, in units of the last digit."""


@dataclass(frozen=True)
class Budget:
    """Of one step, each in the case's units of power, but for the shares.

    gain        d(½ρ∫u²)/dt
    drive, walls, bodies     work of what drives the fluid, of walls, of bodies, each second
    viscous, layers          D and D_b
    energy      |what is left| over the sum of all sizes
    momentum    the same of the momentum, as vectors
    """

    gain: float
    drive: float
    walls: float
    bodies: float
    viscous: float
    layers: float
    energy: float
    momentum: float

    def saved(self) -> dict[str, float]:
        """For a checkpoint."""
        return asdict(self)


def take_with_budget(run: Any, step_once: Callable[[], None]) -> Budget | None:
    """Take one step; its budget if it may be the last of the run, else the last one known."""
    if ends_soon(run):
        return step_with_budget(run, step_once)
    step_once()
    return run.budget


def ends_soon(run: Any) -> bool:
    """Whether the next step may be the last of a run; then its budget is worth its cost."""
    rules, steps = run.case.time, run.steps + 1
    last = run.time + run.time_step >= rules.end * (1.0 - 1e-12)
    settled = run.extremes.rate(run.time_step) < NEARLY * (rules.steady_tolerance or 0.0)
    return last or (settled and steps > 1) or steps == rules.max_steps


def step_with_budget(run: Any, step_once: Callable[[], None]) -> Budget:
    """Take one step by `step_once`, and what it did."""
    old, before = run.state.velocity, run.state.time
    scheme = run.flow.scheme(run.state)
    momenta = [_mean(run, level) for level in (old, *run.state.past_velocity)]
    force: list[np.ndarray] = []
    impose = run.bodies.impose

    def watched(velocity: tuple, scheme: Any, dt: float) -> None:
        force.extend(-field for field in velocity)
        impose(velocity, scheme, dt)
        for kept, field in zip(force, velocity, strict=True):
            kept += field

    if run.bodies.state.count:
        run.bodies.impose = watched
    try:
        step_once()
    finally:
        run.bodies.impose = impose
    dt = run.state.time - before
    momenta.insert(0, _mean(run, run.state.velocity))
    weights = (scheme.gamma, *(-past for past in scheme.past))
    volume, density = run.grid.volume, run.case.fluid.density
    gain = sum(w * m for w, m in zip(weights, momenta, strict=False)) * density * volume / dt
    for kept, boundary in zip(force, run.flow.boundaries, strict=False):
        kept *= density * scheme.gamma / dt
        fill_ghosts(kept, boundary, ((0.0, 0.0),) * 3)
    return _budget(run, old, tuple(force) or None, scheme, dt, gain)


def _budget(run: Any, old: tuple, force: tuple | None, scheme: Scheme, dt: float, gain) -> Budget:
    density, viscosity = run.case.fluid.density, run.case.fluid.viscosity
    sums = kinetic_sums(run.grid, old, run.state.velocity, force)
    bent = scheme.implicit * viscosity / density * dt / scheme.gamma * sums.bent
    driven, walls = run.driving_force * run.grid.volume, run.wall_force["total"]
    mean = 0.5 * (_mean(run, old) + _mean(run, run.state.velocity))
    given, work = np.zeros(3), 0.0
    if force is not None:
        push, twist = run.bodies.given()
        motion = run.bodies.state
        given = push.sum(axis=0)
        work = float((push * motion.velocity + twist * motion.angular_velocity).sum())
    powers = {
        "gain": density * sums.gain / dt,
        "drive": float(driven @ mean),
        "walls": viscosity * sums.walls,
        "bodies": work,
        "viscous": viscosity * sums.dissipation,
        "layers": work - sums.given + bent,
    }
    taken = powers["gain"] + powers["viscous"] + powers["layers"]
    left = powers["drive"] + powers["walls"] + powers["bodies"] - taken
    each = [force for name, force in run.wall_force.items() if name != "total"]
    sizes = sum(float(np.linalg.norm(part)) for part in (driven, *each, given, gain))
    lost = float(np.linalg.norm(driven - walls + given - gain))
    # Of a flow without any net force there is round-off alone, which is no share of anything; in
    # one at rest, of what drives it.
    least = ROUND_OFF * float(np.finfo(run.grid.dtype).eps)
    speed = max(*run.extremes.speed, float(np.abs(run.driving_force).max()) * dt / density)
    noise = least * density * run.grid.volume * speed / dt
    return Budget(
        **powers,
        energy=_share(abs(left), sum(map(abs, powers.values())), noise * speed),
        momentum=_share(lost, sizes, noise),
    )


def _share(left: float, size: float, noise: float) -> float:
    return left / size if left > noise else 0.0


def _mean(run: Any, velocity: tuple) -> np.ndarray:
    """(3,) mean velocity over the box."""
    return np.array([run.flow.mean_flow.plain_mean(field, c) for c, field in enumerate(velocity)])
