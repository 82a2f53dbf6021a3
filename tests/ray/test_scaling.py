"""`primfit bench scaling` on a real cluster, with few segments: runs, some killed, and a prediction."""

import pytest

pytest.importorskip("ray", reason="needs the extra ray: make test-ray")
pytest.importorskip("pyarrow", reason="needs the extra bulk: make test-ray")
pytest.importorskip("simpy", reason="needs the extra bench: make test-ray")

from primfit.benchmark.command import BAD_INPUT, bench
from primfit.benchmark.scaling.model import Parameters
from primfit.benchmark.scaling.records import records

# Ray leaves files and processes to the end of its own.
pytestmark = [pytest.mark.ray, pytest.mark.filterwarnings("default")]

SMALL, LARGE = "250", "500"


def scaling(folder, *arguments):
    return bench(["scaling", *arguments, "--folder", str(folder)])


def test_runs_are_made_killed_compared_and_predicted(tmp_path, capsys):
    file = tmp_path / "parameters.json"
    assert scaling(tmp_path, "segments", "--n", LARGE) == 0
    for n in (SMALL, LARGE):
        assert scaling(tmp_path, "run", "--n", n) == 0
        assert scaling(tmp_path, "run", "--n", n, "--executor", "ray") == 0
    assert scaling(tmp_path, "parameters", "--parameters", str(file)) == 0
    parameters = Parameters.read(file)
    assert parameters.per_segment > 0 and parameters.detected > 0 and parameters.teams["ray"].slower > 0

    killed = ("--n", LARGE, "--executor", "ray", "--at", "0.2")
    assert scaling(tmp_path, "predict", *killed, "--kill", "node", "--parameters", str(file)) == 0
    assert scaling(tmp_path, "run", *killed, "--kill", "node") == 0
    assert scaling(tmp_path, "run", *killed, "--kill", "driver") == 0
    assert scaling(tmp_path, "predict", *killed, "--kill", "node", "--parameters", str(file)) == BAD_INPUT
    for name in (f"ray-3-{LARGE}-node-killed", f"ray-3-{LARGE}-driver-killed"):
        assert scaling(tmp_path, "compare", f"local-2-{LARGE}", name) == 0
    made = records(tmp_path)
    assert len(made) == 6 and all(run.once and not run.lost and not run.twice for run in made)
    assert all(run.driver_cpu > 0 and run.worker_cpu > 0 and run.memory.worker_rss > 0 for run in made)

    capsys.readouterr()
    scaling(tmp_path, "verdict")  # its bar is for long runs on a machine that does nothing else
    assert f"| ray-3-{LARGE}-node-killed | " in capsys.readouterr().out
    assert scaling(tmp_path, "runs") == 0
    shown = capsys.readouterr().out
    assert "4 runs, all parts equal byte for byte, every segment exactly once" in shown
