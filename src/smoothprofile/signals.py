"""Velocities given in time as a constant plus one sinusoid, with their integrals in closed form.

Walls and bodies evaluate them each step; anything with the same three members (a function written
in Python, wrapped) can stand in their place.
"""

from dataclasses import dataclass
from math import cos, pi

import numpy as np

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Signal:
    """s(t) = constant + amplitude · cos(ωt + phase), ω = angular_frequency, phase in radians.

    A signal that does not move in time has amplitude (0, 0, 0).
    """

    constant: Vector = (0.0, 0.0, 0.0)
    amplitude: Vector = (0.0, 0.0, 0.0)
    angular_frequency: float = 0.0
    phase: float = 0.0

    def at(self, time: float) -> np.ndarray:
        """s(t), shape (3,)."""
        wave = cos(self.angular_frequency * time + self.phase)
        return np.add(self.constant, np.multiply(wave, self.amplitude))

    def integral(self, time: float) -> np.ndarray:
        """∫₀ᵗ s dt' = constant·t + amplitude·t·sinc(ωt/2)·cos(ωt/2 + phase), shape (3,).

        Written with sinc(x) = sin(x)/x, it holds down to ω = 0 without cancellation.
        """
        half = 0.5 * self.angular_frequency * time
        wave = time * np.sinc(half / pi) * cos(half + self.phase)
        return np.multiply(time, self.constant) + np.multiply(wave, self.amplitude)

    @property
    def maximum(self) -> np.ndarray:
        """|constant| + |amplitude| ≥ |s(t)| at any t, component by component, shape (3,)."""
        return np.abs(self.constant) + np.abs(self.amplitude)
