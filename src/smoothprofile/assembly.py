"""From a case to the parts that run it: grid, flow, particles, field."""

import math
from functools import partial

import numpy as np

from smoothprofile import rotations
from smoothprofile.config import (
    AXES,
    SPECTRAL,
    Case,
    Domain,
    Electric,
    Faces,
    Focus,
    body_shape,
    start_position,
)
from smoothprofile.contact_scales import field_speed, pressing_force
from smoothprofile.electric.action import ElectricAction, NoField
from smoothprofile.electric.field import Drive, ResolvedField
from smoothprofile.electric.medium import default_thickness, dielectric_medium
from smoothprofile.electric.potential import electrode_field
from smoothprofile.electric.spectral_field import SpectralField
from smoothprofile.flow.advance import Flow, FlowParameters
from smoothprofile.flow.state import FlowState, fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import Axis, Grid, stretched_axis, uniform_axis
from smoothprofile.pairing import surface_offsets
from smoothprofile.particles.bodies import BodyState, Forms, bodies_at
from smoothprofile.particles.contact import Contact, default_parameters
from smoothprofile.particles.dynamics import FreeBodies, FreeMotion
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.particles.loads import Impulse
from smoothprofile.particles.motion import Course, PrescribedMotion
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.particles import Particles, Pull, no_pull
from smoothprofile.profiles import profile_named
from smoothprofile.schemes import scheme_named
from smoothprofile.shapes import touching


def build_grid(domain: Domain) -> Grid:
    """The staggered grid of a [domain] table."""
    dtype = np.float64 if domain.precision == "double" else np.float32
    return Grid(tuple(_axis(domain, d) for d in range(3)), dtype)


def _axis(domain: Domain, d: int) -> Axis:
    stretching, periodic = domain.stretching[d], domain.periodic[d]
    if isinstance(stretching, Faces):
        return Axis(AXES[d], np.array(stretching.faces), periodic)
    arguments = (AXES[d], domain.origin[d], domain.lengths[d], domain.cells[d], periodic)
    if isinstance(stretching, Focus):
        return stretched_axis(*arguments, stretching.focus, stretching.ratio, stretching.core)
    return uniform_axis(*arguments)


def build_flow(case: Case, grid: Grid) -> Flow:
    """The flow solver of a case."""
    fluid, sides = case.fluid, case.domain.sides
    kinds = tuple((sides[f"{name}_low"], sides[f"{name}_high"]) for name in AXES)
    moving = {side: signal.at for side, signal in fluid.wall_velocity.given().items()}
    mean = fluid.mean_velocity.given()
    return Flow(
        grid,
        FlowParameters(
            density=fluid.density,
            viscosity=fluid.viscosity,
            body_force=fluid.body_force,
            mean_velocity=tuple(mean.get(d) for d in range(3)),
            walls=Walls(kinds, moving),
            scheme=scheme_named(case.time.scheme),
            advection=fluid.advection,
        ),
    )


def initial_state(case: Case, flow: Flow) -> FlowState:
    """The fluid at time 0: uniform velocity, zero on the walls' normal faces."""
    state = fluid_at_rest(flow.grid)
    start = list(case.fluid.initial_velocity)
    for axis, value in case.fluid.mean_velocity.given().items():
        start[axis] = value
    for component, value in zip(state.velocity, start, strict=True):
        component[...] = value
    flow.fill(state.velocity, 0.0)
    return state


def build_particles(
    case: Case,
    flow: Flow,
    step: float,
    speed: float = 0.0,
    courses: dict[int, Course] | None = None,
    pull: Pull = no_pull,
) -> Particles:
    """The bodies of a case, painted for that step; courses overrule the motion of some.

    speed: how fast bodies are expected to move, at most. pull: what a field does to them.
    """
    shapes = [body_shape(particle) for particle in case.particles]
    offsets = [
        surface_offsets(case, shape, step, particle.only_turns)
        for shape, particle in zip(shapes, case.particles, strict=True)
    ]
    state = starting_state(case)
    free = free_bodies(case)
    motion = PrescribedMotion(
        state,
        [p.velocity for p in case.particles],
        [p.angular_velocity for p in case.particles],
        courses,
        free=free.rows,
    )
    kind, thickness = (case.profile.kind, case.profile.thickness) if case.profile else ("tanh", 1.0)
    painter = Painter(
        flow.grid, flow.boundaries, Forms.of(shapes, offsets), profile_named(kind), thickness
    )
    density = case.fluid.density
    displaced = DisplacedFluid.of(painter, state)
    solid = [touching(shape) for shape in shapes]
    forms = Forms.of(solid, [np.zeros((len(shape.parts), 2)) for shape in solid])
    contact = build_contact(case, flow.grid, forms, displaced, free, speed)
    walls = flow.parameters.walls
    moving = FreeMotion(free, displaced, density, contact, walls.velocities)
    impulse = Impulse(flow.grid)
    return Particles(state, motion, moving, displaced, painter, impulse, density, pull)


