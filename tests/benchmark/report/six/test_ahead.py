"""Where primfit is said not to be ahead, from records that are made up."""

from dataclasses import replace

import numpy as np

from primfit.benchmark.records import Record
from primfit.benchmark.report.data import Data
from primfit.benchmark.report.six.ahead import Comparison, comparisons, not_ahead
from primfit.fitting.names import KINDS
from primfit.synthetic.perturb import TYPES
from tests.benchmark.made import record


def made(method: str, on: str, answers: dict[str, str], l2: float, set_: str = "shrec") -> list[Record]:
    """A cloud of each kind; what is not in `answers` is right, with this distance of the parameters."""
    known = {"groups": {"perturbation": on}, "errors": {"l2": l2, "relative_l2": l2 / 10}}
    given = {"method": method, "set": set_}
    return [
        replace(record(kind, answers.get(kind, kind), case=f"{on} {kind}", **given), **known)
        for kind in KINDS
    ]


def said(*records) -> list[str]:
    return list(not_ahead(Data([one for some in records for one in some], {})))


def test_it_is_ahead_everywhere():
    ours = [made("primfit", on, {}, 1e-3) for on in TYPES]
    theirs = [made("m1", on, {"cone": "torus"}, 1e-2) for on in TYPES]
    assert said(*ours, *theirs) == [
        "primfit is ahead of m1 in TPR, TNR, PPV, NPV, ACC and L2 on every perturbation."
    ]
    (sentence,) = said(*ours, *theirs[:2])
    assert sentence.endswith("on A0 and A1.")


def test_where_it_is_not_is_said_first_and_with_figures():
    lines = said(
        made("primfit", "A0", {}, 1e-16),
        made("m1", "A0", {}, 1e-12),
        made("primfit", "A1", {"cone": "ambiguous"}, 1e-3),
        made("m1", "A1", {}, 1e-2),
        made("primfit", "A2", {"cone": "torus"}, 1e-3),
        made("m2", "A2", {"torus": "cone"}, 1e-4),
    )
    assert lines[0] == (
        "primfit is behind m1 in TPR, NPV and ACC on A1; m2 in L2 on A2. "
        "It is level with m2 in TPR, TNR, PPV, NPV and ACC on A2. "
        "Both are perfect, so that nobody can be ahead: m1 in TPR, TNR, PPV, NPV, ACC and L2 on A0, "
        "in TNR and PPV on A1. "
        "Elsewhere it is ahead of m1 in TPR, TNR, PPV, NPV, ACC and L2 on A0 and A1; "
        "of m2 in TPR, TNR, PPV, NPV, ACC and L2 on A2."
    )
    m1, m2 = lines[-2:]
    assert m1 == "| m1 | A1 | **1.0000 / 0.8000** |  |  | **1.0000 / 0.9600** | **1.0000 / 0.9600** |  |"
    assert m2.startswith("| m2 | A2 | 0.8000 / 0.8000 | ") and m2.endswith(" | **1.0e-04 / 1.0e-03** |")


def test_nobody_is_ahead_of_what_is_perfect():
    (sentence,) = said(made("primfit", "A0", {}, 0.0), made("m5", "A0", {}, 1e-3))
    assert sentence.startswith(
        "primfit is nowhere behind. Both are perfect, so that nobody can be ahead: m5 in TPR"
    )


def test_other_sets_count_as_one_place():
    ours = [made("primfit", "A0", {}, 1e-3, name) for name in ("sensor", "real")]
    theirs = [made("m4", "A0", {}, 1e-4, name) for name in ("sensor", "real")]
    found = [one for one in comparisons(Data([one for some in (*ours, *theirs) for one in some], {}))]
    assert [(one.place, one.measure) for one in found if one.measure == "L2"] == [("clouds of sensors", "L2")]
    assert len(found) == 11 and (found[5].theirs, found[5].ours) == (1e-5, 1e-4)
    sentence, *_ = said(*ours, *theirs)
    assert sentence.startswith("primfit is behind m4 in L2 on clouds of sensors. Both are perfect")
    assert sentence.endswith(": m4 in TPR, TNR, PPV, NPV and ACC on clouds of sensors and real segments.")


def test_only_clouds_of_both_count():
    (sentence,) = said(made("primfit", "A0", {}, 0.0), made("m1", "A1", {}, 0.0))
    assert "not known" in sentence
    assert "not known" in said(made("m1", "A1", {}, 0.0))[0]


def test_figures_that_are_not_defined_are_the_worst():
    assert Comparison("m1", "A0", "PPV", np.nan, 0.5).outcome == "ahead"
    assert Comparison("m1", "A0", "PPV", 0.5, np.nan).outcome == "behind"
    assert Comparison("m1", "A0", "L2", np.inf, np.inf).outcome == "level"
