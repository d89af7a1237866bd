"""The smoothed profile method: the only place where flow and particles meet.

predict                (γuˢ − Σα_q uⁿ⁻q)/Δt + N = ν∇²uˢ − ∇pⁿ + g
settle                 (V, Ω)ⁿ⁺¹ of free bodies, such that they lose what the impulse gives
impose rigid motion    u** = uˢ + φ(u_p − uˢ)
project                ∇²δp = (γ/Δt)∇·u**,   uⁿ⁺¹ = u** − (Δt/γ)∇δp,   pⁿ⁺¹ = pⁿ + δp
"""

from collections.abc import Callable

from smoothprofile.errors import CaseError
from smoothprofile.flow.advance import Flow, Step
from smoothprofile.flow.state import FlowState
from smoothprofile.particles.particles import Particles

Coupling = Callable[[Flow, Particles, FlowState, float], None]
# A round leaves a third of what flows through a sphere, and two thirds through a disc.
START_ROUNDS = 10


def incremental(flow: Flow, particles: Particles, state: FlowState, dt: float) -> None:
    """One step with the old pressure in the predictor and one projection, after the impulse.

    At steady state δp = 0, so that the velocity inside a held body is exactly its own.
    """
    move_and_paint(flow, particles, state, dt)
    step = flow.predict(state, dt)
    settle(flow, particles, step)
    particles.impose(step.velocity, step.scheme, dt)
    flow.project(state, step)
    flow.finish(state, step)


def thesis(flow: Flow, particles: Particles, state: FlowState, dt: float) -> None:
    """One step as the thesis' (2.6)–(2.12): no old pressure, p* before the impulse, q after it.

    The velocity inside keeps the leak Δt∇q of the second projection.
    """
    move_and_paint(flow, particles, state, dt)
    step = flow.predict(state, dt, pressure_weight=0.0)
    state.pressure[...] = 0.0
    flow.project(state, step)
    settle(flow, particles, step)
    particles.impose(step.velocity, step.scheme, dt)
    flow.project(state, step)
    flow.finish(state, step)


def set_out(flow: Flow, particles: Particles, state: FlowState) -> None:
    """u⁰ such that hardly any fluid flows through a body: u ← P[u + φ(u_p − u)], a few times.

    A free body starts at its velocity only if the fluid around and inside it does.
    """
    if not particles.free.rows.size:
        return
    for _ in range(START_ROUNDS):
        if particles.carry(state.velocity) == 0.0:
            return
        for axis, target in flow.mean_flow.targets.items():
            velocity = state.velocity[axis]
            velocity += velocity.dtype.type(target - flow.mean_flow.plain_mean(velocity, axis))
        flow.fill(state.velocity, state.time)
        flow.projection.make_divergence_free(state.velocity)
        flow.fill(state.velocity, state.time)


COUPLINGS: dict[str, Coupling] = {"incremental": incremental, "thesis": thesis}


def coupling_named(name: str) -> Coupling:
    """The coupling of that name; CaseError with the list of names otherwise."""
    if name not in COUPLINGS:
        raise CaseError(f"time.coupling is {name!r}; it must be one of {', '.join(COUPLINGS)}.")
    return COUPLINGS[name]


def move_and_paint(flow: Flow, particles: Particles, state: FlowState, dt: float) -> None:
    """Bodies to their places at the end of the step, what acts on them there, and φ with them."""
    particles.move(state.time + dt, state.time, flow.parameters.scheme.levels)
    particles.feel(state.time + dt)
    particles.paint()


def settle(flow: Flow, particles: Particles, step: Step) -> None:
    """Free bodies find their velocities, and the mean is held that the impulse will leave."""

    def mean(field, axis, is_velocity):
        plain = flow.mean_flow.plain_mean(field, axis, is_velocity)
        return plain + particles.added_mean(field, axis, is_velocity)

    particles.settle(step.velocity, step.scheme, step.dt)
    flow.hold_mean(step, mean)
    if flow.mean_flow.targets:
        particles.settle_with(flow.mean_flow.force)
