"""Tables that stand for many bodies: lattices, random packings and spreads of radii."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, model_validator

from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.values import (
    COUNT,
    COUNTS,
    FLAG,
    LENGTHS,
    NUMBERS,
    POSITIVE,
    Count,
    Counts,
    Positive,
    Table,
    Vector,
    is_finite,
)
from smoothprofile.packing import DENSEST

LEAST_SHARE = 0.01
"""Of a distribution that its ends leave: what lies beyond them is drawn in vain."""
LATTICE = 'a table such as { kind = "fcc", counts = [4, 4, 4] }'
RANDOM = "a table such as { count = 100, seed = 1 }"
CSV = "the path of a CSV file in quotes"
RADIUS = (
    "a finite number above 0, a list of such, { mean = .., deviation = .. } "
    "or { sizes = [..], shares = [..] }"
)


def _spacing(value: Any) -> tuple[float, float, float]:
    values = list(value) if isinstance(value, list | tuple) else [value] * 3
    if len(values) != 3 or not all(is_finite(number) and number > 0 for number in values):
        raise ValueError("no such spacing")
    return tuple(map(float, values))


class Lattice(Table):
    """lattice = { … }: unit cells along x, y, z, `origin` the first point.

    Without `spacing` the cells fill the domain, without `counts` as many as fit it; without
    `origin` the points stand in the middle of the domain.
    """

    kind: Literal["cubic", "bcc", "fcc"] = Field("cubic", description='"cubic", "bcc" or "fcc"')
    counts: Counts | None = Field(None, description=COUNTS)
    spacing: Annotated[Any, PlainValidator(_spacing)] = Field(
        None, description=f"{POSITIVE} or {LENGTHS}"
    )
    origin: Vector | None = Field(None, description=NUMBERS)

    @model_validator(mode="after")
    def _has_a_size(self) -> "Lattice":
        if self.counts is None and self.spacing is None:
            raise Refusal("counts", MISSING, "a lattice needs counts, spacing or both")
        return self


class Box(Table):
    """box = { low = [..], high = [..] }: opposite corners."""

    low: Vector = Field(description=NUMBERS)
    high: Vector = Field(description=NUMBERS)

    @model_validator(mode="after")
    def _has_an_inside(self) -> "Box":
        if any(low >= high for low, high in zip(self.low, self.high, strict=True)):
            raise Refusal("high", self.high, "each number must exceed that of low")
        return self


class RandomPacking(Table):
    """random = { … }: bodies anywhere in the domain or in a box, none nearer than `gap`.

    Either `count` bodies, or as many as take up `volume_fraction` of that room. `turned` gives
    each an attitude of its own.
    """

    count: Count | None = Field(None, description=COUNT)
    volume_fraction: Annotated[float, Field(gt=0, lt=DENSEST)] | None = Field(
        None, description=f"a number above 0 and below {DENSEST:.2f}"
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(0, description="a whole number from 0")
    gap: Annotated[float, Field(ge=0)] = Field(0.0, description="a finite number from 0")
    box: Box | None = Field(
        None, description="a table such as { low = [0, 0, 0], high = [1, 1, 1] }"
    )
    turned: bool = Field(False, description=FLAG)

    @model_validator(mode="after")
    def _has_one_amount(self) -> "RandomPacking":
        if self.count is None and self.volume_fraction is None:
            raise Refusal("count", MISSING, "a random packing needs count or volume_fraction")
        if self.count is not None and self.volume_fraction is not None:
            raise Refusal("count", self.count, "volume_fraction already says how many")
        return self


class Spread(Table):
    """radius = { mean, deviation, … }: drawn at random, none beyond `smallest` and `largest`.

    These are three deviations from the mean if left out, but no less than a tenth of the mean.
    """

    kind: Literal["normal", "lognormal"] = Field("normal", description='"normal" or "lognormal"')
    mean: Positive = Field(description=POSITIVE)
    deviation: Positive = Field(description=POSITIVE)
    smallest: Positive | None = Field(None, description=POSITIVE)
    largest: Positive | None = Field(None, description=POSITIVE)

    @property
    def ends(self) -> tuple[float, float]:
        """The smallest and the largest radius."""
        low = max(self.mean - 3.0 * self.deviation, 0.1 * self.mean)
        return self.smallest or low, self.largest or self.mean + 3.0 * self.deviation

    @model_validator(mode="after")
    def _holds_its_mean(self) -> "Spread":
        low, high = self.ends
        if not low < high:
            raise Refusal("smallest", low, f"it must be below the largest, {high:g}")
        if not low < self.mean < high:
            raise Refusal("mean", self.mean, f"it must lie between {low:g} and {high:g}")
        if self._share_between(low, high) < LEAST_SHARE:
            allowed = (
                f"less than {100 * LEAST_SHARE:g} % of what is drawn lies between {low:g} and "
                f"{high:g}; take a smaller one, or other ends"
            )
            raise Refusal("deviation", self.deviation, allowed)
        return self

    def _share_between(self, low: float, high: float) -> float:
        """How much of the whole distribution lies between two radii."""
        if self.kind == "normal":
            middle, width, ends = self.mean, self.deviation, (low, high)
        else:
            width = math.sqrt(math.log1p((self.deviation / self.mean) ** 2))
            middle, ends = math.log(self.mean) - 0.5 * width**2, (math.log(low), math.log(high))
        first, last = (math.erf((end - middle) / (width * math.sqrt(2.0))) for end in ends)
        return 0.5 * (last - first)


class Sizes(Table):
    """radius = { sizes = [..], shares = [..] }: that many of each, in proportion."""

    sizes: Annotated[tuple[Positive, ...], Field(strict=False, min_length=1)] = Field(
        description="a list of finite numbers above 0"
    )
    shares: Annotated[tuple[Positive, ...], Field(strict=False, min_length=1)] = Field(
        description="a list of finite numbers above 0"
    )

    @model_validator(mode="after")
    def _pair_up(self) -> "Sizes":
        if len(self.sizes) != len(self.shares):
            count = f"{len(self.sizes)} number{'' if len(self.sizes) == 1 else 's'}"
            allowed = f"it must be {count}, one for each of sizes"
            raise Refusal("shares", self.shares, allowed)
        return self
