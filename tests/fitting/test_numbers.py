"""The numbers of patches, fields, evidence and verdict: for each, what goes wrong without it.

Those of the noise model stand in test_noise.py.
"""

from collections.abc import Mapping
from functools import partial

import numpy as np
import pytest

from primfit.fitting.answer.result import Recognition
from primfit.fitting.cloud import cloud, patches
from primfit.fitting.cloud.patches import patches_of, strips_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import KINDS
from primfit.fitting.noise import fields
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty import agreement
from primfit.fitting.verdict import evidence, judge

Patch = pytest.MonkeyPatch


class Sure:
    """A ranking that rules out every kind but one."""

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def rank(self, points: Array, normals: Array) -> Mapping[str, float]:
        return {kind: 1.0 - 4e-9 if kind == self.kind else 1e-9 for kind in KINDS}


def rng(*seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def sheet(n: int, noise: float, seed: int, bow: float = 0.0) -> Array:
    """A square of side 1; a bow is the standard deviation of the dome that it is."""
    x, y = rng(seed, 0).uniform(-0.5, 0.5, (2, n))
    dome = x**2 + y**2
    height = bow * (dome - dome.mean()) / dome.std() + noise * rng(seed, 1).normal(size=n)
    return np.column_stack([x, y, height])


def pipe(n: int, noise: float, seed: int, arc: float = 2.0 * np.pi) -> Array:
    """Of radius 1 and length 2."""
    angle = rng(seed, 0).uniform(-arc / 2.0, arc / 2.0, n)
    radius = 1.0 + noise * rng(seed, 1).normal(size=n)
    return np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), rng(seed, 2).uniform(-1.0, 1.0, n)]
    )


def ball(n: int, noise: float, seed: int) -> Array:
    """Of radius 1."""
    points = rng(seed, 0).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return np.asarray(points * (1.0 + noise * rng(seed, 1).normal(size=(n, 1))))


def bar(faces: int, n: int, noise: float, seed: int) -> Array:
    """The sides of a prism along z, 2 radii long, without ends."""
    side, along = rng(seed, 0).integers(faces, size=n), rng(seed, 1).random(n)
    corners = np.exp(2j * np.pi * np.arange(faces + 1) / faces)
    places = corners[side] + along * (corners[side + 1] - corners[side])
    places = places + noise * rng(seed, 2).normal(size=n) * np.exp(2j * np.pi * (side + 0.5) / faces)
    return np.column_stack([places.real, places.imag, rng(seed, 3).uniform(-1.0, 1.0, n)])


def stray(points: Array, share: float, seed: int) -> Array:
    """The points with a share of them anywhere in their box."""
    count = round(share * len(points))
    anywhere = rng(seed).uniform(points.min(axis=0), points.max(axis=0), (count, 3))
    return np.vstack([anywhere, points[count:]])


def beside_a_plane(points: Array, share: float, noise: float, seed: int) -> Array:
    """The points with a share of them on a plane that touches the pipe or ball."""
    count = round(share * len(points))
    places, height = rng(seed, 0).uniform(-1.5, 1.5, (count, 2)), noise * rng(seed, 1).normal(size=count)
    return np.vstack([np.column_stack([places, 1.0 + height]), points[count:]])


def rings(noise: float = 0.0) -> Array:
    """Two of a cone."""
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.5)
    points = np.vstack([cone.surface(angle, np.full(40, height)) for height in (1.0, 2.0)])
    return points + noise * rng(0).normal(size=points.shape)


def kinds(answer: Recognition) -> list[str]:
    """What the cloud may be, the best first; nothing where nothing fits."""
    if answer.status == "no_fit" or answer.primitive is None:
        return []
    return [answer.primitive.kind, *sorted(other.primitive.kind for other in answer.alternatives)]


def inlier_share(answer: Recognition) -> float:
    assert answer.error is not None
    return answer.error.inlier_share


# -- patches ------------------------------------------------------------------------------------------------


def test_a_folded_sheet_in_few_patches_is_a_cylinder(monkeypatch: Patch) -> None:
    """`PATCHES`: in pieces of a third of the cloud the fold is lost."""
    points = sheet(1500, 0.003, 1)
    points[:, 2] += 0.3 * np.abs(points[:, 0])
    assert kinds(recognize(points)) == []
    for module in (patches, evidence):
        monkeypatch.setattr(module, "PATCHES", 8)
    monkeypatch.setattr(cloud, "patches_of", partial(patches_of, most=8))
    monkeypatch.setattr(evidence, "strips_of", lambda values, most=8: strips_of(values, most))
    assert kinds(recognize(points)) == ["cylinder"]


def test_without_neighbours_in_grains_a_rod_of_twelve_faces_is_round(monkeypatch: Patch) -> None:
    """`GRAIN`: in pieces of a point nothing tells what its own scatter is, beside which faces are seen."""
    points = bar(12, 6000, 0.001, 1)
    assert kinds(recognize(points)) == []
    for module in (patches, evidence):
        monkeypatch.setattr(module, "GRAIN", 1)
    assert kinds(recognize(points)) == ["cylinder"]


# -- fields -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1.01, 10.0])
def test_a_bar_is_a_cylinder_where_sizes_of_fields_are_missing(monkeypatch: Patch, ratio: float) -> None:
    """`RATIO`: with steps too small large deviations are not looked at; with too large ones these are not."""
    points = bar(6, 3000, 0.003, 3)
    assert kinds(recognize(points)) == []
    monkeypatch.setattr(fields, "ROUGH", (1.0 / ratio, 1.0, ratio))
    monkeypatch.setattr(fields, "ROUGH_RANGES", (1.0 / ratio**2, 1.0 / ratio, 1.0))
    monkeypatch.setattr(fields, "SMOOTH", (1.0, ratio, ratio**2, ratio**3))
    monkeypatch.setattr(fields, "SMOOTH_RANGES", (0.5 / ratio, 1.0))
    monkeypatch.setattr(fields, "_grid", fields._grid.__wrapped__)
    assert kinds(recognize(points)) == ["cylinder"]


