"""[[particles]] of a case: form, place, attitude and motion of each body."""

import math
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from smoothprofile import rotations, shapes, triangles
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.tables import CSV, LATTICE, RANDOM, Lattice, RandomPacking
from smoothprofile.config.values import (
    DIRECTION,
    FLAG,
    LENGTHS,
    NAME,
    NUMBER,
    NUMBERS,
    POSITIVE,
    VELOCITY,
    Direction,
    Lengths,
    Name,
    Positive,
    Table,
    Vector,
    Velocity,
)
from smoothprofile.signals import Signal

Simple = Literal["sphere", "ellipsoid", "cylinder", "capsule", "box"]


class Sizes(NamedTuple):
    """Keys a shape must have, may have, and the key that can give its direction."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()
    direction: str | None = None

    @property
    def extra(self) -> tuple[str, ...]:
        return (*self.optional, *filter(None, [self.direction]))

    @property
    def words(self) -> str:
        *first, last = self.extra or ("",)
        may_have = f"{', '.join(first)} and {last}" if first else last
        if self.needed and self.extra:
            return f"needs {' and '.join(self.needed)}, and may have {may_have}"
        return f"takes {' and '.join(self.needed) or may_have}"


SIZES = {
    "sphere": Sizes(("radius",)),
    "ellipsoid": Sizes(("radii",)),
    "cylinder": Sizes(("radius",), ("length",), "axis"),
    "capsule": Sizes(("radius", "length"), (), "axis"),
    "box": Sizes(("sides",)),
    "plane": Sizes((), (), "normal"),
    "mesh": Sizes(("file",), ("scale", "repair", "digest")),
    "union": Sizes(("parts",)),
}
MOTIONS = ("held", "prescribed", "free")
SIZE_KEYS = ("radius", "radii", "length", "sides", "parts", "axis", "normal")
SIZE_KEYS += SIZES["mesh"].needed + SIZES["mesh"].optional
SOURCE_KEYS = ("lattice", "random", "csv")


class Orientation(Table):
    """A right-handed turn about an axis, the angle in degrees."""

    axis: Direction = Field(description=DIRECTION)
    angle: float = Field(description=NUMBER)


class Solid(Table):
    """A simple shape: the sizes it needs and no other, where it is and how it is turned."""

    shape: Simple = Field(description="one of sphere, ellipsoid, cylinder, capsule and box")
    radius: Positive | None = Field(None, description=POSITIVE)
    radii: Lengths | None = Field(None, description=LENGTHS)
    length: Positive | None = Field(None, description=POSITIVE)
    sides: Lengths | None = Field(None, description=LENGTHS)
    position: Vector = Field(description=NUMBERS)
    axis: Direction | None = Field(None, description=DIRECTION)
    orientation: Orientation | None = Field(
        None, description="a table such as { axis = [0, 0, 1], angle = 30 }"
    )

    @model_validator(mode="after")
    def _has_its_sizes(self) -> "Solid":
        sizes = SIZES[self.shape]
        one = f"{'an' if self.shape[0] == 'e' else 'a'} {self.shape}"
        for key in SIZE_KEYS:
            value = getattr(self, key, None)
            if value is None and key in sizes.needed:
                raise Refusal(key, MISSING, f"{one} needs {' and '.join(sizes.needed)}")
            if value is not None and key not in (*sizes.needed, *sizes.extra):
                takes = f"{one} {sizes.words}, and no other size"
                raise Refusal(key, shown_size(value), takes)
        if self.direction is not None and self.orientation is not None:
            turn = {"axis": self.orientation.axis, "angle": self.orientation.angle}
            raise Refusal("orientation", turn, f"{sizes.direction} already gives the direction")
        return self

    @property
    def direction(self) -> tuple[float, float, float] | None:
        """Where the shape's own z axis points, if `axis` or `normal` says so."""
        key = SIZES[self.shape].direction
        return getattr(self, key) if key else None

    @property
    def quaternion(self) -> np.ndarray:
        """From the shape's own axes to those it is placed in, (4,), w first."""
        if self.orientation is not None:
            angle = math.radians(self.orientation.angle)
            return rotations.from_axis_angle(self.orientation.axis, angle)
        return rotations.from_two_vectors((0.0, 0.0, 1.0), self.direction or (0.0, 0.0, 1.0))

    @property
    def bounded(self) -> bool:
        """False for planes and for cylinders without a length."""
        return self.shape != "plane" and not (self.shape == "cylinder" and self.length is None)

    @property
    def thinnest(self) -> tuple[str, float]:
        """The key and the value of the smallest radius or half side; infinite for a plane."""
        halves = {"radius": self.radius, "length": self.length and 0.5 * self.length}
        if self.shape == "capsule":
            halves.pop("length")
        halves["radii"] = self.radii and min(self.radii)
        halves["sides"] = self.sides and 0.5 * min(self.sides)
        given = [(value, key) for key, value in halves.items() if value is not None]
        value, key = min(given, default=(math.inf, "normal"))
        return key, value


