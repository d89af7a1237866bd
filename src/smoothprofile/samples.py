"""What a run leaves at its end besides its fields: cuts through them, and pairs of beads.

lines.csv       velocity along the lines, and shear along the wall line
plane.npz       the fields in one plane
structure.csv   pairs of beads by distance, if a field moves them
"""

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from smoothprofile import structure
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.safefiles import replacing, write_text, writing


def write_cuts(directory: Path, simulation: Any) -> None:
    """Write them all; OutputError if one cannot be written."""
    write_text(directory / "lines.csv", _lines(simulation))
    plane = simulation.case.output.plane
    across = simulation.grid.axes[AXIS_NAMES.index(plane.axis)]
    at = across.low + 0.5 * across.length if plane.at is None else plane.at
    sample = simulation.sample_plane(plane.axis, at)
    with replacing(directory / "plane.npz") as file:
        np.savez_compressed(file, axis=plane.axis, at=at, **sample)
    with writing(directory / structure.TABLE):
        structure.write_pairs(directory / structure.TABLE, simulation)


def _lines(simulation: Any) -> str:
    output = simulation.case.output
    lines = [
        ("velocity", line.name, simulation.sample_line(line.axis, line.through, line.component))
        for line in output.lines or ()
    ]
    if output.wall_line is not None:
        wall = output.wall_line
        sample = simulation.wall_shear(wall.wall, wall.component, wall.along, wall.at)
        lines.append(("wall_shear", wall.wall, sample))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if lines:
        writer.writerow(("quantity", "name", "coordinate", "value"))
    for quantity, name, (coordinates, values) in lines:
        columns = (coordinates.tolist(), np.asarray(values).tolist())
        writer.writerows((quantity, name, *pair) for pair in zip(*columns, strict=True))
    return text.getvalue()