def test_parameters_that_cost_nothing_make_a_pipe_a_cone(monkeypatch: Patch) -> None:
    """`PRIOR`"""
    points = pipe(800, 0.005, 4)
    assert kinds(recognize(points)) == ["cylinder"]
    for module in (fields, judge):
        monkeypatch.setattr(module, "PRIOR", 0.0)
    assert "cone" in kinds(recognize(points))


def test_parameters_that_cost_too_much_hide_that_a_sheet_is_a_dome(monkeypatch: Patch) -> None:
    """`PRIOR`"""
    points = sheet(800, 0.005, 5, bow=0.007)
    assert kinds(recognize(points)) == ["sphere"]
    for module in (fields, judge):
        monkeypatch.setattr(module, "PRIOR", 1e3)
    assert kinds(recognize(points)) == []


# -- agreement ----------------------------------------------------------------------------------------------


def test_fields_are_neither_certain_nor_impossible(monkeypatch: Patch) -> None:
    """`FIELDS`: intervals are too long under independent noise, or too short under waves."""

    def deviation(points: Array, kind: str) -> float:
        known = recognize(points, Config(kinds=(kind,))).uncertainty
        assert known is not None and known.covariance is not None
        return float(np.sqrt(np.abs(np.asarray(known.covariance)).max()))

    white, wavy = ball(1000, 0.005, 2), sheet(1000, 0.005, 0)
    wavy[:, 2] += 0.005 * np.sin(9.0 * wavy[:, 0] + 1.0) * np.sin(7.0 * wavy[:, 1])
    usual = deviation(white, "sphere"), deviation(wavy, "plane")
    monkeypatch.setattr(agreement, "FIELDS", 0.9)
    assert deviation(white, "sphere") > 1.3 * usual[0]
    monkeypatch.setattr(agreement, "FIELDS", 1e-100)
    assert deviation(wavy, "plane") < 0.8 * usual[1]


# -- evidence -----------------------------------------------------------------------------------------------


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


# -- verdict ------------------------------------------------------------------------------------------------


def test_a_cone_on_a_short_arc_may_be_a_cylinder(monkeypatch: Patch) -> None:
    """`DECIDED`"""
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.3)
    points = cone.surface(rng(17, 0).uniform(-0.15, 0.15, 1000), rng(17, 1).uniform(1.0, 2.0, 1000))
    points = points + 0.002 * rng(17, 2).normal(size=points.shape)
    assert kinds(recognize(points)) == ["cylinder", "cone"]
    monkeypatch.setattr(judge, "DECIDED", 0.0)
    assert kinds(recognize(points)) == ["cylinder"]


def test_a_ranking_that_is_never_mistaken_makes_an_arc_a_plane(monkeypatch: Patch) -> None:
    """`MISTAKEN`"""
    points = pipe(300, 0.005, 18, arc=0.6)
    assert kinds(recognize(points, classifier=Sure("plane"))) == ["cylinder"]
    monkeypatch.setattr(judge, "MISTAKEN", 1e-12)
    assert kinds(recognize(points, classifier=Sure("plane"))) == ["plane"]


def test_an_exact_rod_of_forty_faces_passes_for_round_and_one_of_six_does_not(monkeypatch: Patch) -> None:
    """`FORM`"""
    fine, coarse = bar(40, 3000, 0.0, 19), bar(6, 3000, 0.0, 19)
    assert kinds(recognize(fine)) == ["cylinder"] and kinds(recognize(coarse)) == []
    monkeypatch.setattr(judge, "FORM", 0.0)
    assert kinds(recognize(fine)) == []
    monkeypatch.setattr(judge, "FORM", 0.1)
    assert kinds(recognize(coarse)) == ["cylinder"]


def test_a_filled_cube_is_no_surface(monkeypatch: Patch) -> None:
    """`SCATTER`"""
    points = rng(20).uniform(-1.0, 1.0, (1500, 3))
    assert kinds(recognize(points)) == []
    monkeypatch.setattr(judge, "SCATTER", np.inf)
    assert kinds(recognize(points))


def test_a_third_of_the_points_on_a_plane_is_a_second_surface(monkeypatch: Patch) -> None:
    """`PART`"""
    points = beside_a_plane(pipe(1500, 0.005, 22), 0.35, 0.005, 22)
    assert kinds(recognize(points)) == []
    monkeypatch.setattr(judge, "PART", 0.4)
    assert kinds(recognize(points)) == ["cylinder"]


def test_a_few_strewn_points_in_a_row_are_no_second_surface(monkeypatch: Patch) -> None:
    """`PART`"""
    points = stray(pipe(1500, 0.005, 23), 0.5, 23)
    assert kinds(recognize(points)) == ["cylinder"]
    monkeypatch.setattr(judge, "PART", 0.0)
    assert kinds(recognize(points)) == []


def test_some_exact_points_more_do_not_make_a_ball_a_torus(monkeypatch: Patch) -> None:
    """`EQUAL_SHARES`: among points that are moved by some steps a torus finds more that it passes through."""
    points = ball(600, 0.0, 25)
    points[:300] += rng(25).uniform(-0.002, 0.002, (300, 3))
    points = np.round(points, 3)
    assert kinds(recognize(points)) == ["sphere"]
    monkeypatch.setattr(judge, "EQUAL_SHARES", 0.0)
    assert kinds(recognize(points)) == ["torus"]
