"""Bodies in a vacuum, moved by contact alone: scenes that several tests of contact share."""

import numpy as np

import flows
from smoothprofile import rotations
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.contact import Contact, default_parameters

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def grid(lengths=(10.0, 10.0, 10.0), periodic=(True, True, True)):
    return flows.box([8, 8, 8], lengths, periodic)


class Scene:
    """Bodies of density one; `held` rows have infinite mass. Gravity acts in place of a fluid."""

    def __init__(self, shapes, position, box=None, held=(), cell=0.1, speed=1.0, **options):
        self.forms = Forms.of(shapes, [np.zeros((len(s.parts), 2)) for s in shapes])
        n = len(shapes)
        self.position = np.array(position, dtype=float).reshape(n, 3)
        self.quaternion = np.tile(UPRIGHT, (n, 1))
        self.velocity, self.spin = np.zeros((n, 3)), np.zeros((n, 3))
        self.mass = np.array([s.volume for s in shapes])
        self.mass[list(held)] = np.inf
        self.inertia = np.where(np.isfinite(self.forms.inertia), self.forms.inertia, 1.0)
        inverse_inertia = np.linalg.inv(self.inertia)
        inverse_inertia[list(held)] = 0.0
        self.gravity = np.zeros(3)
        parameters = options.pop("parameters", None)
        weight = options.pop("weight", np.zeros(n))
        if parameters is None:
            parameters = default_parameters(cell, speed, self.mass, weight, **options)
        self.parameters, self.grid = parameters, box or grid()
        self.contact = Contact(self.forms, self.grid, 1 / self.mass, inverse_inertia, parameters)

    def step(self, dt, wall_velocity=None, turning=True):
        """V + gt and what contact adds, over Δt."""
        pull = np.where(np.isfinite(self.mass), 1.0, 0.0)[:, None] * self.gravity
        still = np.zeros_like(self.spin)
        moved = self.contact.move(
            self.position,
            self.quaternion,
            (self.velocity + 0.5 * dt * pull, pull),
            (self.spin, still),
            dt,
            wall_velocity,
        )
        self.position = moved.position
        self.quaternion = moved.quaternion if turning else self.quaternion
        self.velocity = self.velocity + dt * pull + moved.history.velocity_gain
        self.spin = self.spin + moved.history.spin_gain
        return moved

    @property
    def momentum(self):
        return (self.mass[:, None] * self.velocity).sum(axis=0)

    @property
    def angular_momentum(self):
        turn = rotations.matrix(self.quaternion)
        own = np.einsum("nij,njk,nlk,nl->ni", turn, self.inertia, turn, self.spin)
        return (np.cross(self.position, self.mass[:, None] * self.velocity) + own).sum(axis=0)

    @property
    def energy(self):
        turn = rotations.matrix(self.quaternion)
        along = np.einsum("nji,nj->ni", turn, self.spin)
        turning = np.einsum("ni,nij,nj->n", along, self.inertia, along)
        return 0.5 * float((self.mass * (self.velocity**2).sum(axis=1) + turning).sum())
