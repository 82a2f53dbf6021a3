"""Histograms of normals and of surflet pairs, and how they are compared."""

import numpy as np
import pytest

from primfit.paper.parts.local_histograms import LEVELS, levels, peaked, shares_of
from primfit.paper.parts.nearest import References
from primfit.paper.parts.normal_histograms import CELLS, histogram, recentred
from primfit.paper.parts.surflets import PARTS, relations, surflet_histogram


def units(count: int, seed: int = 0) -> np.ndarray:
    found = np.random.default_rng(seed).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_signs_of_normals_do_not_matter():
    normals = units(500)
    signs = np.where(np.random.default_rng(1).random(500) < 0.5, -1.0, 1.0)
    np.testing.assert_allclose(histogram(normals), histogram(normals * signs[:, None]))
    assert histogram(normals).sum() == pytest.approx(1.0)


def test_normals_fall_in_the_cell_of_zenith_and_azimuth():
    shares = histogram(np.array([[1.0, 0.0, 1e-6]]))
    assert shares[CELLS // 2, CELLS // 2] == 0.5 and shares.sum() == 1.0


def test_a_histogram_has_each_of_its_peaks_in_the_middle_once():
    shares = np.zeros((CELLS, CELLS))
    shares[3, 4], shares[20, 11], shares[7, 7] = 0.5, 0.4, 0.1
    found = recentred(shares)
    assert found[:, CELLS // 2, CELLS // 2].tolist() == [0.5, 0.4]
    assert found.sum(axis=(1, 2)) == pytest.approx([1.0, 1.0])
    assert recentred(np.zeros((CELLS, CELLS))).shape == (0, CELLS, CELLS)


def test_relations_of_a_known_pair():
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    normals = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    ((turn, _, along, length),) = relations(points, normals)
    assert along == pytest.approx(1.0) and length == 1.0
    assert 0.0 <= turn <= 1.0


def test_relations_turn_with_the_cloud_and_do_not_know_signs():
    rng = np.random.default_rng(2)
    points, normals = rng.normal(size=(20, 3)), units(20)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    signs = np.where(rng.random(20) < 0.5, -1.0, 1.0)[:, None]
    found = relations(points, normals)
    np.testing.assert_allclose(relations(points @ turn.T, normals @ turn.T), found, atol=1e-9)
    np.testing.assert_allclose(relations(points, normals * signs), found, atol=1e-9)
    assert found.min() >= 0.0 and found.max() <= 1.0
    assert surflet_histogram(points, normals).sum() == pytest.approx(1.0)
    assert surflet_histogram(points[:1], normals[:1]).tolist() == [0.0] * PARTS**4


def test_what_is_stored_is_near_what_was_counted():
    shares = histogram(units(400))
    stored = levels(np.sqrt(shares))
    assert stored.dtype == np.uint8
    np.testing.assert_allclose(np.sqrt(shares_of(stored)), np.sqrt(shares).ravel(), atol=0.5 / LEVELS + 1e-9)
    assert (peaked(stored) ** 2).sum(axis=1) == pytest.approx(np.full(len(peaked(stored)), 1.0), abs=0.05)


def test_votes_are_shares_of_the_nearest():
    rows = np.array([[0.0], [1.0], [2.0], [10.0]], np.float32)
    references = References(rows, np.array([0, 0, 1, 2]))
    assert references.votes(np.array([[0.4]], np.float32), 3, 3) == pytest.approx([2 / 3, 1 / 3, 0.0])
    both = np.array([[0.4], [9.0]], np.float32)
    assert references.votes(both, 1, 3) == pytest.approx([0.5, 0.0, 0.5])
    assert references.of(np.array([False, True, True])).labels.tolist() == [1, 2]
    assert references.votes(np.empty((0, 1), np.float32), 3, 3) == pytest.approx([1 / 3] * 3)
