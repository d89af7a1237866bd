"""A film of the beads of a run, from its trajectory.gsd: across the field, and along it.

Chains have colours, lone beads are grey; without a field all beads are alike, seen from two sides
of the z axis. MP4 by the ffmpeg of imageio-ffmpeg if that is installed, else GIF by Pillow.
"""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import gsd.hoomd
import numpy as np
from PIL import Image

from smoothprofile.errors import CaseError
from smoothprofile.figures import drawing, name_units, new_panels
from smoothprofile.runrecord import RunRecord, read_run
from smoothprofile.structure import Beads, bonds, chain_of
from smoothprofile.structure_plots import box_of, draw_beads, field_axis, views

RATE, MOST_FRAMES = 20, 240
"""Frames a second, and how many a film has at most."""
LAST_FRAME = 1.5
"""Seconds that the last frame stays."""
HEIGHT, WIDTH, DOTS = 4.2, 8.0, 100
KINDS = (".mp4", ".gif")


def write_film(directory: Path | str, out: Path | None = None) -> Path:
    """Film a run directory to `out`, or to film.mp4 (film.gif without imageio-ffmpeg) there.

    CaseError if it is no run directory, has no trajectory of spheres, or `out` is of another kind.
    """
    record = read_run(directory)
    path = out or record.path / ("film.mp4" if has_encoder() else "film.gif")
    if path.suffix not in KINDS:
        raise CaseError(f"the film {path} must end in {' or '.join(KINDS)}.")
    if path.suffix == ".mp4" and not has_encoder():
        raise CaseError(
            f"the film {path} needs imageio-ffmpeg: pip install 'smoothprofile[film]', or let its "
            "name end in .gif."
        )
    if not path.parent.is_dir():
        raise CaseError(f"the film {path} cannot be written: there is no directory {path.parent}.")
    frames = _read(record)
    with drawing():
        images = _images(record, frames)
        if path.suffix == ".mp4":
            _write_mp4(path, images)
        else:
            _write_gif(path, images)
    return path


def has_encoder() -> bool:
    """Whether imageio-ffmpeg is installed."""
    return find_spec("imageio_ffmpeg") is not None


def _read(record: RunRecord) -> list[tuple[float, Beads]]:
    """Times, and the spheres then; evenly among the frames, with the first and the last."""
    path = record.path / "trajectory.gsd"
    if not path.is_file():
        raise CaseError(f"{record.path} holds no trajectory.gsd: no body of its case moves.")
    low, lengths, periodic = box_of(record.case)
    found = []
    try:
        with gsd.hoomd.open(str(path), mode="r") as file:
            chosen = np.unique(np.linspace(0, len(file) - 1, min(len(file), MOST_FRAMES)).round())
            for number in chosen.astype(int):
                frame = file[int(number)]
                rows = _spheres(frame)
                places = np.asarray(frame.particles.position, dtype=float)[rows]
                radius = 0.5 * np.asarray(frame.particles.diameter, dtype=float)[rows]
                beads = Beads(places + low + 0.5 * lengths, radius, low, lengths, periodic)
                found.append((float(frame.log["time"][0]), beads))
    except (RuntimeError, OSError) as error:
        raise CaseError(f"{path} is damaged: {error}.") from error
    if not found or not found[0][1].radius.size:
        raise CaseError(f"{path} holds no spheres, and a film shows nothing else.")
    return found


def _spheres(frame) -> np.ndarray:
    """Rows of the particles of the type that has all spheres; its form is empty if radii differ."""
    forms = frame.particles.type_shapes
    round_types = [t for t, form in enumerate(forms) if form.get("type", "Sphere") == "Sphere"]
    return np.flatnonzero(np.isin(frame.particles.typeid, round_types))


def _images(record: RunRecord, frames: list[tuple[float, Beads]]) -> Iterator[np.ndarray]:
    """(height, width, 3) of bytes, one a frame; sides are even, as encoders want them."""
    axis, field = field_axis(record.case), "electric" in record.case
    names = ("across the field", "along the field") if field else ("from the side", "from above")
    figure, panels = new_panels(2, HEIGHT, WIDTH)
    figure.set_dpi(DOTS)
    for time, beads in frames:
        count = beads.radius.size
        chains = chain_of(count, bonds(beads)[0]) if field else np.zeros(count, dtype=int)
        for axes, name, view in zip(panels, names, views(axis), strict=True):
            axes.clear()
            draw_beads(axes, beads, chains, *view)
            axes.set_title(f"{name.capitalize()}, t = {time:.4g}")
        name_units(figure, record.case.get("units", {}))
        figure.canvas.draw()
        # The panels stay where the first frame has put them.
        figure.set_layout_engine("none")
        picture = np.asarray(figure.canvas.buffer_rgba())[..., :3]
        height, width = (side // 2 * 2 for side in picture.shape[:2])
        yield np.ascontiguousarray(picture[:height, :width])


def _write_mp4(path: Path, images: Iterator[np.ndarray]) -> None:
    from imageio_ffmpeg import write_frames

    writer = None
    for image in images:
        if writer is None:
            size = (image.shape[1], image.shape[0])
            writer = write_frames(str(path), size, fps=RATE, macro_block_size=2)
            writer.send(None)
        writer.send(image)
    for _ in range(round(RATE * LAST_FRAME)):
        writer.send(image)
    writer.close()


def _write_gif(path: Path, images: Iterator[np.ndarray]) -> None:
    pages = [Image.fromarray(image).quantize(colors=64) for image in images]
    duration = [round(1000 / RATE)] * len(pages)
    duration[-1] = round(1000 * LAST_FRAME)
    pages[0].save(path, save_all=True, append_images=pages[1:], duration=duration, loop=0)
