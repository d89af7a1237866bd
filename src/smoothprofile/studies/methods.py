"""Every method on the same problems: force, error, seconds."""

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from smoothprofile import studies
from smoothprofile.studies.dns import DUCT
from smoothprofile.studies.methods_figures import METHODS, PROBLEMS, pictures
from smoothprofile.studies.methods_runs import (
    Solve,
    Timed,
    coupled_array,
    coupled_duct,
    forced_array,
    forced_duct,
    stokes_array,
    stokes_duct,
    timed,
    viscous_array,
)
from smoothprofile.studies.study import Row, Study
from smoothprofile.threads import thread_count

ARRAYS = {"array_027": 0.027, "array_1": 0.1, "array_216": 0.216}
SPUN = 0.03
EXACT = {
    "array_027": 2.00775,
    "array_1": 3.64245,
    "array_216": 7.44195,
    "spin": 1.030945,
    "creeping": DUCT["creeping"],
    "inertia": DUCT["force"],
}
"""Multipole series (Zick and Homsy, J. Fluid Mech. 115, 1982), body-fitted elements of order 5."""
REACH = {"forcing": 0.03, "stokes": 0.01, "viscosity": 0.03, "coupling": 0.02, "elements": 2e-3}
"""Of the force, on the finest mesh of each method."""
CROWDED = ("array_1", "array_216")
"""Where spheres are so near that force coupling, without their shape, has nothing to agree with."""

Meshes = Sequence[tuple[str, Solve]]
"""How fine, in words, and the solve; the coarsest first."""

STORED = {
    "array_027": {
        2: (2.0185572, 3335, 0.6),
        3: (2.0085380, 10556, 1.2),
        4: (2.0077969, 24393, 2.4),
    },
    "array_1": {2: (3.6733587, 1312, 0.4), 3: (3.6447360, 4027, 0.6), 4: (3.6426021, 9158, 1.0)},
    "array_216": {2: (7.6162917, 798, 0.2), 3: (7.4585595, 2331, 0.25), 4: (7.4433256, 5149, 0.3)},
    "creeping": {2: (30.564492, 4112, 2.8), 3: (30.217261, 12969, 24.0)},
    "inertia": {2: (166.46286, 4112, 2.8), 3: (164.29466, 12969, 24.0)},
}
"""Order of the elements -> value, unknowns, seconds, where ngsolve is not installed."""

INTRODUCTION = (
    "The force F/(6πμaU) on simple cubic arrays of held spheres, U the mean velocity, and the "
    "torque T/(8πμa³Ω) where they rotate in step, c = 0.03; the force on a sphere in the duct "
    "20×7×7 with sliding walls, over their speed as Re → 0, and at Re = 10. Direct forcing marches "
    "to the steady state, in arrays with the centred quartic and ξ of 3 cells, in the duct with "
    "tanh and 1.3. The Stokes solver imposes rigid motion by iteration; smoothed viscosity takes a "
    "sphere a thousand times as viscous as the fluid, harmonic, ξ of a cell; force coupling stands "
    "in for a sphere with a force, a torque and a stresslet; all with what they take if nothing is "
    "said. Finite elements fit the sphere, of order 2 to 4. Seconds are those of a whole solve "
    "with its preparation, compiled code, all on the same threads; for elements in the duct both "
    "Reynolds numbers in one. Refined: cells as narrow around the sphere, wider away from it."
)


def run() -> Study:
    """Not in the thesis: a minute on four cores."""
    return study_of(solves(), with_elements=studies.can_run("dns"))


def solves() -> dict[str, dict[str, Meshes]]:
    """Problem -> method -> its meshes, coarsest first; body-fitted elements are not among them."""
    fine = {"array_027": (4, 6, 9), "array_1": (6, 9, 13), "array_216": (6, 9, 13)}
    finer = {"array_027": (4, 6, 9, 13), "array_1": (6, 9, 13, 18), "array_216": (6, 9, 13, 18)}
    found: dict[str, dict[str, Meshes]] = {
        name: {
            "forcing": _cells(forced_array, fine[name], c),
            "stokes": _cells(stokes_array, finer[name], c),
            "viscosity": _cells(viscous_array, finer[name][:-1], c),
            "coupling": _cells(coupled_array, (3, 4, 6), c),
        }
        for name, c in ARRAYS.items()
    }
    found["spin"] = {
        "forcing": _cells(forced_array, (4, 5, 6), SPUN, True),
        "stokes": _cells(stokes_array, (4, 6, 9), SPUN, True),
        "viscosity": _cells(viscous_array, (4, 6, 9), SPUN, True),
        "coupling": _cells(coupled_array, (3, 4, 6), SPUN, True),
    }
    found["creeping"] = {
        "forcing": _duct(forced_duct, ((3, False), (4, False), (6, True)), False),
        "stokes": _duct(stokes_duct, ((4, False), (6, True), (9, True))),
        "coupling": [(f"{n} cells", coupled_duct(n, False)) for n in (2, 3)],
    }
    found["inertia"] = {
        "forcing": _duct(forced_duct, ((3, False), (4, False), (6, True)), True),
        "coupling": [(f"{n} cells", coupled_duct(n, True)) for n in (2, 3)],
    }
    return found


