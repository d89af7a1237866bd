"""Strict JSON text of numbers and arrays."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def to_json(data: Any) -> str:
    """Strict JSON text: arrays as lists, NaN and infinity (which JSON lacks) as null."""
    return json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False)


def plain(value: Any) -> Any:
    """Numpy numbers and arrays as Python's, what is not finite as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
