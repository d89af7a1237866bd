"""What can be said of a case of a field alone before it is solved: resolution, gaps, memory."""

import math

import numpy as np

from smoothprofile.assembly import layer_thickness, starting_state
from smoothprofile.config import AXES, SPECTRAL, Case, build_shape, has_edges
from smoothprofile.electric.medium import widest_cell
from smoothprofile.grid import Grid
from smoothprofile.preflight import Check, check_row, disk_check, memory_check, refuse

FEW_CELLS = 8.0
"""Cells in the smallest radius from which on forces between bodies are right to a few percent."""
LAYERS_THICK = 4.0
"""ξ on each side of a surface within which a tanh layer is not clear fluid."""
# ψ and scratch of the iteration, ε on faces and corners, and the copies that output makes.
FIELDS = 20
SPECTRAL_FIELDS = 22


def field_checks(case: Case, grid: Grid) -> list[Check]:
    """Every check of a case with [electric] alone."""
    found = _resolution(case, grid) if case.particles else []
    found += _edges(case) + _electrodes(case, grid)
    return [*found, _memory(case), disk_check(case, grid, 1)]


def check_field_memory(case: Case) -> None:
    """CaseError if the mesh would not fit, before anything of its size is made."""
    refuse([_memory(case)])


def _memory(case: Case) -> Check:
    spectral = case.electric.discretisation == SPECTRAL
    return memory_check(case, math.prod(case.domain.cells), SPECTRAL_FIELDS if spectral else FIELDS)


def _resolution(case: Case, grid: Grid) -> list[Check]:
    xi = layer_thickness(case.electric, grid)
    cell = widest_cell(grid)
    smallest = min(particle.thinnest[1] for particle in case.particles)
    rows = []
    if math.isfinite(smallest):
        cells = smallest / cell
        verdict = "ok" if cells >= FEW_CELLS else "warn"
        note = "smallest radius or half side in cells; forces take about 16 for 2 %"
        rows.append(check_row("a/Δx", cells, FEW_CELLS, verdict, note))
        if xi > 0.8 * smallest:
            allowed = f"{smallest:g}, the smallest radius or half side, takes a layer of .8 of it"
            given = "" if case.electric.thickness else ", .75 of the widest cell"
            note = f"electric.thickness is {xi:g}{given}; {allowed} at most: take smaller cells."
            rows.append(check_row("ξ/a", xi / smallest, 0.8, "refuse", note))
    verdict = "ok" if xi >= 0.5 * cell else "warn"
    note = f"the {case.electric.profile} layer of permittivity; .75 is the default"
    rows.append(check_row("ξ/Δx, permittivity", xi / cell, 0.75, verdict, note))
    contrast = max(p.permittivity for p in case.particles) / case.electric.permittivity
    note = "largest permittivity of a body over that of the fluid"
    return [*rows, check_row("permittivity ratio", contrast, None, "ok", note)]


def _edges(case: Case) -> list[Check]:
    """Bodies whose torque by virtual work is not to be trusted."""
    edged = [particle.name for particle in case.particles if has_edges(particle)]
    if not edged:
        return []
    note = (
        f"bodies with edges, such as {edged[0]}: take force and torque of the Maxwell stress, "
        "for those by virtual work are not usable"
    )
    return [check_row("bodies with edges", len(edged), 0, "warn", note)]


def _electrodes(case: Case, grid: Grid) -> list[Check]:
    """How near bodies come to electrodes, where the layer would be cut by the wall."""
    ends = case.electric.electrodes
    bounded = [b for b, particle in enumerate(case.particles) if particle.bounded]
    if ends is None or not bounded:
        return []
    axis = grid.axes[AXES.index(ends.axis)]
    state = starting_state(case)
    nearest = np.inf
    for b in bounded:
        half = build_shape(case.particles[b]).reach
        along = state.position[b, AXES.index(ends.axis)] - axis.low
        nearest = min(nearest, along - half, axis.length - along - half)
    layer = LAYERS_THICK * layer_thickness(case.electric, grid)
    verdict = "ok" if nearest >= layer else "warn"
    note = "smallest gap between a body and an electrode, over the layer's reach"
    if verdict == "warn":
        note += "; a body that touches one has its layer cut, and its force is less exact"
    return [check_row("electrode gap", float(nearest), layer, verdict, note)]
