"""Outliers, dents, second surfaces and curves: what each number of the evidence is for."""

import numpy as np
import pytest

from primfit.fitting.recognize import recognize
from primfit.fitting.verdict import evidence
from tests.fitting.pieces import ball, beside_a_plane, inlier_share, kinds, pipe, rings, sheet, stray

Patch = pytest.MonkeyPatch


def test_where_no_point_is_an_outlier_stray_ones_count(monkeypatch: Patch) -> None:
    """`OUTLIER`"""
    points = stray(pipe(1500, 0.005, 6), 0.2, 6)
    answer = recognize(points)
    assert kinds(answer) == ["cylinder"] and inlier_share(answer) == pytest.approx(0.81, abs=0.02)
    monkeypatch.setattr(evidence, "OUTLIER", np.inf)
    answer = recognize(points)
    assert "cone" in kinds(answer) and inlier_share(answer) == 1.0


def test_where_outliers_are_unlikely_a_ball_among_many_is_none(monkeypatch: Patch) -> None:
    """`OUTLIERS`"""
    points = stray(ball(1500, 1e-4, 7), 0.6, 7)
    assert kinds(recognize(points)) == ["sphere"]
    monkeypatch.setattr(evidence, "OUTLIERS", 1e-4)
    assert kinds(recognize(points)) == []


def test_beside_exact_points_a_large_dent_is_no_surface_of_its_own(monkeypatch: Patch) -> None:
    """`EXACT_REACH`"""
    points = ball(1500, 0.0, 9)
    top = points[:, 2] > 0.4
    points[top] *= 1.0 - 0.1 * np.minimum(1.0, 3.0 * (points[top, 2:] - 0.4))
    assert kinds(recognize(points)) == ["sphere"]
    monkeypatch.setattr(evidence, "EXACT_REACH", 0.01)
    assert kinds(recognize(points)) == []


def test_a_plane_beside_a_pipe_is_seen_and_strewn_points_are_none(monkeypatch: Patch) -> None:
    """`FLAT`"""
    beside, strewn = (
        beside_a_plane(pipe(1500, 0.005, 10), 0.35, 0.005, 10),
        stray(pipe(1500, 0.005, 10), 0.5, 10),
    )
    assert kinds(recognize(beside)) == [] and kinds(recognize(strewn)) == ["cylinder"]
    monkeypatch.setattr(evidence, "FLAT", 0.0)
    assert kinds(recognize(beside)) == ["cylinder"]
    monkeypatch.setattr(evidence, "FLAT", 1.0)
    assert kinds(recognize(strewn)) == []


def test_rings_are_asked_for_curves_and_noisy_pipes_are_not(monkeypatch: Patch) -> None:
    """`QUIET`: within much noise quadrics pass through every arc."""
    arc = pipe(800, 0.002, 12, arc=1.0)
    assert {"sphere", "cone"} <= {*kinds(recognize(rings()))} and kinds(recognize(arc)) == ["cylinder"]
    monkeypatch.setattr(evidence, "QUIET", 0.0)
    assert kinds(recognize(rings())) == ["sphere"]
    monkeypatch.setattr(evidence, "QUIET", np.inf)
    assert "cone" in kinds(recognize(arc))


def test_quadrics_of_a_surface_itself_are_no_curves() -> None:
    assert kinds(recognize(sheet(500, 1e-5, 13))) == ["plane"]
    assert kinds(recognize(ball(500, 1e-5, 13))) == ["sphere"]


def test_where_any_radius_is_likely_a_bowed_sheet_is_a_huge_ball(monkeypatch: Patch) -> None:
    """By half of its noise it is a plane; what is bowed by as much as that, and seen often, is a dome."""
    points = sheet(400, 0.005, 14, bow=0.0025)
    assert kinds(recognize(points)) == ["plane"]
    assert kinds(recognize(sheet(3000, 0.005, 15, bow=0.005))) == ["sphere"]
    monkeypatch.setattr(evidence, "_sizes", lambda *_: 0.0)
    assert "sphere" in kinds(recognize(points))
