"""The value that approximations of rising order tend to, and how far off it may be."""

from collections.abc import Sequence
from typing import NamedTuple


class Limit(NamedTuple):
    """A value, and an estimate of its error."""

    value: float
    error: float


def limit_of(values: Sequence[float]) -> Limit:
    """v∞ = v₃ + d₂r/(1 − r),  r = d₂/d₁,  d₁ = v₂ − v₁,  d₂ = v₃ − v₂   (Aitken)

    of the last three `values`, whose errors are taken to fall by one factor r from each to the
    next, as those of finite elements do with the order where the solution is smooth. The error is
    the whole of |v∞ − v₃|; where the values do not close in, |r| ≥ ½, it is v₃ ± (|d₁| + |d₂|).
    ValueError for fewer than three values.
    """
    if len(values) < 3:
        raise ValueError(f"{len(values)} values were given; three are needed")
    v1, v2, v3 = values[-3:]
    d1, d2 = v2 - v1, v3 - v2
    if 2.0 * abs(d2) >= abs(d1):
        return Limit(v3, abs(d1) + abs(d2))
    beyond = d2 * d2 / (d1 - d2)
    return Limit(v3 + beyond, abs(beyond))
