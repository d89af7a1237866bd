"""Bodies that a case asks for by the dozen: lattices, random packings, CSV files.

They are replaced by one table each before the case is checked, so that a case as loaded needs
neither the file nor the seed. Paths of files become whole paths on the way.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError

from smoothprofile.config.domain import Domain
from smoothprofile.config.files import located, read_bodies
from smoothprofile.config.particle import SOURCE_KEYS, Particle, build_shape
from smoothprofile.config.radii import read_radii
from smoothprofile.config.randomly import MOST_BODIES, place_randomly
from smoothprofile.config.refusals import Refusal, explain
from smoothprofile.config.tables import Lattice, RandomPacking
from smoothprofile.config.values import AXES
from smoothprofile.errors import CaseError
from smoothprofile.packing import BASES, lattice
from smoothprofile.triangles import SurfaceError, digest_of

NINE_DIGITS = 1e-9
"""Spacings are typed or computed: nine digits are enough to fill the domain."""
KEY = re.compile(r"\bparticles\.(\d+)")


class Origins:
    """Where the bodies of an expanded case come from, to name them in sentences."""

    def __init__(self, labels: list[str]):
        self.labels = labels

    def told(self, text: str) -> str:
        """The sentence with bodies called by their places in the file."""
        return KEY.sub(self._label, text)

    def _label(self, match: re.Match) -> str:
        number = int(match[1])
        return self.labels[number] if number < len(self.labels) else match[0]


def expanded(data: dict[str, Any], folder: Path) -> tuple[dict[str, Any], Origins | None]:
    """The case with each source replaced by its bodies, and where these come from.

    `data` as parsed, `folder` that of the case file. CaseError for sources that cannot be read.
    """
    entries = data.get("particles")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        return data, None
    entries = [_with_whole_path(entry, folder, k) for k, entry in enumerate(entries)]
    data = {**data, "particles": entries}
    if not any(key in entry for entry in entries for key in SOURCE_KEYS):
        return data, None
    domain = checked(Domain, data.get("domain", {}), "domain")
    groups: list[Any] = [None] * len(entries)
    later = []
    for k, entry in enumerate(entries):
        kind = _source_of(entry, k)
        if kind is None:
            groups[k] = [(entry, f"particles.{k}")]
        elif kind == "random":
            later.append(k)
        else:
            read = _from_lattice if kind == "lattice" else _from_csv
            groups[k] = _named(read(entry, k, domain, folder), entry)
    for k in later:
        standing = [body for group in groups if group for body in group]
        groups[k] = _named(_from_random(entries[k], k, domain, standing), entries[k])
    bodies = [body for group in groups for body in group]
    if len(bodies) > MOST_BODIES:
        raise Refusal("particles", len(bodies), f"a case has {MOST_BODIES} bodies at most")
    return {**data, "particles": [body for body, _ in bodies]}, Origins([at for _, at in bodies])


def checked(model: type[BaseModel], value: Any, key: str) -> Any:
    """The value as a table; CaseError with the dotted key if it is none."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise CaseError(explain(error, value, model, key)) from None


def _with_whole_path(entry: dict, folder: Path, k: int) -> dict:
    if entry.get("shape") != "mesh" or "file" not in entry:
        return entry
    key = f"particles.{k}.file"
    path = located(entry["file"], folder, key)
    try:
        return {"digest": digest_of(path), **entry, "file": str(path)}
    except SurfaceError as error:
        raise Refusal(key, entry["file"], f"{error}; looked for {path}") from None


def _source_of(entry: dict, k: int) -> str | None:
    """The key of its source; None for a single body."""
    given = [key for key in SOURCE_KEYS if key in entry]
    if not given:
        return None
    for other in (*given[1:], *(["position"] if "position" in entry else [])):
        allowed = f"{given[0]} already says where the bodies are"
        raise Refusal(f"particles.{k}.{other}", entry[other], allowed)
    return given[0]


def _template(entry: dict, k: int, domain: Domain, radius: float | None) -> dict:
    """What all bodies of a source share, checked; `radius` is an example of theirs."""
    shared = {key: value for key, value in entry.items() if key not in SOURCE_KEYS}
    example = {**shared, "position": list(domain.origin)}
    if radius is not None:
        example["radius"] = radius
    checked(Particle, example, f"particles.{k}")
    return shared


def _named(bodies: list[tuple[dict, str]], entry: dict) -> list[tuple[dict, str]]:
    """Each body with the source's name and its number among its bodies, from 0."""
    name = entry.get("name")
    if name is None:
        return bodies
    return [({**body, "name": f"{name} {i}"}, at) for i, (body, at) in enumerate(bodies)]


def _from_lattice(entry: dict, k: int, domain: Domain, _: Path) -> list[tuple[dict, str]]:
    table = checked(Lattice, entry["lattice"], f"particles.{k}.lattice")
    radii = read_radii(entry, k)
    shared = _template(entry, k, domain, radii and radii.example)
    lengths = np.array(domain.lengths)
    counts, spacing = _unit_cells(table, lengths)
    for axis in np.flatnonzero(counts < 1):
        allowed = f"it must fit the domain, {lengths[axis]:g} long along {AXES[axis]}"
        raise Refusal(f"particles.{k}.lattice.spacing", table.spacing, allowed)
    number = math.prod(int(count) for count in counts) * len(BASES[table.kind])
    if number > MOST_BODIES:
        allowed = f"these are {number} bodies, and a case has {MOST_BODIES} at most"
        raise Refusal(f"particles.{k}.lattice.counts", counts.tolist(), allowed)
    origin = table.origin
    if origin is None:
        basis = np.array(BASES[table.kind])
        extent = (counts - 1 + basis.max(axis=0)) * spacing
        origin = np.array(domain.origin) + 0.5 * (lengths - extent)
    points = lattice(table.kind, counts, spacing, origin)
    sizes = radii.draw(number, np.random.default_rng(0)) if radii else None
    return [
        (_at(shared, point, sizes, i), f"particles.{k} (point {i})")
        for i, point in enumerate(points)
    ]


