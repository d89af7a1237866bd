"""What a step costs, against an FFT round trip and a memory copy in the same process.

Ratios, never seconds alone: machines differ and are shared.
"""

import time
from pathlib import Path

import numpy as np

from smoothprofile.config import load_case
from smoothprofile.simulation import Simulation
from smoothprofile.threads import thread_count
from smoothprofile.transforms import fourier_round_trip

ROUNDS = 7
WARM_UP = ["domain.cells=[8,8,8]", "profile.retract=false", "time.step=0.01"]


def measure(case: str, overrides: list[str]) -> dict:
    """Best times of several rounds that take step, round trip and copy in turn."""
    # Everything is compiled, and every library loaded, before memory is counted.
    for _ in range(3):
        warm = Simulation(load_case(case, [*overrides, *WARM_UP]))
        warm.step_once()
    del warm
    _forget_peak()
    baseline = _memory("VmRSS")
    simulation = Simulation(load_case(case, overrides))
    simulation.step_once()
    simulation.step_once()
    step = _best(simulation.step_once, ROUNDS)
    peak = _memory("VmHWM")
    shape, dtype = simulation.grid.shape, simulation.grid.dtype
    round_trip = fourier_round_trip(shape, dtype)
    source = np.ones(simulation.grid.padded_shape, dtype)
    target = np.empty_like(source)
    transform, copy, steps = [], [], [step]
    for _ in range(ROUNDS):
        transform.append(_best(round_trip, 1))
        copy.append(_best(lambda: np.copyto(target, source), 1))
        steps.append(_best(simulation.step_once, 1))
    cells = simulation.grid.cell_count
    bytes_per_field = cells * np.dtype(dtype).itemsize
    return {
        "case": simulation.case.title,
        "cells": cells,
        "shape": list(shape),
        "threads": thread_count(),
        "step_seconds": min(steps),
        "fft_round_trip_seconds": min(transform),
        "copy_seconds": min(copy),
        "ratio": min(steps) / min(transform),
        "ratio_to_copy": min(steps) / min(copy),
        "nanoseconds_per_cell": 1e9 * min(steps) / cells,
        "peak_fields_per_cell": (peak - baseline) / bytes_per_field if peak else None,
    }


def _best(action, rounds: int) -> float:
    times = []
    for _ in range(rounds):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return min(times)


def _memory(entry: str) -> int:
    """VmRSS or VmHWM of this process in bytes; 0 where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.is_file():
        return 0
    for line in status.read_text().splitlines():
        if line.startswith(entry + ":"):
            return int(line.split()[1]) * 1024
    return 0


def _forget_peak() -> None:
    """Let VmHWM start anew from what is in use now; where not allowed, the old peak counts."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return
