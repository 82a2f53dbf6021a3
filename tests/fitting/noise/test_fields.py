"""White noise and random fields on a surface: which explanation is likely, and how large its parts are."""

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from primfit.fitting.cloud.patches import Halved, strips_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise import fields
from primfit.fitting.noise._noise import solve_fields
from primfit.fitting.noise.fields import Explanations, Patched, explanations, log_mean
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.solver.refine import linearize, refine
from primfit.fitting.verdict import judge
from tests.fitting.pieces import bar, kinds, pipe, sheet

Patch = pytest.MonkeyPatch
NOISE = 0.01


def square(n: int, seed: int = 0) -> Array:
    return np.column_stack([np.random.default_rng(seed).uniform(-0.5, 0.5, (n, 2)), np.zeros(n)])


def explained(height: Array, feet: Array) -> Explanations:
    """Of a plane that is fitted to points so high above it."""
    points = feet + height[:, None] * [0.0, 0.0, 1.0]
    plane = refine(Plane([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]), points).primitive
    residual, jacobian = linearize(plane, points)
    patched = Patched.of(
        Halved.of(feet).patches(), Halved.of(feet).grains(), residual, jacobian, feet / np.sqrt(2.0)
    )
    return explanations(patched, np.sqrt(2.0), 1e-12)


def rough_field(feet: Array, span: float, seed: int) -> Array:
    apart = np.linalg.norm(feet[:, None] - feet[None], axis=2)
    covariance = np.exp(-apart / span) + 1e-9 * np.eye(len(feet))
    return np.linalg.cholesky(covariance) @ np.random.default_rng(seed).normal(size=len(feet))


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


def test_white_noise_is_told_and_measured() -> None:
    found = explained(NOISE * np.random.default_rng(1).normal(size=4000), square(4000))
    best = found.likeliest
    assert found.white[best] == pytest.approx(NOISE, rel=0.1)
    assert found.smooth[best] < 0.2 * NOISE and found.rough[best] < 0.3 * NOISE
    assert found.unexplained is not None and found.unexplained < 15.0


def test_a_smooth_deviation_is_told_and_measured() -> None:
    feet = square(4000)
    wave = np.cos(7.0 * feet[:, 0])
    wave *= 3.0 * NOISE / np.sqrt(np.mean(wave**2))
    found = explained(wave + NOISE * np.random.default_rng(2).normal(size=4000), feet)
    best = found.likeliest
    assert found.smooth[best] == pytest.approx(3.0 * NOISE, rel=0.2)
    assert found.white[best] == pytest.approx(NOISE, rel=0.2)
    assert found.unexplained is not None and found.unexplained > 30.0


def test_a_rough_deviation_is_told() -> None:
    feet = square(1500)
    field = 2.0 * NOISE * rough_field(feet, 0.2, seed=3)
    found = explained(field + NOISE * np.random.default_rng(4).normal(size=1500), feet)
    assert found.rough[found.likeliest] > 0.5 * NOISE


def test_waves_shorter_than_a_patch_are_hidden_in_it() -> None:
    feet = square(20_000)
    ripple = 3.0 * NOISE * np.cos(120.0 * feet[:, 0])
    found = explained(ripple + 0.5 * NOISE * np.random.default_rng(5).normal(size=20_000), feet)
    assert found.hidden > NOISE
    assert explained(NOISE * np.random.default_rng(5).normal(size=20_000), feet).hidden < 0.2 * NOISE


def test_parameters_that_hardly_move_the_surface_have_their_price() -> None:
    """A sphere of 10,000 extents is no cheaper than a plane: its curvature is a direction, too."""
    feet = square(3000)
    points = feet + NOISE * np.random.default_rng(6).normal(size=3000)[:, None] * [0.0, 0.0, 1.0]
    evidence = []
    for surface in (
        Plane([0, 0, 1], [0, 0, 0]),
        Sphere([0.0, 0.0, -1e4], 1e4),
        Cylinder([1, 0, 0], [0, 0, -1e4], 1e4),
    ):
        residual, jacobian = linearize(surface, points)
        patched = Patched.of(
            Halved.of(feet).patches(), Halved.of(feet).grains(), residual, jacobian, feet / np.sqrt(2.0)
        )
        evidence.append(log_mean(explanations(patched, np.sqrt(2.0), 1e-12).log_evidence))
    assert evidence[0] - evidence[1] > 3.0 and evidence[0] - evidence[2] > 3.0


def test_places_a_turn_apart_are_the_same() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    patched = Patched.of(
        strips_of(angle), strips_of(angle), np.zeros(256), np.ones((256, 1)), angle[:, None], 2.0 * np.pi
    )
    assert patched.apart.max() == pytest.approx(np.pi, rel=0.05)
    assert patched.apart[0, -1] == pytest.approx(patched.apart[0, 1])


def test_a_mean_of_likelihoods_does_not_overflow() -> None:
    assert log_mean(np.array([1000.0, 1000.0])) == pytest.approx(1000.0)
    assert log_mean(np.array([])) == -np.inf


def test_systems_of_fields_are_those_of_their_covariance() -> None:
    """Built and solved by NumPy and SciPy; a size of 0 leaves a field out."""
    draws, patches = np.random.default_rng(7), 24
    places = draws.uniform(size=(patches, 2))
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    bells = np.array([np.exp(-apart / 0.3), np.exp(-0.5 * (apart / 0.2) ** 2)])
    white, columns = draws.uniform(0.5, 2.0, patches), draws.normal(size=(patches, 3))
    which, sizes = np.array([[0, 1], [0, 1], [0, 1]]), np.array([[0.0, 0.0], [2.0, 0.0], [0.5, 3.0]])
    halved, solved, root = solve_fields(white, bells, which, sizes, columns)
    for t, (rough, smooth) in enumerate(sizes):
        covariance = np.diag(white) + rough**2 * bells[0] + smooth**2 * bells[1]
        lower = np.linalg.cholesky(covariance)
        np.testing.assert_allclose(halved[t], solve_triangular(lower, columns, lower=True), rtol=1e-9)
        np.testing.assert_allclose(solved[t], np.linalg.solve(covariance, columns), rtol=1e-9, atol=1e-12)
        assert root[t] == pytest.approx(0.5 * np.linalg.slogdet(covariance)[1])


def test_a_covariance_that_is_none_has_no_likelihood() -> None:
    bell = np.array([[[1.0, 2.0], [2.0, 1.0]]])
    root = solve_fields(np.full(2, 1e-3), bell, np.array([[0]]), np.array([[1.0]]), np.ones((2, 1)))[2]
    assert np.isinf(root).all()
