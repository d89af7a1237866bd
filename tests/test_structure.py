"""Chains, bonds and pairs of beads whose places are known."""

import math

import numpy as np
import pytest

from smoothprofile.structure import (
    Beads,
    alignment,
    bonds,
    chain_of,
    measures,
    pair_distribution,
    smallest_gap,
)
from smoothprofile.structure_plots import (
    chains_picture,
    energy_picture,
    pairs_picture,
    stress_picture,
)

Z = (0.0, 0.0, 1.0)


def beads(position, radius=1.0, lengths=(20.0, 20.0, 20.0), periodic=(True, True, True), low=0.0):
    position = np.asarray(position, dtype=float)
    radius = np.broadcast_to(np.asarray(radius, dtype=float), len(position)).copy()
    return Beads(position, radius, np.full(3, low), np.array(lengths), np.array(periodic))


def test_chains_across_a_periodic_side_are_whole():
    """Three beads in a row through z = 0, two apart from them, one alone: 3, 2, 1."""
    row = [(5, 5, 19.0), (5, 5, 21.1), (5, 5, 23.2)]
    found = measures(beads([*row, (10, 10, 10), (12.1, 10, 10), (15, 15, 3)]), Z)
    assert found["mean_chain_length"] == pytest.approx(2.0)
    assert found["mass_mean_chain_length"] == pytest.approx((9 + 4 + 1) / 6)
    assert found["longest_chain"] == 3
    # Two bonds along the field, one across it.
    assert found["alignment"] == pytest.approx((1 + 1 - 0.5) / 3)
    assert found["smallest_gap"] == pytest.approx(0.1)
    walled = measures(beads([*row, (12, 10, 10)], periodic=(True, True, False)), Z)
    assert walled["longest_chain"] == 3
    split = measures(beads(np.mod(row, 20.0), periodic=(True, True, False)), Z)
    assert split["longest_chain"] == 2


def test_bonds_end_at_their_share_of_the_mean_radius():
    rows, apart = bonds(beads([(1, 1, 1), (1, 1, 4.44)], radius=[1.0, 2.0]))
    assert rows.tolist() == [[0, 1]] and apart == pytest.approx(np.array([[0, 0, 3.44]]))
    # η(a₁+a₂)/2 = .45 here: a gap of .46 is no bond, though less than η times the larger radius.
    assert len(bonds(beads([(1, 1, 1), (1, 1, 4.46)], radius=[1.0, 2.0]))[0]) == 0


def test_a_ring_is_one_chain_and_no_bonds_are_none():
    angle = np.arange(8) * math.pi / 4
    radius = 2.1 / (2 * math.sin(math.pi / 8))
    ring = np.stack([10 + radius * np.cos(angle), 10 + radius * np.sin(angle), 0 * angle], axis=1)
    rows, _ = bonds(beads(ring))
    assert len(rows) == 8 and set(chain_of(8, rows)) == {0}
    lone = measures(beads([(1, 1, 1), (9, 9, 9)]), Z)
    assert lone["mean_chain_length"] == 1.0 and math.isnan(lone["alignment"])


def test_the_smallest_gap_is_that_of_surfaces_not_of_centres():
    """Small beads 1 apart by centre with a gap of .8; large ones 6.5 apart with one of .5."""
    places = [(1, 1, 1), (1, 1, 2), (8, 8, 8), (8, 8, 14.5)]
    assert smallest_gap(beads(places, radius=[0.1, 0.1, 3.0, 3.0])) == pytest.approx(0.5)
    assert smallest_gap(beads([(1, 1, 0.5), (1, 1, 19.0)])) == pytest.approx(-0.5)
    assert smallest_gap(beads([(1, 1, 1)])) == math.inf


def test_alignment_of_bonds_anywhere_is_none():
    directions = np.random.default_rng(1).normal(size=(20_000, 3))
    # The standard error of P₂ over directions anywhere is 1/√(5·20000) = .003.
    assert abs(alignment(directions, Z)) < 0.01


