"""What can be told under correlated errors: the gain is the mean log-likelihood that the truth is ahead."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.synthetic import deciding
from primfit.synthetic.deciding import about_plane, covariance, decidable, gain
from primfit.synthetic.effects import Correlated, RadialBow, Seen, White
from primfit.synthetic.fields import Rough
from primfit.synthetic.patches import Patch

Z = np.array([0.0, 0.0, 1.0])
CAN = Patch(Cylinder(Z, np.zeros(3), 1.0), (-1.0, 1.0), (-1.0, 1.0))


def facing(patch, count, seed=0):
    """Points of a piece with uniform parameters, seen along their normals."""
    points = patch.sample(np.random.default_rng(seed), count)
    normals = patch.primitive.gradient(points)
    ones, none = np.ones(count), np.zeros(count, dtype=np.intp)
    return Seen(points, normals, -normals, ones, ones, ones, points[:, 1:], none, ones, none, none > 0, ones)


def test_the_gain_under_white_noise_is_that_of_least_squares():
    """N D^2 / (2 s^2) with the root mean square distance D from the nearest rival, the sphere."""
    seen = facing(CAN, 200)

    def distances(row):
        return np.linalg.norm(seen.points - row[:3], axis=1) - row[3]

    sphere = least_squares(distances, [0.0, 0.0, 0.0, 1.0]).fun
    assert np.sum(sphere**2) < np.sum(about_plane(seen.points)[0] ** 2)
    found = gain(CAN, seen, covariance([White(0.05)], seen, 1.0))
    assert found == pytest.approx(np.sum(sphere**2) / (2 * 0.05**2), rel=0.05)
    # A share of a quarter: each point stands for four.
    assert gain(CAN, seen, covariance([White(0.05)], seen, 0.25)) == pytest.approx(4 * found, rel=0.01)


def test_the_gain_is_the_mean_log_likelihood_ratio(monkeypatch):
    """Of draws, against the plane that generalised least squares fits to each."""
    monkeypatch.setattr(deciding, "rivals", lambda patch, points: iter([about_plane(points)]))
    cap = Patch(Sphere(np.zeros(3), 1.0), (-np.pi, np.pi), (0.0, 0.6))
    seen, rng = facing(cap, 100), np.random.default_rng(1)
    effects = [White(0.01), Correlated(0.015, Rough(0.2))]
    total = covariance(effects, seen, 1.0)
    root = np.linalg.cholesky(total)
    distance, jacobian = about_plane(seen.points)
    basis = np.linalg.qr(np.linalg.solve(root, jacobian))[0]

    def misfit(residual, fitted):
        white = np.linalg.solve(root, residual)
        return white @ white - (np.sum((basis.T @ white) ** 2) if fitted else 0.0)

    errors = (root @ rng.standard_normal((100, 1000))).T
    ahead = [(misfit(distance + error, True) - misfit(error, True)) / 2.0 for error in errors]
    mean, spread = np.mean(ahead), np.std(ahead)
    assert spread == pytest.approx(np.sqrt(2 * mean), rel=0.1)
    assert gain(cap, seen, total) == pytest.approx(mean, abs=4 * spread / np.sqrt(1000))


def test_a_rough_field_hides_what_white_noise_of_its_size_does_not():
    seen = facing(CAN, 150)
    white = gain(CAN, seen, covariance([White(0.2)], seen, 0.01))
    rough = gain(CAN, seen, covariance([White(0.02), Correlated(0.2, Rough(0.5))], seen, 0.01))
    assert rough < 0.1 * white


def test_a_bow_hides_only_what_has_its_form():
    """The bow of a can is hidden by a bow along its round side, however large; more points do not help."""
    seen = facing(CAN, 150)
    bowed = replace(seen, image=np.column_stack([seen.points[:, 1], np.zeros(150)]))
    plain = gain(CAN, bowed, covariance([White(0.01)], bowed, 1.0))
    hidden = gain(CAN, bowed, covariance([White(0.01), RadialBow(1.0)], bowed, 1.0))
    assert hidden < 0.2 * plain


def test_planes_have_no_rival_but_need_to_be_seen():
    wall = Patch(Plane(Z, np.zeros(3)), (-1.0, 1.0), (-1.0, 1.0))
    seen = facing(wall, 100)
    assert gain(wall, seen, covariance([White(0.1)], seen, 1.0)) == np.inf
    rng = np.random.default_rng(0)
    assert decidable(rng, wall, seen, [White(0.02)]) and not decidable(rng, wall, seen, [White(0.2)])


def test_two_equal_rings_of_a_cylinder_lie_on_a_sphere():
    azimuth, height = np.tile(np.linspace(-3.0, 3.0, 50), 2), np.repeat([-0.5, 0.5], 50)
    seen = facing(CAN, 100)
    rings = replace(seen, points=CAN.primitive.surface(azimuth, height))
    assert gain(CAN, rings, covariance([White(0.001)], rings, 1.0)) == pytest.approx(0.0, abs=0.1)


def test_a_flat_cap_of_a_sphere_is_not_told_and_a_round_one_is():
    for angle, told in ((0.1, False), (1.0, True)):
        cap = Patch(Sphere(np.zeros(3), 1.0), (-np.pi, np.pi), (0.0, angle))
        seen = facing(cap, 200)
        assert decidable(np.random.default_rng(0), cap, seen, [White(0.004)]) == told
