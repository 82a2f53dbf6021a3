"""Who does the work, by name; a cluster that is asked for without Ray."""

import pickle
from importlib.util import find_spec

import numpy as np
import pytest

import primfit
from primfit.app.engine.cut import cut, pieces
from primfit.app.readers.cloud import Cloud
from primfit.fitting.errors import InvalidOptionError

POINTS = np.eye(3)
LABELS = [1, 1, 1]


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("executor", "slurm", "executor must be one of local, ray"),
        ("address", "127.0.0.1:6379", "needs the executor ray"),
        ("workers", 0, "at least 1"),
    ],
)
def test_options_that_make_no_sense_are_refused(option: str, value: object, said: str) -> None:
    with pytest.raises(InvalidOptionError, match=said) as caught:
        primfit.fit_segments(POINTS, LABELS, **{option: value})
    assert caught.value.field == option


@pytest.mark.skipif(find_spec("ray") is not None, reason="Ray is here")
def test_without_ray_one_is_told_what_to_install() -> None:
    with pytest.raises(ImportError, match=r"pip install 'primfit\[ray\]'"):
        primfit.fit_segments(POINTS, LABELS, executor="ray")


def test_what_is_sent_of_a_segment_are_its_own_points() -> None:
    rng = np.random.default_rng(0)
    cloud = Cloud(rng.normal(size=(10_000, 3)), (), None, "", labels=np.arange(10_000) % 100)
    piece = pieces(cut(cloud))[7]
    sent = pickle.dumps(piece)
    assert len(sent) < 4 * 100 * 24
    assert np.array_equal(pickle.loads(sent)().points, piece().points)
    assert np.array_equal(piece().points, cloud.points[7::100])