def starting_state(case: Case) -> BodyState:
    """Where the bodies of a case are at time 0, at rest."""
    return bodies_at(
        [start_position(p) for p in case.particles],
        [rotations.normalise(p.quaternion) for p in case.particles],
    )


def build_field(case: Case, grid: Grid) -> ResolvedField | SpectralField:
    """The electric field of a case, not yet solved."""
    electric = case.electric
    shapes = [body_shape(particle) for particle in case.particles]
    values = [particle.permittivity for particle in case.particles]
    drive, ends = drive_at(electric, grid, 0.0), _electrode_axis(electric)
    limits = (electric.tolerance, electric.max_iterations)
    if electric.discretisation == SPECTRAL:
        layer = (profile_named(electric.profile), layer_thickness(electric, grid))
        return SpectralField(
            grid, shapes, values, electric.permittivity, *layer, drive, electric.method, *limits
        )
    medium = dielectric_medium(
        grid,
        shapes,
        values,
        electric.permittivity,
        electric.profile,
        layer_thickness(electric, grid),
        smoothing_of(case),
        electric.retract,
    )
    return ResolvedField(medium, drive, ends, *limits)


def smoothing_of(case: Case) -> str:
    """How the permittivity is smoothed: with "auto", harmonic if spheres alone move, else tensor.

    In narrow gaps the tensor's forces depend on where the grid lies, which bodies that move feel.
    Harmonic ones do not, but they are right for spheres alone. `docs/decisions.md` has numbers.
    """
    if case.electric.smoothing != "auto":
        return case.electric.smoothing
    moving = any(particle.motion != "held" for particle in case.particles)
    round_ones = all(particle.shape == "sphere" for particle in case.particles)
    return "harmonic" if moving and round_ones else "tensor"


def layer_thickness(electric: Electric, grid: Grid) -> float:
    """ξ of the smoothed permittivity."""
    return electric.thickness or default_thickness(grid)


def drive_at(electric: Electric, grid: Grid, time: float) -> Drive:
    """What drives the field at that time."""
    turn = (electric.angular_frequency or 0.0) * time
    wave, quarter = math.cos(turn), math.sin(turn)
    mean = [
        wave * along + quarter * across
        for along, across in zip(electric.field, electric.quadrature, strict=True)
    ]
    ends = electric.electrodes
    if ends is None:
        return Drive(tuple(mean))
    low, high = wave * ends.low, wave * ends.high
    between = electrode_field(grid, AXES.index(ends.axis), low, high)
    field = tuple(given + part for given, part in zip(mean, between, strict=True))
    return Drive(field, 0.5 * (low + high))


def _electrode_axis(electric: Electric) -> int | None:
    return electric.electrodes and AXES.index(electric.electrodes.axis)


def build_action(case: Case, grid: Grid) -> ElectricAction | NoField:
    """What the field of a case does to its bodies."""
    electric = case.electric
    if electric is None or not case.particles:
        return NoField()
    return ElectricAction(
        build_field(case, grid), partial(drive_at, electric, grid), electric.every
    )


def free_bodies(case: Case) -> FreeBodies:
    """Which bodies of a case move freely, and what acts on them."""
    rows = [b for b, particle in enumerate(case.particles) if particle.motion == "free"]
    free = [case.particles[b] for b in rows]
    return FreeBodies(
        rows=np.array(rows, dtype=np.int64),
        density=np.array([p.density for p in free], dtype=np.float64),
        force=np.array([p.force for p in free], dtype=np.float64).reshape(-1, 3),
        torque=np.array([p.torque for p in free], dtype=np.float64).reshape(-1, 3),
        gravity=np.array(case.fluid.gravity),
    )


def build_contact(
    case: Case,
    grid: Grid,
    forms: Forms,
    displaced: DisplacedFluid,
    free: FreeBodies,
    speed: float,
) -> Contact:
    """How the bodies of a case push each other: free ones with half the fluid they displace."""
    density, wanted, count = case.fluid.density, case.contact, displaced.volume.size
    volume, inertia = displaced.volume[free.rows], displaced.inertia[free.rows]
    mass, weight = np.full(count, np.inf), np.full(count, np.inf)
    mass[free.rows] = (free.density + 0.5 * density) * volume
    pull = free.force + ((free.density - density) * volume)[:, None] * free.gravity
    weight[free.rows] = np.linalg.norm(pull, axis=1)
    turning = np.zeros((count, 3, 3))
    turning[free.rows] = np.linalg.inv(free.density[:, None, None] * inertia)
    cell = min(grid.smallest_widths)
    reach = wanted.range or cell
    pressing, fastest = pressing_force(case, reach), field_speed(case, reach)
    weight[free.rows] = np.maximum(weight[free.rows], pressing[free.rows])
    # Where nothing says how fast bodies will be, viscosity does: across a cell in its own time.
    still = case.fluid.viscosity / density / cell
    parameters = default_parameters(
        reach,
        max(speed, float(fastest[free.rows].max(initial=0.0))) or still,
        mass,
        weight,
        wanted.restitution,
        wanted.friction,
        case.fluid.viscosity if wanted.lubrication else 0.0,
    )
    return Contact(forms, grid, 1.0 / mass, turning, parameters)
