"""The child process: what methods do wrong is contained, counted, and costs one record."""

import sys
from pathlib import Path

import numpy as np
import pytest

from primfit.benchmark import child as child_process
from primfit.benchmark import runner, sources
from primfit.benchmark.cases import Case
from primfit.benchmark.methods.primfit import Primfit
from primfit.benchmark.records import RecordsFile
from primfit.benchmark.runner import Child, MethodError, Work, begin, introduce, run
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere

FAKES = str(Path(__file__).with_name("fakes.py"))
PATIENT, HASTY = 60.0, 0.5


def sphere_case(name: str = "0") -> Case:
    points = np.random.default_rng(0).standard_normal((10, 3))
    return Case(name, points, Sphere([0, 0, 0], 1.0), {"level": 1})


@pytest.fixture(scope="module")
def child(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("child")
    with Child(Path(sys.executable), folder / "methods.log", (FAKES,)) as started:
        yield started


def test_an_answer_comes_with_its_times(child):
    outcome = child.fit("right", sphere_case(), None, PATIENT)
    assert outcome.status == "fitted"
    assert outcome.primitive["kind"] == "sphere" and outcome.attempts == ("plane", "sphere")
    assert outcome.seconds > 0.0 and outcome.cpu_seconds >= 0.0


@pytest.mark.parametrize(
    ("method", "note"),
    [
        ("raises", "ValueError: these points are no good"),
        ("panics", "SystemExit: as some bindings do"),
        ("wild", "parameters that are not finite"),
    ],
)
def test_exceptions_are_errors_and_the_process_lives(child, method, note):
    child.introduction(method)
    before = child.process
    outcome = child.fit(method, sphere_case(), None, PATIENT)
    assert outcome.status == "error" and note in outcome.note
    assert child.process is before


def test_a_method_has_points_of_its_own(child):
    case = sphere_case()
    assert child.fit("given", case, "sphere", PATIENT).note == "was given sphere"
    assert case.points.all()


def test_crashes_and_hangs_cost_one_answer(child):
    crash = child.fit("crashes", sphere_case(), None, PATIENT)
    assert (crash.status, crash.note) == ("crash", "ended by SIGABRT")
    assert "about to abort" in child.log.read_text()
    hang = child.fit("hangs", sphere_case(), None, HASTY)
    assert (hang.status, hang.note, hang.seconds) == ("timeout", "no answer within 0.5 s", HASTY)
    assert child.fit("right", sphere_case(), None, PATIENT).status == "fitted"


def test_what_a_method_is(child):
    told = child.introduction("given")
    assert not told["decides_kind"] and told["kinds"] == ["sphere"] and told["settings"] == "none"
    assert "no_such_package" in child.introduction("missing")["missing"]


def test_a_method_that_cannot_be_started_is_named(tmp_path):
    with (
        Child(Path(sys.executable), tmp_path / "log", ("-c", "raise SystemExit(3)")) as broken,
        pytest.raises(MethodError, match=r"right cannot be started \(ended with status 3\); see .*log"),
    ):
        introduce(broken, ["right"])


def test_methods_take_turns_and_a_run_goes_on(child, tmp_path):
    file = RecordsFile(tmp_path)
    plane = Case("1", np.eye(3).repeat(2, axis=0), Plane([0, 0, 1], [0, 0, 0]), {"level": 2})
    drawn = []

    def draw(name: str) -> Case:
        drawn.append(name)
        return sphere_case() if name == "0" else plane

    works = [Work("fakes", 7, ["0", "1"], draw)]
    methods = introduce(child, ["right", "given"])
    done, stale = begin(file, works, methods, restart=False)
    assert (done, stale) == ([], 0)
    first = next(run(child, file, works, methods, done, PATIENT))
    assert [record.method for record in first[1]] == ["right", "given"]

    done, stale = begin(file, works, methods, restart=False)
    assert [record.key for record in done] == [("fakes", 7, "0", "right"), ("fakes", 7, "0", "given")]
    rest = list(run(child, file, works, methods, done, PATIENT))
    assert [[record.key for record in records] for _, records in rest] == [[], [("fakes", 7, "1", "right")]]
    assert drawn == ["0", "1"]
    done, _ = begin(file, works, methods, restart=False)
    assert [records for _, records in run(child, file, works, methods, done, PATIENT)] == [[], []]
    assert drawn == ["0", "1"]  # not again for a method that is not asked about planes
    assert [record.key[2:] for record in file.read()] == [("0", "right"), ("0", "given"), ("1", "right")]
    assert file.methods()["given"]["kinds"] == ["sphere"]


def test_methods_of_others_are_not_asked_in_a_set_of_our_own(child, tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "PEERS", ("given",))
    methods = introduce(child, ["right", "given"])
    for own, asked in ((True, ["right"]), (False, ["right", "given"])):
        works = [Work("fakes", 7, ["0"], lambda name: sphere_case(), own)]
        ((_, records),) = run(child, RecordsFile(tmp_path), works, methods, [], PATIENT)
        assert [record.method for record in records] == asked


def test_records_of_other_versions_are_dropped(child, tmp_path):
    file = RecordsFile(tmp_path)
    works = [Work("fakes", 7, ["0"], lambda name: sphere_case())]
    methods = introduce(child, ["right", "given"])
    list(run(child, file, works, methods, [], PATIENT))
    newer = methods | {"right": methods["right"] | {"versions": {"fake": "2"}}}
    kept, stale = begin(file, works, newer, restart=False)
    assert [record.method for record in kept] == ["given"] and stale == 1
    assert begin(file, works, newer, restart=True) == ([], 0)


def test_every_library_is_kept_on_one_thread(child, monkeypatch):
    seen = {}
    monkeypatch.setattr(runner.subprocess, "Popen", lambda command, **how: seen.update(how["env"]) or _Dead())
    Child(Path(sys.executable), child.log).start()
    assert {seen[f"{name}_NUM_THREADS"] for name in ("OMP", "OPENBLAS", "MKL", "RAYON", "TBB")} == {"1"}


class _Dead:
    pid = 0


@pytest.mark.parametrize(
    "name", ["fitting/verdict/judge.py", "fitting/solver/_descent.pyx", "fitting/primitives/cone.h"]
)
def test_versions_tell_one_state_of_the_code_from_another(name, tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    files = [tmp_path / "benchmark/methods/primfit.py", tmp_path / name]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("one")
    before = child_process.versions(Primfit())
    assert before == child_process.versions(Primfit())
    files[1].write_text("other")
    assert before["source"] != child_process.versions(Primfit())["source"]
