"""Closed triangulated surfaces from STL files: read, checked, repaired if asked, and measured.

    V = Σ v_t,   ∫r dV = Σ v_t s/4,   ∫rrᵀ dV = Σ v_t (aaᵀ + bbᵀ + ccᵀ + ssᵀ)/20

over triangles (a, b, c), v_t = a·(b × c)/6 and s = a + b + c: exact for the facets as they are.
The only file that calls trimesh.
"""

import io
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.surfaces import Surface, sample

LARGEST_FILE = 256 * 2**20
SLIVER = 1e-12
"""Double area of a triangle over its longest side squared below which it counts as degenerate."""
OFFER = "repair = true would mend what can be mended"
FARTHEST = 1e30
"""Largest coordinate: its fifth power, which moments take, is still a number."""
THINNEST = 1e4
"""Longest side of a surface over its shortest, from which no grid that samples it is of use."""


class SurfaceError(CaseError):
    """What is wrong with a surface, in words that complete '<file>; …'."""


def load_surface(path: Path, scale: float = 1.0, repair: bool = False) -> Surface:
    """The surface in an STL file, ASCII or binary, its lengths times `scale`.

    With `repair` corners that nearly meet are merged, degenerate triangles dropped, holes of few
    sides closed, triangles turned the same way round and the whole outwards. SurfaceError if the
    file cannot be read, or if the surface is open, inverted, degenerate or crosses itself.
    """
    return _loaded(content_of(path), float(scale), bool(repair))


def digest_of(path: Path) -> str:
    """Sixteen hexadecimal digits that tell the content of one file from that of another."""
    return sha256(content_of(path)).hexdigest()[:16]


