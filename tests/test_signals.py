"""Signals against quadrature, and their bound."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from smoothprofile.signals import Signal


def test_signals_integrate_and_are_bounded():
    signal = Signal((1.0, 0.0, -2.0), (0.5, 3.0, 0.0), 2.5, 0.7)
    times = np.linspace(0.0, 4.0, 9)
    for time in times:
        # Quadrature of a smooth wave: its own error estimate is below 1e-12.
        exact = [quad(lambda t, d=d: signal.at(t)[d], 0.0, time)[0] for d in range(3)]
        assert signal.integral(time) == pytest.approx(exact, abs=1e-11)
        assert np.all(np.abs(signal.at(time)) <= signal.maximum)
    assert signal.at(-0.7 / 2.5) == pytest.approx([1.5, 3.0, -2.0])
    # A frequency so low that sin(ωt + φ) − sin φ would be all round-off.
    slow = Signal((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1e-18, 0.3)
    assert slow.integral(2.0)[0] == pytest.approx(2.0 * math.cos(0.3), rel=1e-15)