class Particle(Solid):
    """[[particles]]: a simple shape, a plane, a union or what an STL file bounds, and its motion.

    A mesh keeps the `digest` of its file, so that a changed file is noticed. In a case file one of
    lattice, random and csv may stand for `position`, and is replaced by bodies when it is loaded.
    A free body starts with `velocity` and `angular_velocity`; force and torque act on it besides
    the fluid and gravity.
    """

    name: Name | None = Field(None, description=NAME)
    shape: Literal[Simple, "plane", "union", "mesh"] = Field(
        description="one of " + ", ".join(SIZES)
    )
    normal: Direction | None = Field(None, description=DIRECTION)
    parts: Annotated[tuple[Solid, ...], Field(strict=False, min_length=1)] | None = Field(
        None, description="a list of one or more tables, each with a shape, its sizes, a position"
    )
    file: Annotated[str, Field(min_length=1)] | None = Field(
        None, description="the path of an STL file in quotes"
    )
    scale: Positive | None = Field(None, description=POSITIVE)
    repair: bool | None = Field(None, description=FLAG)
    digest: str | None = Field(None, description="a text in quotes")
    lattice: Lattice | None = Field(None, description=LATTICE)
    random: RandomPacking | None = Field(None, description=RANDOM)
    csv: str | None = Field(None, description=CSV)
    motion: Literal[MOTIONS] = Field(description='"held", "prescribed" or "free"')
    velocity: Velocity = Field(Signal(), description=VELOCITY)
    angular_velocity: Velocity = Field(Signal(), description=VELOCITY)
    density: Positive | None = Field(None, description=POSITIVE)
    permittivity: Positive | None = Field(None, description=POSITIVE)
    force: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    torque: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)

    @model_validator(mode="before")
    @classmethod
    def _held_unless_it_moves(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "motion" in data:
            return data
        moves = "velocity" in data or "angular_velocity" in data
        return {**data, "motion": "prescribed" if moves else "held"}

    @model_validator(mode="after")
    def _moves_as_it_may(self) -> "Particle":
        if self.shape == "plane" and self.normal is None and self.orientation is None:
            raise Refusal("normal", MISSING, "a plane needs normal or orientation")
        for key in SOURCE_KEYS:
            if getattr(self, key) is not None:
                raise Refusal(key, getattr(self, key), "it is read by load_case only")
        if self.shape == "mesh":
            self._has_its_surface()
        for number, part in enumerate(self.parts or ()):
            if not part.bounded:
                key, allowed = f"parts.{number}.length", "a part of a union needs an end"
                raise Refusal(key, MISSING, allowed)
        for key in ("velocity", "angular_velocity"):
            signal = getattr(self, key)
            if self.motion == "held" and signal.maximum.any():
                allowed = f'a held body has no {key}, one with motion = "prescribed" has'
                raise Refusal(key, shown_signal(signal), allowed)
        self._is_free_as_it_may()
        return self

    def _has_its_surface(self) -> None:
        try:
            if self.digest is not None and triangles.digest_of(Path(self.file)) != self.digest:
                allowed = f"the content of {self.file} is another; leave digest out to take it"
                raise Refusal("digest", self.digest, allowed)
            build_shape(self)
        except triangles.SurfaceError as error:
            raise Refusal("file", self.file, str(error)) from None

    def _is_free_as_it_may(self) -> None:
        if self.motion != "free":
            for key in ("density", "force", "torque"):
                value = getattr(self, key)
                if value is not None and np.any(value):
                    raise Refusal(key, value, f'only a body with motion = "free" has a {key}')
            return
        if not self.bounded:
            raise Refusal("motion", "free", f"a {self.shape} without an end cannot move freely")
        if self.density is None:
            raise Refusal("density", MISSING, "a free body needs density")
        for key in ("velocity", "angular_velocity"):
            if any(getattr(self, key).amplitude):
                allowed = f"of a free body {key} is that at the start, three numbers"
                raise Refusal(key, {"amplitude": getattr(self, key).amplitude}, allowed)

    @property
    def only_turns(self) -> bool:
        """Whether it turns, as prescribed, and stays: its torque then counts, not its drag."""
        given = self.motion == "prescribed" and self.angular_velocity.maximum.any()
        return bool(given and not self.velocity.maximum.any())

    @property
    def thinnest(self) -> tuple[str, float]:
        """As of a simple shape; of a union, that of its thinnest part; of a mesh, its inside's."""
        if self.shape == "mesh":
            return "file", build_shape(self).parts[0].surface.depth
        if self.parts is None:
            return super().thinnest
        sizes = [part.thinnest for part in self.parts]
        number = min(range(len(sizes)), key=lambda i: sizes[i][1])
        return f"parts.{number}.{sizes[number][0]}", sizes[number][1]


def build_shape(particle: Solid) -> shapes.Shape:
    """The shape of a body in its own frame, which `particle.quaternion` turns into space.

    Bodies of the same form share one shape. SurfaceError for an STL file that bounds none.
    """
    return _shape_like(FormOf(particle))


class FormOf:
    """A body as the key of its shape: equal for bodies of the same shape and sizes."""

    def __init__(self, particle: Solid):
        self.particle = particle
        sizes = (getattr(particle, key, None) for key in SIZE_KEYS if key not in ("axis", "normal"))
        self._key = (particle.shape, *sizes)
        if particle.shape == "mesh" and particle.digest is None:
            self._key += (triangles.digest_of(Path(particle.file)),)

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FormOf) and self._key == other._key