def _cells(make: Callable[..., Solve], sizes: Sequence[int], share: float, *rest) -> Meshes:
    return [(f"{n} cells", make(share, n, *rest)) for n in sizes]


def _duct(make: Callable[..., Solve], meshes: Sequence[tuple[int, bool]], *rest) -> Meshes:
    return [
        (f"{n} cells, refined" if refined else f"{n} cells", make(n, *rest, refined))
        for n, refined in meshes
    ]


def study_of(wanted: Mapping[str, Mapping[str, Meshes]], with_elements: bool) -> Study:
    """The study of those solves, and of body-fitted elements, live or as stored."""
    found = {
        problem: {method: _all(meshes) for method, meshes in methods.items()}
        for problem, methods in wanted.items()
    }
    for problem, rows in (_elements(wanted) if with_elements else _stored(wanted)).items():
        found[problem]["elements"] = rows
    curves = {problem: _curve(problem, methods) for problem, methods in found.items()}
    return Study(
        title="Methods on the same problems",
        source="Not in the thesis",
        introduction=INTRODUCTION,
        findings=_findings(found, with_elements),
        rows=_rows(found),
        curves=curves,
        pictures=pictures(curves),
    )


Results = Mapping[str, Mapping[str, Sequence[tuple[str, Timed]]]]


def _all(meshes: Meshes) -> list[tuple[str, Timed]]:
    # The first compiles what is needed, so that the seconds are those of a solve.
    meshes[0][1]()
    return [(name, timed(solve)) for name, solve in meshes]


def _elements(wanted: Mapping) -> dict[str, list[tuple[str, Timed]]]:
    """Each order by itself; the duct's two numbers come from one run."""
    from smoothprofile.body_fitted.problems import cubic_array, duct

    rows: dict[str, list[tuple[str, Timed]]] = {name: [] for name in wanted if name in STORED}
    cubic_array(ARRAYS["array_216"], (2,))
    for problem in rows.keys() & ARRAYS.keys():
        for order in STORED[problem]:
            ladder = timed(lambda c=ARRAYS[problem], k=order: _one(cubic_array(c, (k,))))
            rows[problem].append((f"order {order}", ladder))
    for order in STORED["inertia"] if "inertia" in rows else ():
        begin = time.perf_counter()
        found = duct(orders=(order,))
        seconds = time.perf_counter() - begin
        for problem, ladder in {"creeping": found.creeping, "inertia": found.force}.items():
            rows[problem].append((f"order {order}", Timed(*_one(ladder), seconds)))
    return rows


def _one(ladder) -> tuple[float, int]:
    return float(ladder.values[0]), int(ladder.unknowns[0])


def _stored(wanted: Mapping) -> dict[str, list[tuple[str, Timed]]]:
    return {
        problem: [(f"order {order}", Timed(*row)) for order, row in rows.items()]
        for problem, rows in STORED.items()
        if problem in wanted
    }


def _curve(problem: str, methods: Mapping) -> dict[str, np.ndarray]:
    rows = [(method, name, one) for method, found in methods.items() for name, one in found]
    return {
        "method": np.array([method for method, _, _ in rows]),
        "mesh": np.array([name for _, name, _ in rows]),
        "unknowns": np.array([one.cells for *_, one in rows]),
        "value": np.array([one.value for *_, one in rows]),
        "error": np.array([_error(problem, one) for *_, one in rows]),
        "seconds": np.array([one.seconds for *_, one in rows]),
    }


def _error(problem: str, one: Timed) -> float:
    """In %."""
    return 100.0 * (one.value / EXACT[problem] - 1.0)


def _rows(found: Results) -> list[Row]:
    rows = []
    for problem, methods in found.items():
        for method, meshes in methods.items():
            name, one = meshes[-1]
            alone = method == "coupling" and problem in CROWDED
            unit = "" if method == "elements" else " to a radius"
            words = f"{name.replace(' cells', ' cells' + unit)}, {one.seconds:.2g} s"
            rows.append(
                Row(
                    f"{PROBLEMS[problem]}: {METHODS[method]}",
                    *(None, None if alone else EXACT[problem], one.value),
                    REACH[method] * EXACT[problem],
                    f"{_percent(_error(problem, one))}; {words}",
                )
            )
    return rows


def _percent(value: float) -> str:
    return f"{value:+.2g} %".replace("-", "−")


def _findings(found: Results, live: bool) -> tuple[str, ...]:
    told = []
    for problem, methods in found.items():
        parts = [
            f"{METHODS[method]} {_percent(_error(problem, meshes[-1][1]))} in "
            f"{meshes[-1][1].seconds:.2g} s"
            for method, meshes in methods.items()
        ]
        told.append(f"{PROBLEMS[problem]}: {', '.join(parts)}.")
    return (
        *told,
        "At Re = 0 the Stokes solver is the one to take: without a march in time it needs a "
        "fraction of direct forcing's seconds for less error, and it knows walls.",
        "Force coupling is the cheapest by far while spheres are two radii and more apart; what "
        "its envelopes leave out does not shrink with the mesh.",
        "With inertia direct forcing on a refined mesh is within a quarter of a percent. Finite "
        "elements gain most with each order, for a sphere that stays where it is.",
        "Seconds are on "
        + ("one thread" if thread_count() == 1 else f"{thread_count()} threads")
        + ("." if live else "; those of finite elements are stored ones, of another machine."),
    )
