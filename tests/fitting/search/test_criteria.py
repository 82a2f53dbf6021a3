"""Huber's and Tukey's estimates: stationary at a scale of their own, efficient, robust as promised."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.solver.refine import linearize, stepped
from tests.fitting.clouds import EXAMPLES, noisy, sample

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())
estimators = pytest.mark.parametrize("criterion", ["huber", "tukey"])
PSI = {
    "huber": lambda x: np.clip(x, -1.345, 1.345),
    "tukey": lambda x: np.where(np.abs(x) < 4.685, x * (1.0 - (x / 4.685) ** 2) ** 2, 0.0),
}
"""The pull of a distance of x scales, from the textbook."""


def stray(primitive: Primitive, n: int, share: float, seed: int = 0) -> np.ndarray:
    """Noise of 0.01 and some points a tenth of a unit to one side."""
    points = noisy(primitive, n, 0.01, seed)
    count = int(share * n)
    points[:count] += 0.1 * primitive.gradient(points[:count])
    return points


def fitted(points: np.ndarray, kind: str, criterion: str) -> Primitive:
    answer = recognize(points, Config(kinds=(kind,), criterion=criterion))  # type: ignore[arg-type]
    assert answer.primitive is not None, answer.message
    return answer.primitive


def in_its_frame(points: np.ndarray, primitive: Primitive) -> tuple[np.ndarray, Primitive]:
    frame = Frame.of(points)
    return frame.normalize(points), primitive.transformed(
        np.eye(3), -frame.center / frame.scale, 1.0 / frame.scale
    )


@estimators
@examples
def test_the_pulls_of_all_points_are_in_balance(primitive: Primitive, criterion: str) -> None:
    points = stray(primitive, 400, 0.1)
    points, found = in_its_frame(points, fitted(points, primitive.kind, criterion))
    distance, jacobian = linearize(found, points)
    scale = 1.4826 * np.median(np.abs(distance))
    directions = np.linalg.qr(jacobian)[0]
    pull = PSI[criterion](distance / scale)
    assert np.linalg.norm(directions.T @ pull) < 1e-8 * np.linalg.norm(pull)


@examples
def test_huber_agrees_with_scipy_at_the_same_scale(primitive: Primitive) -> None:
    points = stray(primitive, 300, 0.1)
    points, found = in_its_frame(points, fitted(points, primitive.kind, "huber"))
    corner = 1.345 * 1.4826 * float(np.median(np.abs(found.signed_distance(points))))
    theirs = least_squares(
        lambda step: stepped(found, step).signed_distance(points),
        np.full(primitive.dof, 1e-3),
        loss="huber",
        f_scale=corner,
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
    )
    # Two ends of one minimum: scipy stops where the cost does not show it any more.
    assert np.abs(theirs.x).max() < 1e-5
    cost = Kernel.HUBER.rho((found.signed_distance(points) / corner) ** 2).sum() * corner**2
    assert cost <= theirs.cost * (1.0 + 1e-12)


@examples
def test_without_outliers_they_are_near_least_squares(primitive: Primitive) -> None:
    points = noisy(primitive, 600, 0.01)
    best = np.sum(fitted(points, primitive.kind, "least_squares").signed_distance(points) ** 2)
    for criterion in ("huber", "tukey"):
        cost = np.sum(fitted(points, primitive.kind, criterion).signed_distance(points) ** 2)
        assert best <= cost < 1.005 * best


def test_outliers_pull_least_squares_more_than_huber_and_huber_more_than_tukey() -> None:
    sphere = EXAMPLES["sphere"]
    assert isinstance(sphere, Sphere)
    points = stray(sphere, 1000, 0.15)
    missed = []
    for criterion in ("least_squares", "huber", "tukey"):
        found = fitted(points, "sphere", criterion)
        assert isinstance(found, Sphere)
        missed.append(abs(found.radius - sphere.radius) + float(np.linalg.norm(found.center - sphere.center)))
    assert missed[0] > 3.0 * missed[1] > 3.0 * 2.0 * missed[2]


@estimators
@examples
def test_an_exact_majority_is_met(primitive: Primitive, criterion: str) -> None:
    """The scale is then that of the rounding of the coordinates."""
    points = sample(primitive, 300)
    points[:60] += np.random.default_rng(0).normal(0.0, 0.1, (60, 3))
    found = fitted(points, primitive.kind, criterion)
    assert np.abs(found.signed_distance(points[60:])).max() < 1e-11


@estimators
@pytest.mark.parametrize("n", [7, 12])
def test_few_points_are_fitted_by_least_squares(criterion: str, n: int) -> None:
    points = noisy(EXAMPLES["sphere"], n, 0.01)
    plain, found = (fitted(points, "sphere", each) for each in ("least_squares", criterion))
    np.testing.assert_array_equal(found.row(), plain.row())
