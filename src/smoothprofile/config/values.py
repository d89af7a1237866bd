"""What the tables of a case are made of: strict tables, and the kinds of value they hold."""

import math
from collections.abc import Collection
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PlainSerializer, PlainValidator, model_validator

from smoothprofile.config.refusals import MISSING, Refusal, read_table
from smoothprofile.signals import Signal

AXES = ("x", "y", "z")
SIDES = ("x_low", "x_high", "y_low", "y_high", "z_low", "z_high")
AxisName = Literal["x", "y", "z"]
Side = Literal["x_low", "x_high", "y_low", "y_high", "z_low", "z_high"]

Positive = Annotated[float, Field(gt=0)]
Count = Annotated[int, Field(ge=1, le=1_000_000)]
# TOML has lists and no tuples: only the container is lenient, never what it holds.
NAME = "a name in quotes, of one line"
Name = Annotated[str, Field(pattern=r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]+$")]
"""Of what tables have rows of: without anything that ends a line."""
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Lengths = Annotated[tuple[Positive, Positive, Positive], Field(strict=False)]
Counts = Annotated[tuple[Count, Count, Count], Field(strict=False)]

NUMBER = "a finite number"
NUMBERS = "three finite numbers"
DIRECTION = "three finite numbers, not all 0"
POSITIVE = "a finite number above 0"
LENGTHS = "three finite numbers above 0"
COUNT = "a whole number from 1 to 1000000"
COUNTS = "three whole numbers from 1 to 1000000"
FLAG = "true or false"
SIZE = "numbers other than 0 lie between 1e-40 and 1e40 in size"
AXIS = '"x", "y" or "z"'
VELOCITY = (
    "three finite numbers or "
    "{ constant = [..], amplitude = [..], angular_frequency = .., phase = .. }"
)


class Table(BaseModel):
    """A table of the case file: no unknown keys, no conversions, no NaN, no changes."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _computable(cls, data: Any) -> Any:
        """Refusal of numbers whose products would leave a double's range."""
        for key, value in data.items() if isinstance(data, dict) else ():
            numbers = value if isinstance(value, list | tuple) else (value,)
            if not all(map(has_computable_size, numbers)):
                raise Refusal(key, value, SIZE)
        return data


class SignalTable(Table):
    """constant + amplitude·cos(angular_frequency·t + phase), as written in a case."""

    constant: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    amplitude: Vector = Field((0.0, 0.0, 0.0), description=NUMBERS)
    angular_frequency: Positive | None = Field(None, description=POSITIVE)
    phase: float = Field(0.0, description=NUMBER)

    @model_validator(mode="after")
    def _moves_or_not(self) -> "SignalTable":
        if any(self.amplitude) and self.angular_frequency is None:
            raise Refusal("angular_frequency", MISSING, "an amplitude needs one, above 0")
        for key in ("angular_frequency", "phase"):
            if getattr(self, key) and "amplitude" not in self.model_fields_set:
                raise Refusal(key, getattr(self, key), "without an amplitude it does nothing")
        return self


def known(names: Collection[str]) -> PlainValidator:
    """A check that a value is one of the names."""

    def check(value: Any) -> str:
        if not isinstance(value, str) or value not in names:
            raise ValueError("no such name")
        return value

    return PlainValidator(check)


def is_vector(value: Any) -> bool:
    """Three finite numbers."""
    return (
        isinstance(value, list | tuple)
        and len(value) == 3
        and all(is_finite(component) for component in value)
    )


def has_computable_size(value: Any) -> bool:
    """False for finite numbers beyond 1e40 or, but for 0, below 1e-40 in size."""
    return not is_finite(value) or value == 0 or 1e-40 <= abs(value) <= 1e40


def is_finite(value: Any) -> bool:
    """A finite number that a double can hold; true and false are no numbers."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(float(value))
    except OverflowError:
        return False


def _signal(value: Any) -> Signal:
    if isinstance(value, Signal):
        return value
    if is_vector(value):
        return Signal(constant=tuple(map(float, value)))
    if not isinstance(value, dict):
        raise ValueError("neither three numbers nor a table")
    table = read_table(SignalTable, value)
    if not any(table.amplitude):
        return Signal(table.constant)
    return Signal(table.constant, table.amplitude, table.angular_frequency, table.phase)


def _signal_text(signal: Signal) -> Any:
    if not any(signal.amplitude):
        return signal.constant
    return {
        "constant": signal.constant,
        "amplitude": signal.amplitude,
        "angular_frequency": signal.angular_frequency,
        "phase": signal.phase,
    }


Velocity = Annotated[Signal, PlainValidator(_signal), PlainSerializer(_signal_text)]


def _direction(value: Any) -> tuple[float, float, float]:
    if not is_vector(value) or not any(value):
        raise ValueError("not a direction")
    return tuple(map(float, value))


Direction = Annotated[Any, PlainValidator(_direction)]
