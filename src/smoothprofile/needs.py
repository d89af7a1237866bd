"""What a run needs of memory, disk and time, before it starts.

memory  fields · cells · 8 or 4 bytes      disk  snapshots · 4 bytes · columns · cells
time    steps · (2 ms + cells · .06 μs/threads^¾), estimated from other machines
"""

import math
import os
import shutil
from pathlib import Path

from smoothprofile.config import Case
from smoothprofile.grid import Grid
from smoothprofile.pairing import Pairing, steps_of
from smoothprofile.preflight import Check, check_row, refuse
from smoothprofile.schemes import scheme_named
from smoothprofile.threads import thread_count

# Measured on one core of a 2024 server, in double precision; a step's cost is linear in cells.
SECONDS_PER_CELL = 6e-8
SECONDS_PER_STEP = 2e-3
# The field of some hundred beads of R = 10, solved for anew; that of two takes 1e-7.
FIELD_SECONDS_PER_CELL = 2.5e-7
DAY, YEAR = 86_400.0, 365.25 * 86_400.0
LONGEST = 30.0 * DAY
"""A run that is to take longer than this is rarely meant."""
# State, provisional velocity, advection, δp, and the copies that output makes.
FIELDS_PER_CELL = 19
FIELDS_PER_LEVEL = 6
# ψ and scratch of the iteration, ε on faces and corners, and the copies that output makes.
RESOLVED_FIELDS = 20
COLUMNS = {"velocity": 3, "pressure": 1, "indicator": 1, "potential": 1, "electric_field": 3}


def flow_needs(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """Memory, disk and time of a case with inertia."""
    return [
        memory_check(case, math.prod(grid.padded_shape), _flow_fields(case)),
        disk_check(case, grid, steps_of(case, pairing.step)),
        _duration(case, grid, pairing),
    ]


def check_memory(case: Case) -> None:
    """CaseError if the mesh would not fit, before anything of its size is made."""
    refuse([memory_check(case, math.prod(case.domain.cells), _flow_fields(case))])


def _flow_fields(case: Case) -> int:
    """Fields of the mesh's size that a run of the flow holds."""
    levels = scheme_named(case.time.scheme).levels
    fields = FIELDS_PER_CELL + FIELDS_PER_LEVEL * (levels - 1)
    fields += RESOLVED_FIELDS if case.electric else 0
    return fields + 6 if case.particles else fields


def memory_check(case: Case, cells: int, fields: int) -> Check:
    """Whether that many fields of so many cells fit into the memory that is free."""
    need = cells * fields * (8 if case.domain.precision == "double" else 4)
    free = _free_memory()
    verdict = "ok" if need < free else "refuse"
    note = f"{fields} fields of {cells} cells"
    if verdict == "refuse":
        shown = "×".join(str(n) for n in case.domain.cells)
        note = (
            f"domain.cells is {shown}, which needs about {need / 2**30:.3g} GiB of memory; "
            f"{free / 2**30:.3g} GiB are free."
        )
    return check_row("memory (GiB)", need / 2**30, free / 2**30, verdict, note)


def _free_memory() -> int:
    info = Path("/proc/meminfo")
    if info.is_file():
        for line in info.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def disk_check(case: Case, grid: Grid, steps: int) -> Check:
    """How large fields.h5 may become, beside what is free where runs are written by default."""
    count, columns = _snapshots(case, steps), sum(COLUMNS[name] for name in case.output.fields)
    size, free = count * 4 * grid.cell_count * columns, shutil.disk_usage(Path.cwd()).free
    verdict, note = "ok", f"{_count(count, 'snapshot')}, uncompressed"
    if size > free:
        verdict = "warn"
        note += "; more than is free here: take a longer output.fields_every or fewer output.fields"
    return check_row("disk (GiB)", size / 2**30, free / 2**30, verdict, note)


def _snapshots(case: Case, steps: int) -> int:
    """Those at each multiple of fields_every, and the last; at most one a step and the start."""
    if not case.output.fields:
        return 0
    every = case.output.fields_every
    return min(1 + (math.floor(case.time.end / every) if every else 0), steps + 1)


def _duration(case: Case, grid: Grid, pairing: Pairing) -> Check:
    steps = steps_of(case, pairing.step)
    each = SECONDS_PER_CELL
    if case.electric is not None:
        each += FIELD_SECONDS_PER_CELL / case.electric.every
    cells = each * grid.cell_count / thread_count() ** 0.75
    note = f"{steps} steps at most, a rough estimate for {_count(thread_count(), 'thread')}"
    if case.start:
        note += "; the coarser runs before it are not counted"
    return time_check(steps * (SECONDS_PER_STEP + cells), note)


def time_check(seconds: float, note: str) -> Check:
    """How long a run is to take; a warning above thirty days."""
    if seconds >= YEAR:
        note = f"{seconds / YEAR:.3g} years; {note}"
    elif seconds >= DAY:
        note = f"{seconds / DAY:.3g} days; {note}"
    return check_row("time (s)", seconds, LONGEST, "warn" if seconds > LONGEST else "ok", note)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"
