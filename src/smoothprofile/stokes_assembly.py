"""From a case without inertia to the parts that run it, and the step that it takes.

Δt = min(.1 a/U_b, .4 a/U_f, .1/γ̇, a sixteenth of a field's turn)

U_b is the speed that weights, given forces, the field and prescribed motion give a lone body, U_f
that of walls and mean flow, γ̇ the rate of shear, a the smallest radius or half side.
"""

import math

import numpy as np

from smoothprofile.assembly import free_bodies, starting_state
from smoothprofile.config import AXES, Case, Particle, body_shape, build_shape
from smoothprofile.config.stokes import TOLERANCE
from smoothprofile.contact_scales import field_force, pressing_force
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import Grid
from smoothprofile.numbers import shear_rate
from smoothprofile.pairing import Pairing, turning_step
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.contact import default_parameters
from smoothprofile.particles.contact_creep import CreepingContact
from smoothprofile.particles.creeping import CreepingBodies, FreeLoads
from smoothprofile.particles.motion import Course, PrescribedMotion
from smoothprofile.particles.particles import Pull, no_pull
from smoothprofile.quasistatic import Drive, QuasiStaticFlow
from smoothprofile.shapes import touching
from smoothprofile.viscous.around import stokes_around

BODY_SHARE, FLOW_SHARE, SHEAR_SHARE, TURN_SHARE = 0.1, 0.4, 0.1, 0.9


def stokes_pairing(case: Case, grid: Grid) -> Pairing:
    """The step of a case, and the longest in which no body is expected to move by half its size."""
    size, own, carried = smallest_size(case), _largest(body_speeds(case, grid)), flow_speed(case)
    step = min(step_bounds(case, grid).values()) if case.time.step == "auto" else case.time.step
    fastest = own + carried
    return Pairing(step, 0.5 * size / fastest if fastest else math.inf, (fastest,) * 3)


def step_bounds(case: Case, grid: Grid) -> dict[str, float]:
    """What bounds Δt, in words, and how."""
    size, speeds, carried = smallest_size(case), body_speeds(case, grid), flow_speed(case)
    own, rate = _largest(speeds), shear_rate(case)
    free = own and case.particles[int(np.argmax(speeds))].motion == "free"
    moves = "a body's loads move it" if free else "a body's given motion takes it on"
    return {
        f"a tenth of the time in which {moves} by its size": (
            BODY_SHARE * size / own if own else math.inf
        ),
        "four tenths of the time in which the flow goes by a body's size": (
            FLOW_SHARE * size / carried if carried else math.inf
        ),
        "a tenth of the time of shear": SHEAR_SHARE / rate if rate else math.inf,
        "a sixteenth of a turn of the field": TURN_SHARE * turning_step(case),
        "the end of the run": case.time.end,
    }


def smallest_size(case: Case) -> float:
    """a: the smallest radius or half side; without bodies the shortest side of the box."""
    thin = [p.thinnest[1] for p in case.particles if math.isfinite(p.thinnest[1])]
    return min(thin or case.domain.lengths)


def body_speeds(case: Case, grid: Grid) -> np.ndarray:
    """(n,): |F|/6πμa of free bodies and what a field makes of them; of the others, |V| and |Ω|a."""
    if not case.particles:
        return np.zeros(0)
    drawn, mu = field_force(case, contact_range(case, grid)), case.fluid.viscosity
    speeds = []
    for particle, pull in zip(case.particles, drawn, strict=True):
        if particle.motion == "free":
            pushed = np.linalg.norm(weight_of(case, particle)) + pull
            speeds.append(pushed / (6.0 * math.pi * mu * _radius(particle)))
            continue
        turning = float(np.linalg.norm(particle.angular_velocity.maximum))
        tip = turning * particle.thinnest[1] if turning else 0.0
        speeds.append(float(np.linalg.norm(particle.velocity.maximum)) + tip)
    return np.array(speeds)


def flow_speed(case: Case) -> float:
    """Of walls, mean flow, and what a body force drives between walls, gL²/(8μ)."""
    fluid, domain = case.fluid, case.domain
    speeds = [np.linalg.norm(list(fluid.mean_velocity.given().values()) or [0.0])]
    speeds += [np.linalg.norm(s.maximum) for s in fluid.wall_velocity.given().values()]
    ends = zip(domain.lengths, domain.periodic, strict=True)
    gap = min((length for length, periodic in ends if not periodic), default=0.0)
    driven = np.where(domain.periodic, fluid.body_force, 0.0)
    speeds.append(np.linalg.norm(driven) * gap**2 / (8.0 * fluid.viscosity))
    return _largest(speeds)


