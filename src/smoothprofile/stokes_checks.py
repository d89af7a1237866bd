"""What can be said of a case without inertia before it runs: Re, step, layer, memory, time.

A run costs steps × iterations × two direct solves; the first flow takes more iterations, the others
start from the flow before.
"""

import math

import numpy as np

from smoothprofile.config import Case, body_shape
from smoothprofile.config.stokes import TOLERANCE, nothing_moves
from smoothprofile.field_checks import field_rows
from smoothprofile.gap_checks import gap_rows
from smoothprofile.grid import Grid
from smoothprofile.needs import RESOLVED_FIELDS, disk_check, memory_check, time_check
from smoothprofile.numbers import CREEPING, reynolds, scales_of
from smoothprofile.pairing import Pairing, steps_of
from smoothprofile.preflight import (
    FAR_MOVED,
    Check,
    check_row,
    refuse,
    turning_check,
    widest_cell,
)
from smoothprofile.quasistatic import QuasiStaticFlow
from smoothprofile.stokes_assembly import smallest_size, step_bounds
from smoothprofile.threads import thread_count
from smoothprofile.viscous.around import CELLS_TO_XI

FAR = 0.2
"""Of the smallest size that a body may move in a step for errors of a few parts in a thousand."""
FEW_LAYERS = 1.5
STOKES_FIELDS = 22
# Iterations per decade of the tolerance, of the first flow and of those that start from another.
FIRST_ITERATIONS, WARM_ITERATIONS = 2.5, 1.5
# Measured on one core of a 2024 server: an iteration, in seconds for each cell.
SECONDS_PER_ITERATION = 1.5e-7
SECONDS_AT_LEAST = 3e-3


def check_stokes_memory(case: Case) -> None:
    """CaseError if the mesh would not fit, before anything of its size is made."""
    refuse([_memory(case, math.prod(case.domain.cells))])


def stokes_checks(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """Every check of a case with flow = "stokes" but those of its surfaces."""
    found = [_reynolds(case), *_moved(case, grid, pairing), *turning_check(case, pairing)]
    if case.particles:
        found += [*_layer(case, grid), *gap_rows(case)]
    found += field_rows(case, grid, pairing)
    steps = 0 if nothing_moves(case) else steps_of(case, pairing.step)
    disk = disk_check(case, grid, steps)
    return [*found, _memory(case, grid.cell_count), disk, _duration(case, grid, steps)]


def surface_rows(case: Case, flow: QuasiStaticFlow) -> list[Check]:
    """How far each kind of surface is painted from where it is."""
    forms, rows, seen = flow.stokes.bodies.painter.forms, [], set()
    for b, particle in enumerate(case.particles):
        moved, half = float(forms.offset[forms.part_start[b], 0]), particle.thinnest[1]
        if (key := (particle.shape, half, moved)) in seen:
            continue
        seen.add(key)
        verdict = "ok" if abs(moved) < FAR_MOVED * half else "warn"
        note = "painted surface moved outward by this much, so that it acts where it is"
        name = f"surface of {particle.name}"
        rows.append(check_row(name, moved, case.profile.thickness, verdict, note))
    return rows


def _reynolds(case: Case) -> Check:
    found = reynolds(scales_of(case)) or 0.0
    verdict = "ok" if found <= CREEPING else "warn"
    note = "ρUa/μ as announced, which Stokes flow takes for nothing"
    return check_row("Re", found, CREEPING, verdict, note)


def _moved(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """What sets Δt, and how far it takes the fastest body that is announced."""
    if nothing_moves(case):
        return []
    bounds = step_bounds(case, grid)
    least = min(bounds, key=bounds.get)
    rows = [check_row("time step", pairing.step, bounds[least], "ok", f"beside {least}")]
    moved = pairing.step * pairing.speed[0] / smallest_size(case)
    verdict = "ok" if moved <= 2.0 * FAR else "warn"
    note = "what the fastest body may move in a step, over the smallest radius or half side"
    if verdict == "warn":
        note += f"; take a time.step of {2.0 * FAR / moved * pairing.step:.3g} at most"
    return [*rows, check_row("step, farthest moved", moved, 2.0 * FAR, verdict, note)]


def _layer(case: Case, grid: Grid) -> list[Check]:
    profile, rows = case.profile, []
    smallest = min(particle.thinnest[1] for particle in case.particles)
    if math.isfinite(smallest):
        layers = smallest / profile.thickness
        verdict = "ok" if layers >= FEW_LAYERS else "warn"
        note = "smallest radius or half side over ξ; a lone sphere is exact at any"
        rows.append(check_row("a/ξ", layers, FEW_LAYERS, verdict, note))
    least, across = CELLS_TO_XI[profile.kind], profile.thickness / widest_cell(case, grid)
    verdict = "ok" if across >= 0.9 * least else "warn"
    note = f"cells across the {profile.kind} layer; as thin as the grid hardly shows is {least:g}"
    return [*rows, check_row("ξ/Δx", across, least, verdict, note)]


def _memory(case: Case, cells: int) -> Check:
    fields = STOKES_FIELDS + (RESOLVED_FIELDS if case.electric else 0)
    painted = sum(_painted(case, particle) for particle in case.particles)
    points = painted * cells / math.prod(case.domain.lengths)
    # Three components of twelve vectors on the painted points.
    return memory_check(case, cells + int(36 * points / fields), fields)


def _painted(case: Case, particle) -> float:
    """Volume of a body with its layer; of one without end, the box."""
    reach = body_shape(particle).reach + case.profile.thickness
    box = math.prod(case.domain.lengths)
    return min(4.0 / 3.0 * math.pi * reach**3, box) if np.isfinite(reach) else box


def _duration(case: Case, grid: Grid, steps: int) -> Check:
    decades = -math.log10(case.fluid.tolerance or TOLERANCE)
    iterations = decades * (FIRST_ITERATIONS + WARM_ITERATIONS * steps)
    cells = SECONDS_PER_ITERATION * grid.cell_count / thread_count() ** 0.75
    seconds = iterations * (SECONDS_AT_LEAST + cells)
    note = f"{steps + 1} flows, about {iterations:.0f} iterations, a rough estimate"
    return time_check(seconds, note)
