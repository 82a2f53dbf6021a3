"""White noise and random fields on a surface: which explanation is likely, and how large its parts are."""

import dataclasses

import numpy as np
import pytest

from primfit.fitting.cloud.patches import Halved, strips_of
from primfit.fitting.fields import fields
from primfit.fitting.fields.fields import Explanations, Patched, explanations, log_mean
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.solver.refine import linearize, refine
from primfit.fitting.verdict import judge
from tests.fitting.fields import reference_fields as reference
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


def some_patches(seed: int, kind: str, n: int = 700, turn: float = 0.0) -> tuple[np.ndarray, ...]:
    """Points with the numbers of their patches and grains, residuals, derivatives and places."""
    draws = np.random.default_rng(seed)
    feet = draws.uniform(-0.5, 0.5, (n, 3)) * [1.0, 0.6, 0.05]
    wave = {"white": 0.0, "bowed": 0.02, "wrong": 0.3}[kind] * np.cos(5.0 * feet[:, 0])
    residual = wave + 0.01 * draws.normal(size=n)
    jacobian = np.column_stack([np.ones(n), feet[:, :2], feet[:, 0] ** 2, 1e-4 * feet[:, 0] * feet[:, 1]])
    place = feet if not turn else np.arctan2(feet[:, 1], feet[:, 0])[:, None]
    return strips_of(place[:, 0]), strips_of(feet[:, 1], max(64, n // 8)), residual, jacobian, place


def close(found: Explanations, expected: Explanations) -> None:
    for field in dataclasses.fields(Explanations):
        ours, theirs = (getattr(each, field.name) for each in (found, expected))
        if theirs is None:
            assert ours is None
            continue
        scale = np.abs(np.where(np.isfinite(theirs), theirs, 0.0)).max(initial=0.0)
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * scale, err_msg=field.name)


@pytest.mark.parametrize("kind", ["white", "bowed", "wrong"])
@pytest.mark.parametrize(
    ("seed", "n", "turn"), [(1, 700, 0.0), (2, 53, 0.0), (3, 90, 0.0), (4, 700, 2.0 * np.pi)]
)
def test_fields_are_those_of_numpy(kind: str, seed: int, n: int, turn: float) -> None:
    """Patches of single points, of unequal numbers, and on a circle, on which bells are no covariance."""
    given = some_patches(seed, kind, n, turn)
    few = np.arange(n) % 5 > 0
    for points in (given, tuple(each[few] for each in given)):
        found, expected = Patched.of(*points, turn), reference.patched(*points, turn)
        for field in dataclasses.fields(Patched):
            np.testing.assert_allclose(
                getattr(found, field.name), getattr(expected, field.name), rtol=1e-11, atol=1e-13
            )
        close(explanations(found, 1.2, 1e-12), reference.explanations(expected, 1.2, 1e-12))


def test_numbers_without_points_are_no_patches() -> None:
    patch, grain, *rest = some_patches(5, "bowed")
    found, expected = Patched.of(3 * patch + 1, grain, *rest), Patched.of(patch, grain, *rest)
    for field in dataclasses.fields(Patched):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(expected, field.name))


@pytest.mark.parametrize("seen", [0, 2, 5])
def test_parameters_may_be_none_and_may_move_nothing(seen: int) -> None:
    """Where limits hold all of them; and one that does not move the surface costs and explains nothing."""
    patch, grain, residual, jacobian, place = some_patches(6, "bowed")
    points = (patch, grain, residual, jacobian[:, :seen], place)
    found = explanations(Patched.of(*points), 1.2, 1e-12)
    close(found, reference.explanations(reference.patched(*points), 1.2, 1e-12))
    idle = np.column_stack([jacobian[:, :seen], np.zeros(len(residual))])
    more = explanations(Patched.of(patch, grain, residual, idle, place), 1.2, 1e-12)
    np.testing.assert_allclose(more.smooth, found.smooth, rtol=1e-9, atol=1e-12)


def test_points_that_lie_on_the_surface_have_the_smallest_noise() -> None:
    patch, grain, residual, jacobian, place = some_patches(7, "white")
    points = (patch, grain, np.zeros_like(residual), jacobian, place)
    found = explanations(Patched.of(*points), 1.2, 1e-3)
    expected = reference.explanations(reference.patched(*points), 1.2, 1e-3)
    np.testing.assert_array_equal(found.white, 1e-3)
    np.testing.assert_allclose(found.log_evidence, expected.log_evidence, rtol=1e-9)
    assert found.unexplained is None and found.apart == -np.inf


def test_more_parameters_than_patches_are_no_problem_of_noise() -> None:
    patched = Patched.of(*some_patches(8, "white", n=5))
    with pytest.raises(ValueError, match="5 patches do not tell 5 parameters from noise"):
        explanations(patched, 1.2, 1e-12)