@lru_cache(maxsize=20_000)
def _shape_like(form: FormOf) -> shapes.Shape:
    particle = form.particle
    if particle.shape == "union":
        members = [(build_shape(part), part.position, part.quaternion) for part in particle.parts]
        return shapes.union(members)
    makers = {
        "sphere": lambda: shapes.sphere(particle.radius),
        "ellipsoid": lambda: shapes.ellipsoid(particle.radii),
        "cylinder": lambda: shapes.cylinder(particle.radius, particle.length),
        "capsule": lambda: shapes.capsule(particle.radius, particle.length),
        "box": lambda: shapes.box(particle.sides),
        "plane": lambda: shapes.plane(),
        "mesh": lambda: shapes.mesh(
            triangles.load_surface(
                Path(particle.file), particle.scale or 1.0, particle.repair or False
            )
        ),
    }
    return makers[particle.shape]()


def body_shape(particle: Particle) -> shapes.Shape:
    """The shape of a body about its position: a free one's is its centre of mass."""
    shape = build_shape(particle)
    return shapes.centred(shape) if particle.motion == "free" else shape


def start_position(particle: Particle) -> np.ndarray:
    """Where the body's position is at the start: a free one's is its centre of mass."""
    position = np.array(particle.position)
    if particle.motion == "free":
        position = position + rotations.rotate(particle.quaternion, build_shape(particle).centroid)
    return position


def shown_signal(signal: Signal) -> Any:
    """The numbers of a signal to show in a sentence: those that are not zero."""
    return signal.constant if any(signal.constant) else {"amplitude": signal.amplitude}


def shown_size(value: Any) -> Any:
    """A size to show in a sentence; parts by their shapes."""
    if isinstance(value, tuple) and isinstance(value[0], Solid):
        return [{"shape": part.shape} for part in value]
    return value
