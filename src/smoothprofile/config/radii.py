"""radius of a source: one number, a list dealt in turn, sizes by share, or a distribution."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError

from smoothprofile.config.refusals import Refusal, explain
from smoothprofile.config.tables import RADIUS, Sizes, Spread
from smoothprofile.config.values import is_finite
from smoothprofile.errors import CaseError


@dataclass(frozen=True)
class Radii:
    """How large the bodies of a source are: `dealt` in turn, or as `table` says."""

    dealt: tuple[float, ...] = ()
    table: Sizes | Spread | None = None

    @property
    def example(self) -> float:
        """The radius of some body, the smallest if known."""
        if isinstance(self.table, Spread):
            return self.table.mean
        return min(self.table.sizes if self.table else self.dealt)

    @property
    def mean_cube(self) -> float:
        """⟨a³⟩, of a distribution as if it had no ends."""
        if isinstance(self.table, Spread):
            m, s = self.table.mean, self.table.deviation
            if self.table.kind == "normal":
                return m**3 + 3.0 * m * s**2
            return m**3 * (1.0 + (s / m) ** 2) ** 3
        if self.table is not None:
            return float(np.average(np.power(self.table.sizes, 3.0), weights=self.table.shares))
        return float(np.mean(np.power(self.dealt, 3.0)))

    def draw(self, number: int, generator: np.random.Generator) -> np.ndarray:
        """That many radii, (number,)."""
        if isinstance(self.table, Spread):
            return _drawn(self.table, number, generator)
        if self.table is None:
            return np.resize(np.array(self.dealt), number)
        shares = np.cumsum(self.table.shares) / np.sum(self.table.shares)
        ends = np.round(shares * number).astype(int)
        counts = np.diff(ends, prepend=0)
        return generator.permutation(np.repeat(self.table.sizes, counts))


def read_radii(entry: dict[str, Any], k: int) -> Radii | None:
    """The radii of source `k`; None if it gives none."""
    if "radius" not in entry:
        return None
    value, key = entry["radius"], f"particles.{k}.radius"
    if isinstance(value, dict):
        model: type[BaseModel] = Sizes if "sizes" in value or "shares" in value else Spread
        try:
            return Radii(table=model.model_validate(value))
        except ValidationError as error:
            raise CaseError(explain(error, value, model, key)) from None
    numbers = value if isinstance(value, list) else [value]
    if not numbers or not all(is_finite(number) and number > 0 for number in numbers):
        raise Refusal(key, value, f"it must be {RADIUS}")
    return Radii(tuple(float(number) for number in numbers))


def _drawn(spread: Spread, number: int, generator: np.random.Generator) -> np.ndarray:
    """Radii of a truncated distribution: what falls beyond its ends is drawn again."""
    low, high = spread.ends
    log_variance = np.log1p((spread.deviation / spread.mean) ** 2)
    found = np.empty(0)
    while found.size < number:
        if spread.kind == "normal":
            tried = generator.normal(spread.mean, spread.deviation, number)
        else:
            middle = np.log(spread.mean) - 0.5 * log_variance
            tried = generator.lognormal(middle, np.sqrt(log_variance), number)
        found = np.concatenate([found, tried[(tried >= low) & (tried <= high)]])
    return found[:number]