@pytest.mark.parametrize("walls", [False, True])
def test_points_anywhere_have_a_pair_distribution_of_one(walls):
    """Between walls too, where half of a pair's surroundings would lie outside."""
    generator, periodic = np.random.default_rng(2), (True, True, not walls)
    low = np.array([0.0, 0.0, 0.5 * walls])
    places = low + generator.random((1500, 3)) * ([12.0, 12.0, 8.0] - 2 * low)
    found = pair_distribution(beads(places, 0.5, (12.0, 12.0, 8.0), periodic), Z)
    far = found["r"] > 1.0
    for name in ("g", "g_along", "g_across"):
        # 40 to 1000 pairs in each of some sixty bins: their mean is good to half a per cent.
        assert np.mean(found[name][far]) == pytest.approx(1.0, abs=0.02)
    assert np.mean(found["g"][far][-10:]) == pytest.approx(1.0, abs=0.02)


def test_pairs_in_chains_stand_along_the_field():
    row = [(x, x, 2.2 * k) for k in range(9) for x in (2.0, 8.0, 14.0)]
    found = pair_distribution(beads(row), Z)
    peak = np.argmin(np.abs(found["r"] - 2.2))
    near = slice(peak - 1, peak + 2)
    assert found["g_along"][near].max() > 5 * found["g"][near].max() > 0
    assert found["g_across"][near].max() == 0


def test_the_energy_that_falls_is_seen_through_an_alternating_field():
    """ε grows by 5 % while the field swings: what is drawn falls with ε at the mean square."""
    time = np.linspace(0.1, 20.0, 200)
    along, square = 1.25 + 0.003 * time, np.cos(0.7 * time) ** 2
    length = np.ones_like(time)
    for swing, size in ((square, square.mean()), (length, 1.0)):
        history = {
            "time": time,
            "permittivity_along": along,
            "electric_energy": 30.0 * along * swing,
            "mean_chain_length": length,
        }
        picture = energy_picture(history)
        drawn = picture.figure.axes[0].lines[0].get_ydata()
        assert drawn == pytest.approx(-30.0 * size * (along - along[0]), abs=1e-12)
        assert ("mean square" in picture.caption) == (swing is square)


def test_lone_beads_are_said_to_have_no_bonds():
    time, ones = np.arange(4.0), np.ones(4)
    history = {
        "time": time, "mean_chain_length": ones, "mass_mean_chain_length": ones,
        "longest_chain": ones, "alignment": np.full(4, np.nan), "smallest_gap": ones,
    }  # fmt: skip
    bonds_axes = chains_picture(history).figure.axes[1]
    assert [text.get_text() for text in bonds_axes.texts] == ["no bonds"]
    assert not chains_picture(history | {"alignment": ones}).figure.axes[1].texts


def test_stresses_that_a_case_has_not_are_left_out():
    none, some = np.zeros(4), np.ones(4)
    history = {
        "time": np.arange(4.0), "wall_stress": some, "viscous_stress": some,
        "contact_stress": none, "electric_stress": none,
    }  # fmt: skip
    legend = stress_picture(history).figure.legends[0]
    assert [text.get_text() for text in legend.get_texts()] == ["on the walls", "viscous"]


def test_only_where_there_is_inertia_the_rest_of_the_stress_is_inertia():
    names = ("time", "wall_stress", "viscous_stress", "contact_stress", "electric_stress")
    history = dict.fromkeys(names, np.arange(4.0))
    assert "inertia" in stress_picture(history).caption
    assert "inertia" not in stress_picture(history, inertia=False).caption


def test_pairs_are_drawn_where_some_are_near():
    table = {"r": np.arange(1.0, 5.0)} | {
        name: np.zeros(4) for name in ("g", "g_along", "g_across")
    }
    assert pairs_picture(table) is None
    assert pairs_picture(table | {"g": np.array([0.0, 1.0, 1.0, 1.0])}) is not None
