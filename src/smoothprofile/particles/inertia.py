"""Inertia of the fluid that the bodies displace, as rigid bodies of that fluid.

    F = ρV a,   a = dV/dt + Ω̇×c + Ω×(Ω×c)
    T = ρ(J Ω̇ + Ω×(J Ω)) + c×F

V is the volume of the true surface, wherever it is painted, c the way from the body's position to
its centroid, J the inertia of unit density about the centroid; T is about the body's position.
"""

from dataclasses import dataclass

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.paint import Painter


@dataclass(frozen=True, eq=False)
class DisplacedFluid:
    """volume (n,), centroid (n,3) and inertia (n,3,3) of unit density, along the body's axes."""

    volume: np.ndarray
    centroid: np.ndarray
    inertia: np.ndarray

    @classmethod
    def of(cls, painter: Painter, state: BodyState) -> "DisplacedFluid":
        """From the forms; of a body without end, what lies in the box at the start."""
        forms = painter.forms
        endless = np.flatnonzero(~np.isfinite(forms.volume))
        found = cls(forms.volume.copy(), forms.centroid.copy(), forms.inertia.copy())
        if endless.size:
            true = painter.sharpened()
            true.paint(state)
            for b in endless:
                found.volume[b], found.centroid[b], found.inertia[b] = _as_painted(true, state, b)
        return found

    def loads(
        self, state: BodyState, acceleration: np.ndarray, angular_acceleration: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """F/ρ and T/ρ, each (n,3), of bodies that speed up by (n,3) along the box's axes."""
        turn, spin = state.rotation, state.angular_velocity
        c = np.einsum("nij,nj->ni", turn, self.centroid)
        inertia = np.einsum("nij,njk,nlk->nil", turn, self.inertia, turn)
        inward = np.cross(spin, np.cross(spin, c))
        force = self.volume[:, None] * (acceleration + np.cross(angular_acceleration, c) + inward)
        gyration = np.cross(spin, np.einsum("nij,nj->ni", inertia, spin))
        own = np.einsum("nij,nj->ni", inertia, angular_acceleration) + gyration
        return force, own + np.cross(c, force)


def _as_painted(painter: Painter, state: BodyState, body: int) -> tuple:
    """Volume, centroid and inertia of one body from its painted moments."""
    volume, first, second = painter.moments(state, body)
    centroid = first / volume
    second = second - volume * np.outer(centroid, centroid)
    inertia = np.trace(second) * np.eye(3) - second
    turn = state.rotation[body]
    return volume, turn.T @ centroid, turn.T @ inertia @ turn
