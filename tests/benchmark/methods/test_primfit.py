"""The registry, and primfit as a method."""

import numpy as np
import pytest

from primfit.benchmark.methods import METHODS, PAPER, PEERS, load
from primfit.benchmark.methods.primfit import Reversed
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.sphere import Sphere

OURS = [name for name in METHODS if name not in (*PEERS, *PAPER)]


def test_ours_come_first_and_the_rest_are_peers():
    assert OURS == ["primfit", "primfit-knn", "primfit-none", "primfit-reversed"]
    assert set(PEERS) == {
        "engeom",
        "mesh2cad",
        "cgal",
        "pyransac3d",
        "scikit-spatial",
        "open3d",
        "trimesh",
    }


@pytest.mark.parametrize("name", OURS)
def test_our_methods_recognise_a_sphere(name):
    directions = np.random.default_rng(0).standard_normal((400, 3))
    points = np.array([1.0, 2.0, 3.0]) + 2 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    method = load(name)
    assert (method.name, method.package, method.decides_kind, method.kinds) == (name, "primfit", True, KINDS)
    answer = method.fit(points, None)
    assert answer.status == "fitted" and isinstance(answer.primitive, Sphere)
    assert answer.primitive.radius == pytest.approx(2.0)
    assert "sphere" in answer.attempts and answer.note


def test_the_reversed_ranking_is_the_worst_first():
    class Sure:
        def rank(self, points, normals):
            return {"plane": 0.6, "sphere": 0.2, "cylinder": 0.1, "cone": 0.06, "torus": 0.04}

    ranked = Reversed(Sure()).rank(np.zeros((1, 3)), np.zeros((1, 3)))
    assert sorted(ranked, key=ranked.get, reverse=True) == ["torus", "cone", "cylinder", "sphere", "plane"]
    assert sum(ranked.values()) == pytest.approx(1.0)
