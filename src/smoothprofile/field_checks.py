"""What can be said of a field before it is solved: resolution, smoothing, gaps, memory."""

import math
from dataclasses import replace

import numpy as np

from smoothprofile import rotations
from smoothprofile.assembly import layer_thickness, smoothing_of, starting_state
from smoothprofile.config import AXES, SPECTRAL, Case, body_shape, has_edges
from smoothprofile.contact_scales import field_speed
from smoothprofile.electric.medium import widest_cell
from smoothprofile.gap_checks import gap_rows
from smoothprofile.grid import Grid
from smoothprofile.needs import RESOLVED_FIELDS, disk_check, flow_needs, memory_check
from smoothprofile.pairing import Pairing
from smoothprofile.preflight import Check, check_row, checks, refuse
from smoothprofile.shapes import Shape

FEW_CELLS = 8.0
"""Cells in the smallest radius from which on forces between bodies are right to a few percent."""
FAR_DRAWN = 0.2
"""Of its radius that a bead may be drawn to another in a step: at .3 chains were seen to burst."""
LAYERS_THICK = 4.0
"""ξ on each side of a surface within which a tanh layer is not clear fluid."""
SPECTRAL_FIELDS = 22


def field_checks(case: Case, grid: Grid) -> list[Check]:
    """Every check of a case with [electric] alone."""
    found = _resolution(case, grid) if case.particles else []
    found += _edges(case) + _electrodes(case, grid)
    return [*found, _memory(case), disk_check(case, grid, 0)]


def flow_checks(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """Every check of a case with [fluid], those of its field among them if it has one."""
    rows = [*checks(case, grid, pairing), *gap_rows(case), *field_rows(case, grid, pairing)]
    return [*rows, *flow_needs(case, grid, pairing)]


def field_rows(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """The checks that its field adds to a case with [fluid], if it has one."""
    if case.electric is None or not case.particles:
        return []
    found = [*_resolution(case, grid), *_edges(case), *_electrodes(case, grid)]
    return found + _closing(case, grid, pairing)


def check_field_memory(case: Case) -> None:
    """CaseError if the mesh would not fit, before anything of its size is made."""
    refuse([_memory(case)])


def _memory(case: Case) -> Check:
    spectral = case.electric.discretisation == SPECTRAL
    return memory_check(
        case, math.prod(case.domain.cells), SPECTRAL_FIELDS if spectral else RESOLVED_FIELDS
    )


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
            given = case.electric.thickness
            taken = "" if given else " if left out, .75 of the widest cell"
            advice = "take less" if given else "take smaller cells"
            note = f"electric.thickness is {xi:g}{taken}; {allowed} at most: {advice}."
            rows.append(check_row("ξ/a", xi / smallest, 0.8, "refuse", note))
    verdict = "ok" if xi >= 0.5 * cell else "warn"
    note = f"the {case.electric.profile} layer of permittivity; .75 is the default"
    rows.append(check_row("ξ/Δx, permittivity", xi / cell, 0.75, verdict, note))
    ratios = [p.permittivity / case.electric.permittivity for p in case.particles]
    differs = max(ratios, key=lambda ratio: abs(math.log(ratio)))
    note = "permittivity of the bodies over that of the fluid"
    if min(ratios) < max(ratios):
        note += f", from {min(ratios):.4g} to {max(ratios):.4g}; of the one that differs most"
    rows.append(check_row("permittivity ratio", differs, None, "ok", note))
    return [*rows, check_row("smoothing", smoothing_of(case), None, "ok", smoothing_note(case))]


def smoothing_note(case: Case) -> str:
    """Why the permittivity is smoothed as it is."""
    if case.electric.smoothing != "auto":
        return "electric.smoothing, as the case says"
    if smoothing_of(case) == "harmonic":
        return 'electric.smoothing = "auto": spheres that move, whose forces must not jitter'
    return 'electric.smoothing = "auto": the most accurate away from narrow gaps'


def _closing(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """How far a step takes bodies that the field draws together, of their size."""
    free = [b for b, particle in enumerate(case.particles) if particle.motion == "free"]
    if not free:
        return []
    cell = min(grid.smallest_widths)
    speed = field_speed(case, case.contact.range or cell)[free]
    size = np.array([case.particles[b].thinnest[1] for b in free])
    moved = float(np.max(pairing.step * speed / size))
    verdict = "ok" if moved <= FAR_DRAWN else "warn"
    note = "what a near pair closes by in a step, over the smallest radius"
    if verdict == "warn":
        allowed = f"take a time.step of {FAR_DRAWN / moved * pairing.step:.3g} at most"
        note += f"; its force changes much on the way: {allowed}"
    return [check_row("step, near pair", moved, FAR_DRAWN, verdict, note)]


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
    d = AXES.index(ends.axis)
    axis, state = grid.axes[d], starting_state(case)
    nearest = np.inf
    for b in bounded:
        place = state.position[b, d]
        low, high = _ends_along(body_shape(case.particles[b]), state.quaternion[b], d)
        nearest = min(nearest, place + low - axis.low, axis.high - place - high)
    layer = LAYERS_THICK * layer_thickness(case.electric, grid)
    verdict = "ok" if nearest >= layer else "warn"
    note = "smallest gap between a body and an electrode, over the layer's reach"
    if verdict == "warn":
        note += "; a body that touches one has its layer cut, and its force is less exact"
    return [check_row("electrode gap", float(nearest), layer, verdict, note)]


def _ends_along(shape: Shape, quaternion: np.ndarray, axis: int) -> tuple[float, float]:
    """Least and greatest coordinate of a body along an axis of the box, from its position."""
    ends = []
    for part in shape.parts:
        turned = replace(part, quaternion=rotations.multiply(quaternion, part.quaternion))
        place = rotations.rotate(quaternion, part.position)[axis]
        ends += [place + corner[axis] for corner in turned.box]
    return min(ends), max(ends)