def _unit_cells(table: Lattice, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many unit cells along each axis, and their sides."""
    spacing = table.spacing and np.array(table.spacing)
    if table.counts is None:
        return np.floor(lengths / spacing * (1.0 + NINE_DIGITS)).astype(int), spacing
    counts = np.array(table.counts)
    return counts, lengths / counts if spacing is None else spacing


def unfilled(data: dict[str, Any]) -> list[tuple[str, int, float, float]]:
    """(key, axis, extent, period) where the unit cells of a lattice do not fill a periodic axis.

    A lattice one cell thick by `counts` is a layer on purpose. `data` of a case without faults.
    """
    found = []
    for k, entry in enumerate(data.get("particles", ())):
        if "lattice" not in entry:
            continue
        domain = checked(Domain, data["domain"], "domain")
        table = checked(Lattice, entry["lattice"], f"particles.{k}.lattice")
        counts, spacing = _unit_cells(table, np.array(domain.lengths))
        for axis in np.flatnonzero(domain.periodic):
            block, length = float(counts[axis] * spacing[axis]), domain.lengths[axis]
            layer = table.counts is not None and counts[axis] == 1
            if not layer and abs(block - length) > NINE_DIGITS * length:
                found.append((f"particles.{k}.lattice", int(axis), block, length))
    return found


def _at(shared: dict, point: np.ndarray, sizes: np.ndarray | None, i: int) -> dict:
    body = {**shared, "position": point.tolist()}
    if sizes is not None:
        body["radius"] = float(sizes[i])
    return body


def _from_csv(entry: dict, k: int, domain: Domain, folder: Path) -> list[tuple[dict, str]]:
    key, name = f"particles.{k}.csv", entry["csv"]
    path = located(name, folder, key)
    rows = read_bodies(path, name)
    if len(rows) > MOST_BODIES:
        raise Refusal(key, name, f"it has {len(rows)} bodies, and a case {MOST_BODIES} at most")
    given = {key for key in rows[0].values if key not in ("position",)}
    for both in sorted(given & entry.keys()):
        allowed = f"{name} has columns for it"
        raise Refusal(f"particles.{k}.{both}", entry[both], allowed)
    radii = read_radii(entry, k) if "radius" in entry else None
    sizes = radii.draw(len(rows), np.random.default_rng(0)) if radii else None
    first = {key: value for key, value in _body(rows[0].values).items() if key != "position"}
    shared = {key: value for key, value in entry.items() if key not in SOURCE_KEYS}
    _template({**entry, **first}, k, domain, radii and radii.example)
    bodies = []
    for i, row in enumerate(rows):
        body = {**shared, **_body(row.values)}
        if sizes is not None:
            body["radius"] = float(sizes[i])
        bodies.append((body, f"particles.{k} ({name} line {row.line})"))
    return bodies


def _body(values: Mapping[str, Any]) -> dict:
    """The keys of a body from those of a row: the quaternion becomes a turn about an axis."""
    body = dict(values)
    if "orientation" in body:
        body["orientation"] = turn_of(np.array(body["orientation"]))
    return body


def turn_of(quaternion: np.ndarray) -> dict:
    """{ axis, angle } of a quaternion (4,), w first, of any length; the angle in degrees."""
    w, *v = quaternion / np.linalg.norm(quaternion)
    sine = float(np.linalg.norm(v))
    if sine == 0.0:
        return {"axis": [0.0, 0.0, 1.0], "angle": 0.0}
    return {"axis": [float(c) / sine for c in v], "angle": math.degrees(2 * math.atan2(sine, w))}


def _from_random(
    entry: dict, k: int, domain: Domain, standing: list[tuple[dict, str]]
) -> list[tuple[dict, str]]:
    key = f"particles.{k}"
    table = checked(RandomPacking, entry["random"], f"{key}.random")
    radii = read_radii(entry, k)
    shared = _template(entry, k, domain, radii and radii.example)
    if table.turned and "orientation" in shared:
        allowed = "random.turned already turns the bodies"
        raise Refusal(f"{key}.orientation", shared["orientation"], allowed)
    around = [checked(Particle, body, at) for body, at in standing]
    example = Particle.model_validate(
        {**shared, "position": list(domain.origin)} | ({"radius": radii.example} if radii else {})
    )
    shape = build_shape(example)
    if not example.bounded:
        raise Refusal(f"{key}.shape", example.shape, "bodies without an end cannot be packed")
    points, sizes, turns = place_randomly(table, radii, shape, domain, around, key)
    if shape.name != "sphere":
        sizes = radii and np.full(len(points), radii.example)
    bodies = []
    for i, point in enumerate(points):
        body = _at(shared, point, sizes, i)
        if table.turned:
            body["orientation"] = turn_of(turns[i])
        bodies.append((body, f"{key} (body {i})"))
    return bodies
