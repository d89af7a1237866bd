"""The smoothed profile method once more, in whole arrays on a periodic box, to check the kernels.

Written from the equations, not from the package: NumPy rolls for stencils, NumPy FFTs for solves.
Fields are (nx, ny, nz) without ghosts, velocities on low faces.
"""

import numpy as np

TABLES = {
    "backward-euler": (1.0, (1.0,), (1.0,), 1.0),
    "crank-nicolson": (1.0, (1.0,), (1.5, -0.5), 0.5),
    "bdf2": (1.5, (2.0, -0.5), (2.0, -1.0), 1.0),
    "bdf3": (11 / 6, (3.0, -1.5, 1 / 3), (3.0, -3.0, 1.0), 1.0),
}
"""γ, α, β, θ of (γuˢ − Σα_q uⁿ⁻q)/Δt + Σβ_q N(uⁿ⁻q) = ν∇²[θuˢ + (1−θ)uⁿ] − ∇pⁿ + g."""


class PlainStep:
    """Takes steps of one scheme and coupling; `velocity` (3, …), `pressure`, `impulse` (3, …)."""

    def __init__(self, widths, velocity, scheme, coupling, nu, dt, force=(0.0, 0.0, 0.0)):
        self.h, self.nu, self.dt, self.g = widths, nu, dt, force
        self.scheme, self.coupling = scheme, coupling
        self.levels, self.advection = [np.array(velocity)], []
        self.pressure = np.zeros(velocity[0].shape)
        angles = [2 * np.pi * np.fft.fftfreq(n) for n in self.pressure.shape]
        waves = [(2 * np.sin(a / 2) / h) ** 2 for a, h in zip(angles, widths, strict=True)]
        self.waves = waves[0][:, None, None] + waves[1][None, :, None] + waves[2][None, None, :]

    @property
    def velocity(self):
        return self.levels[0]

    def step(self, phi, target):
        """One step; φ and u_p at its end on the faces, (3, …) each."""
        known = len(self.levels)
        gamma, past, weights, theta = TABLES[self.scheme]
        trial = known < max(len(past), len(weights)) and known == 1
        if trial:
            # One level known: Euler for bdf2, the trapezoidal rule for the two others.
            gamma, past, weights = 1.0, (1.0,), (1.0,)
            theta = 1.0 if self.scheme == "bdf2" else 0.5
        elif self.scheme == "bdf3" and known == 2:
            gamma, past, weights, theta = TABLES["bdf2"]
        rate = gamma / self.dt
        self.advection.insert(0, self.advect(self.levels[0]))
        terms = self.advection
        old = self.pressure if self.coupling == "incremental" else 0.0 * self.pressure
        if trial and self.scheme == "bdf3":
            u, _ = self.project(self.predict(gamma, past, weights, theta, terms, old), rate)
            terms = [0.5 * (terms[0] + self.advect(u))]
        u = self.predict(gamma, past, weights, theta, terms, old)
        first = 0.0
        if self.coupling == "thesis":
            u, first = self.project(u, rate)
        self.impulse = phi * (target - u)
        u, second = self.project(u + self.impulse, rate)
        self.pressure = old + first + second
        self.levels.insert(0, u)

    def predict(self, gamma, past, weights, theta, advection, pressure):
        out = []
        for c in range(3):
            r = sum(a * u[c] for a, u in zip(past, self.levels, strict=False)) / self.dt
            r = r - sum(b * n[c] for b, n in zip(weights, advection, strict=False)) + self.g[c]
            r = r - (pressure - np.roll(pressure, 1, c)) / self.h[c]
            r = r + (1 - theta) * self.nu * self.laplacian(self.levels[0][c])
            r_hat = np.fft.fftn(r) / (gamma / self.dt + theta * self.nu * self.waves)
            out.append(np.fft.ifftn(r_hat).real)
        return np.array(out)

    def project(self, u, rate):
        divergence = sum((np.roll(u[c], -1, c) - u[c]) / self.h[c] for c in range(3))
        inverse = np.divide(1.0, self.waves, out=np.zeros_like(self.waves), where=self.waves > 0)
        p = np.fft.ifftn(-rate * np.fft.fftn(divergence) * inverse).real
        return np.array([u[c] - (p - np.roll(p, 1, c)) / (rate * self.h[c]) for c in range(3)]), p

    def laplacian(self, f):
        return sum(
            (np.roll(f, 1, d) - 2 * f + np.roll(f, -1, d)) / self.h[d] ** 2 for d in range(3)
        )

    def advect(self, u):
        out = np.zeros_like(u)
        for c in range(3):
            for d in range(3):
                if c == d:
                    flux = (0.5 * (u[c] + np.roll(u[c], -1, c))) ** 2
                    out[c] += (flux - np.roll(flux, 1, c)) / self.h[c]
                else:
                    flux = 0.25 * (u[d] + np.roll(u[d], 1, c)) * (u[c] + np.roll(u[c], 1, d))
                    out[c] += (np.roll(flux, -1, d) - flux) / self.h[d]
        return out
