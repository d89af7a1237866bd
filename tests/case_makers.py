"""Small cases for tests, and what every refusal must be."""

import re

import pytest

from smoothprofile.config import load_case
from smoothprofile.errors import CaseError


def sphere(**changes):
    return {"shape": "sphere", "radius": 1.0, "position": [0.0, 0.0, 0.0], **changes}


def small_case(*particles, boundaries=("periodic", "wall", ["wall", "slip"])):
    """A box 10 × 8 × 8 about the origin, and what is most often needed in it."""
    return {
        "domain": {
            "lengths": [10, 8, 8],
            "cells": [10, 8, 8],
            "origin": [-5, -4, -4],
            "boundaries": list(boundaries),
        },
        "fluid": {"density": 1, "viscosity": 1},
        "profile": {"thickness": 0.3},
        "particles": list(particles),
        "time": {"end": 1},
    }


def refusal(source, overrides=()):
    """The sentence, after the checks that hold for every sentence."""
    with pytest.raises(CaseError) as caught:
        load_case(source, overrides)
    text = str(caught.value)
    assert text.endswith(".")
    assert "\n" not in text
    assert not re.search("pydantic|validation error|Input should|errors.pydantic|Value error", text)
    return text
