"""The peers, in the environment that `make bench-peers` builds; what is not installed there is skipped."""

import numpy as np
import pytest

from primfit.benchmark.cases import Case
from primfit.benchmark.measures import diagonal
from primfit.benchmark.methods import PEERS
from primfit.benchmark.runner import Child, interpreter
from primfit.fitting.primitives import PRIMITIVES
from tests.fitting.clouds import EXAMPLES, sample

KINDS_ANSWERED = {
    "engeom": ["plane", "sphere", "cylinder", "cone"],
    "mesh2cad": ["plane", "sphere", "cylinder", "cone"],
    "cgal": ["plane", "sphere", "cylinder", "cone", "torus"],
    "pyransac3d": ["plane", "sphere", "cylinder"],
    "scikit-spatial": ["plane", "sphere", "cylinder"],
    "open3d": ["plane"],
    "trimesh": ["plane", "sphere"],
}

ROUGH = {("cgal", kind): 5e-3 for kind in PRIMITIVES} | {("pyransac3d", "cylinder"): 3e-2}
"""Largest distance from a clean cloud, as a share of its diagonal, where no refinement follows the draw."""

EXACT = 1e-9
"""Of the others: rounding, and where iterations stop."""

PATIENT = 60.0


@pytest.fixture(scope="module")
def child(tmp_path_factory: pytest.TempPathFactory):
    with Child(interpreter(PEERS[0]), tmp_path_factory.mktemp("child") / "methods.log") as started:
        yield started


@pytest.fixture
def ask(child):
    def answer(method, points, kind):
        told = child.introduction(method)
        if "missing" in told:
            pytest.skip(f"{method} is not installed, `make bench-peers` does that ({told['missing']})")
        case = Case("0", points, None, {})
        return child.fit(method, case, None if told["decides_kind"] else kind, PATIENT)

    return answer


def test_each_peer_is_checked():
    assert set(KINDS_ANSWERED) == set(PEERS)


@pytest.mark.parametrize("method", PEERS)
def test_what_a_peer_is(child, ask, method):
    ask(method, sample(EXAMPLES["plane"], 100), "plane")
    told = child.introduction(method)
    assert told["kinds"] == KINDS_ANSWERED[method] and told["decides_kind"] == (method == "cgal")
    assert told["versions"][told["package"]] != "unknown"


@pytest.mark.parametrize(
    ("method", "kind"), [(method, kind) for method in PEERS for kind in KINDS_ANSWERED[method]]
)
def test_clean_clouds_are_fitted_and_answers_repeat(ask, method, kind):
    points = sample(EXAMPLES[kind], 2000)
    first, again = (ask(method, points, kind) for _ in range(2))
    assert first.status == "fitted", first.note
    assert first.primitive == again.primitive
    found = dict(first.primitive)
    found_kind = found.pop("kind")
    assert found_kind == kind or method == "cgal"  # a sphere is a torus, too
    distance = np.abs(PRIMITIVES[found_kind](**found).signed_distance(points)).max()
    assert distance < ROUGH.get((method, kind), EXACT) * diagonal(points)


SAME = np.ones((40, 3))
PLANAR = sample(EXAMPLES["plane"], 40)
FEW = np.eye(3)[:2]
SCATTERED = np.random.default_rng(3).random((20, 3))


@pytest.mark.parametrize(
    ("method", "kind", "points", "status", "note"),
    [
        ("engeom", "cone", PLANAR, "no_fit", "failed to find any valid model"),
        ("engeom", "plane", FEW, "no_fit", "Not enough points"),
        ("mesh2cad", "cylinder", PLANAR, "no_fit", "fit_cylinder found none"),
        ("mesh2cad", "cone", PLANAR, "no_fit", "fit_cone found none"),
        ("cgal", None, SCATTERED, "no_fit", "no shape"),
        ("pyransac3d", "sphere", SAME, "no_fit", "no inliers"),
        ("pyransac3d", "plane", FEW, "no_fit", "at least 3 points"),
        ("scikit-spatial", "plane", SAME, "no_fit", "must not be collinear"),
        ("scikit-spatial", "cylinder", PLANAR, "no_fit", "must not be coplanar"),
        ("open3d", "plane", SAME, "no_fit", "found none"),
        ("open3d", "plane", FEW, "no_fit", "needs 3 points"),
        ("trimesh", "sphere", FEW, "error", "TypeError"),
    ],
)
def test_a_peer_that_says_it_failed_has_no_fit(ask, method, kind, points, status, note):
    outcome = ask(method, points, kind)
    assert (outcome.status, outcome.primitive) == (status, None)
    assert note in outcome.note
