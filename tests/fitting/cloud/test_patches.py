"""Patches and grains: of equal size, of neighbors, and what goes wrong where they are of other sizes."""

import itertools

import numpy as np
import pytest

from primfit.fitting.cloud import patches
from primfit.fitting.cloud._pieces import halves, numbered
from primfit.fitting.cloud.patches import GRAIN, PATCHES, Halved, strips_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.verdict import evidence
from tests.fitting.pieces import bar, kinds, sheet

Patch = pytest.MonkeyPatch


def square(n: int, seed: int = 0) -> Array:
    return np.column_stack([np.random.default_rng(seed).uniform(-0.5, 0.5, (n, 2)), np.zeros(n)])


def test_a_folded_sheet_in_few_patches_is_a_cylinder(monkeypatch: Patch) -> None:
    """`PATCHES`: in pieces of a third of the cloud the fold is lost."""
    points = sheet(1500, 0.003, 1)
    points[:, 2] += 0.3 * np.abs(points[:, 0])
    assert kinds(recognize(points)) == []
    for module in (patches, evidence):
        monkeypatch.setattr(module, "PATCHES", 8)
    monkeypatch.setattr(evidence, "strips_of", lambda values, most=8: strips_of(values, most))
    assert kinds(recognize(points)) == ["cylinder"]


def test_without_neighbors_in_grains_a_rod_of_twelve_faces_is_round(monkeypatch: Patch) -> None:
    """`GRAIN`: in pieces of a point nothing tells what its own scatter is, beside which faces are seen."""
    points = bar(12, 6000, 0.001, 1)
    assert kinds(recognize(points)) == []
    for module in (patches, evidence):
        monkeypatch.setattr(module, "GRAIN", 1)
    assert kinds(recognize(points)) == ["cylinder"]


@pytest.mark.parametrize("n", [60, 500, 20_000])
def test_patches_are_of_equal_size_and_hold_neighbors(n: int) -> None:
    feet = square(n)
    halved = Halved.of(feet)
    count = np.bincount(halved.patches())
    assert len(count) == min(n, PATCHES) and np.ptp(count) <= 1
    widths = [np.ptp(feet[halved.patches() == each], axis=0).max() for each in range(len(count))]
    assert max(widths) < 0.3
    assert np.bincount(halved.grains()).max() <= max(2 * GRAIN, -(-n // PATCHES))
    assert np.array_equal(strips_of(np.arange(128.0)), np.arange(128) // 2)


@pytest.mark.parametrize("n", [64, 100, 1001])
def test_halves_are_equal_nested_and_cut_where_the_cloud_is_widest(n: int) -> None:
    points = np.random.default_rng(n).normal(size=(n, 3)) * [3.0, 2.0, 1.0]
    order = halves(points, 4)
    numbers = [numbered(order, times) for times in range(5)]
    for coarse, fine in itertools.pairwise(numbers):
        np.testing.assert_array_equal(fine // 2, coarse)
        for piece in np.unique(coarse):
            widest = int(np.argmax(np.ptp(points[coarse == piece], axis=0)))
            low, high = (points[fine == 2 * piece + side, widest] for side in (0, 1))
            assert low.max() <= high.min() and len(high) - len(low) in (0, 1)


def test_halves_of_equal_places_are_in_the_order_of_their_listing() -> None:
    assert numbered(halves(np.zeros((8, 3)), 2), 2).tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