def content_of(path: Path) -> bytes:
    """The bytes of a file; SurfaceError if it cannot be read or is too large."""
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise SurfaceError("there is no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SurfaceError(f"it cannot be read: {reason}") from None
    if len(content) > LARGEST_FILE:
        raise SurfaceError(f"it is too large: more than {LARGEST_FILE // 2**20} MiB")
    return content


@lru_cache(maxsize=16)
def _loaded(content: bytes, scale: float, repair: bool) -> Surface:
    vertices, faces = _read(content)
    if repair:
        vertices, faces = _repaired(vertices, faces)
    return surface_of(vertices * scale, faces)


def surface_of(vertices: np.ndarray, faces: np.ndarray) -> Surface:
    """The surface of triangles faces (t, 3) over corners vertices (v, 3), anticlockwise from
    outside.

    SurfaceError if it is open, inverted, degenerate or crosses itself.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    faces = np.ascontiguousarray(faces, dtype=np.int64)
    _check_numbers(vertices)
    _check_triangles(vertices, faces)
    _check_edges(faces)
    volume, first, second = moments(vertices, faces)
    if volume <= 0.0:
        allowed = "must face outwards, and repair = true would turn it"
        raise SurfaceError(f"its surface is inverted, with volume {volume:.4g}; it {allowed}")
    sides = np.ptp(vertices, axis=0)
    if sides.max() > THINNEST * sides.min():
        shown = " × ".join(f"{side:.4g}" for side in sides)
        allowed = f"no side may be {THINNEST:g} times another"
        raise SurfaceError(f"it is a needle or a foil, with a bounding box of {shown}; {allowed}")
    samples, winding = sample(vertices, faces)
    d = samples.values[:, 0].reshape(winding.shape)
    # Nodes on the surface itself, to the round-off of single precision, are on either side.
    plain = np.abs(d) > 1e-5 * float(np.ptp(vertices, axis=0).max())
    wrong = plain & (winding != (d < 0.0))
    if np.any(wrong):
        raise SurfaceError(
            "its surface crosses itself, encloses a place twice or has a part turned inside out; "
            "it must bound one solid"
        )
    return Surface(vertices, faces, volume, first, second, float(-d.min()), samples)


def moments(vertices: np.ndarray, faces: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """V, ∫r dV (3,) and ∫rrᵀ dV (3, 3) about the origin."""
    # From the middle, so that a body far from its origin loses no digits.
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    corners = (vertices - middle)[faces]
    a, b, c = np.moveaxis(corners, 1, 0)
    parts = np.einsum("ti,ti->t", a, np.cross(b, c)) / 6.0
    s = corners.sum(axis=1)
    volume = float(parts.sum())
    first = parts @ s / 4.0
    second = np.einsum("t,tci,tcj->ij", parts, corners, corners)
    second = (second + np.einsum("t,ti,tj->ij", parts, s, s)) / 20.0
    mixed = np.outer(first, middle)
    second = second + mixed + mixed.T + volume * np.outer(middle, middle)
    return volume, first + volume * middle, second


def _read(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Corners and triangles of an STL file, corners with the same numbers being one."""
    from trimesh.exchange.stl import load_stl

    try:
        found = load_stl(io.BytesIO(content))
        solids = list(found["geometry"].values()) if "geometry" in found else [found]
        soup = np.concatenate([np.asarray(s["vertices"], np.float64) for s in solids])
    # A file that is no STL makes the library fail in many ways, all of which mean the same.
    except Exception:
        raise SurfaceError("it is not an STL file, ASCII or binary") from None
    _check_numbers(soup)
    # −0 and 0 are the same place.
    vertices, which = np.unique(soup + 0.0, axis=0, return_inverse=True)
    return vertices, which.reshape(-1, 3)


def _check_numbers(vertices: np.ndarray) -> None:
    if not np.all(np.isfinite(vertices)):
        raise SurfaceError("it has coordinates that are not finite numbers")
    if np.abs(vertices).max(initial=0.0) > FARTHEST:
        raise SurfaceError(f"it has coordinates beyond {FARTHEST:g}")


def _check_triangles(vertices: np.ndarray, faces: np.ndarray) -> None:
    if len(faces) < 4:
        raise SurfaceError(f"it has {len(faces)} triangles; a closed surface has 4 or more")
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    sides = np.stack([b - a, c - b, a - c])
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    flat = np.flatnonzero(area <= SLIVER * np.sum(sides**2, axis=2).max(axis=0))
    if flat.size:
        raise SurfaceError(f"{_count(flat.size, 'triangle')} without area; {OFFER}")


def _check_edges(faces: np.ndarray) -> None:
    """Every edge must be that of two triangles, one each way."""
    ways = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges, which, sharers = np.unique(
        np.sort(ways, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    balance = np.bincount(which.ravel(), np.where(ways[:, 0] < ways[:, 1], 1, -1), len(edges))
    single, many = np.count_nonzero(sharers == 1), np.count_nonzero(sharers > 2)
    if single:
        edges = "an edge" if single == 1 else f"{single} edges"
        raise SurfaceError(f"its surface is open along {edges}; it must be closed, and {OFFER}")
    if many:
        raise SurfaceError(
            f"{_count(many, 'edge')} shared by more than two triangles; it must bound one "
            f"solid, and {OFFER}"
        )
    if np.any(balance):
        turned = np.count_nonzero(balance)
        raise SurfaceError(
            f"its triangles are turned both ways round, along {turned} edges; they must all face "
            "outwards, and repair = true would turn them"
        )


def _repaired(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same surface mended as far as the library can."""
    import trimesh
    from trimesh import repair

    # Corners closer than a millionth of the whole are taken to be meant as one.
    size = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 1.0
    digits = int(np.ceil(-np.log10(1e-6 * size))) if size > 0.0 else None
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.merge_vertices(digits_vertex=digits)
    mesh.update_faces(mesh.nondegenerate_faces(height=1e-9 * size))
    mesh.update_faces(mesh.unique_faces())
    if len(mesh.faces) >= 3:
        repair.fill_holes(mesh, use_fan=True)
        repair.fix_normals(mesh, multibody=False)
    mesh.remove_unreferenced_vertices()
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing} of it is" if number == 1 else f"{number} {thing}s of it are"