def contact_range(case: Case, grid: Grid) -> float:
    """The gap below which bodies push each other: that of the case, or one cell."""
    return case.contact.range or min(grid.smallest_widths)


def build_quasistatic(case: Case, grid: Grid) -> QuasiStaticFlow:
    """The Stokes solver of a case with its bodies' shapes, and what drives it."""
    fluid, sides, profile = case.fluid, case.domain.sides, case.profile
    kinds = tuple((sides[f"{name}_low"], sides[f"{name}_high"]) for name in AXES)
    moving = {side: signal.at for side, signal in fluid.wall_velocity.given().items()}
    shapes = [body_shape(particle) for particle in case.particles]
    stokes = stokes_around(
        grid,
        shapes,
        fluid.viscosity,
        profile=profile.kind if profile else "sine",
        thickness=profile and profile.thickness,
        retract=profile.retract if profile else True,
        walls=kinds,
    )
    given = fluid.mean_velocity.given()
    mean = tuple(given.get(d) if case.domain.periodic[d] else 0.0 for d in range(3))
    drive = Drive(Walls(kinds, moving), fluid.body_force, mean)
    return QuasiStaticFlow(stokes, drive, fluid.tolerance or TOLERANCE)


def build_creeping(
    case: Case,
    flow: QuasiStaticFlow,
    step: float,
    courses: dict[int, Course] | None = None,
    pull: Pull = no_pull,
) -> CreepingBodies:
    """The bodies of a case; courses overrule the motion of some, pull is what a field does."""
    state, free, painter = starting_state(case), free_bodies(case), flow.stokes.bodies.painter
    motion = PrescribedMotion(
        state,
        [p.velocity for p in case.particles],
        [p.angular_velocity for p in case.particles],
        courses,
        free=free.rows,
    )
    loads = FreeLoads.of(free, painter.forms.volume, case.fluid.density)
    contact = _contact(case, flow.grid, step, free.rows)
    velocities = flow.drive.walls.velocities
    return CreepingBodies(state, motion, loads, painter, contact, velocities, pull)


def _contact(case: Case, grid: Grid, step: float, rows: np.ndarray) -> CreepingContact:
    """F₀ = max(4W, 8Fᵉ, 8Fˢ, 24πμaU_f): what presses bodies leaves them half of the range."""
    shapes = [touching(body_shape(particle)) for particle in case.particles]
    forms = Forms.of(shapes, [np.zeros((len(shape.parts), 2)) for shape in shapes])
    reach, mu, count = contact_range(case, grid), case.fluid.viscosity, len(shapes)
    mass, weight = np.full((2, count), np.inf)
    mass[rows] = 0.0
    size = np.array([_radius(case.particles[b]) for b in rows])
    # Where nothing pulls, what would carry a body over its contact's range in a step.
    speed = flow_speed(case) or reach / step
    carried = 6.0 * math.pi * mu * size * speed
    pressing = pressing_force(case, reach)[rows]
    weight[rows] = np.maximum.reduce([_stacked(case, rows, size), pressing, carried])
    wanted = case.contact
    lubricating = mu if wanted.lubrication else 0.0
    parameters = default_parameters(reach, speed, mass, weight, 1.0, wanted.friction, lubricating)
    return CreepingContact(forms, grid, mu, rows, parameters)


def _stacked(case: Case, rows: np.ndarray, size: np.ndarray) -> np.ndarray:
    """W (m,): the weights of a stack from one end of the box to the other, on its lowest body.

    Without walls a stack is pressed only by what differs among weights, from both its ends.
    """
    if not rows.size:
        return np.zeros(0)
    pull = np.array([weight_of(case, case.particles[b]) for b in rows])
    domain, tall = case.domain, 2.0 * size.min()
    walled = [n for n, free in zip(domain.lengths, domain.periodic, strict=True) if not free]
    on_walls = np.linalg.norm(pull, axis=1) * _within(max(walled, default=0.0) / tall, rows.size)
    apart = np.linalg.norm(pull - pull.mean(axis=0), axis=1).max()
    return np.maximum(on_walls, apart * _within(0.5 * max(domain.lengths) / tall, rows.size))


def _within(layers: float, most: int) -> float:
    return max(1.0, min(layers, float(most)))


def weight_of(case: Case, particle: Particle) -> np.ndarray:
    """F + (ρ_p − ρ)Vg (3,) of a free body."""
    excess = (particle.density - case.fluid.density) * build_shape(particle).volume
    return np.array(particle.force) + excess * np.array(case.fluid.gravity)


def _radius(particle: Particle) -> float:
    """Of a sphere with the body's volume."""
    return math.cbrt(0.75 * build_shape(particle).volume / math.pi)


def _largest(values) -> float:
    return float(np.max(values, initial=0.0))
