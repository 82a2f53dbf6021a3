"""Tensors are clouds, from any device and with a gradient."""

import numpy as np
import pytest

import primfit
from primfit.fitting.errors import InvalidPointCloudError
from tests.fitting.clouds import EXAMPLES, noisy

torch = pytest.importorskip("torch", reason="needs torch: make test-torch")
pytestmark = pytest.mark.torch

POINTS = noisy(EXAMPLES["plane"], 200, 0.01)


def test_a_tensor_gives_the_answer_of_its_array() -> None:
    expected = primfit.fit(POINTS, weights=np.arange(1.0, 201.0)).to_json()
    points, weights = torch.tensor(POINTS, requires_grad=True), torch.arange(1.0, 201.0)
    assert primfit.fit(points, weights=weights).to_json() == expected
    labels = torch.zeros(200, dtype=torch.int64)
    (segment,) = primfit.fit_segments(points, labels, weights=weights)
    assert segment.recognition is not None and segment.recognition.to_json() == expected


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
def test_a_tensor_on_a_gpu_as_well() -> None:
    points = torch.tensor(POINTS, requires_grad=True, device="cuda")
    assert primfit.fit(points).to_json() == primfit.fit(POINTS).to_json()


@pytest.mark.parametrize("tensor", [torch.zeros(5, 3).to_sparse(), torch.zeros(5, 3, device="meta")])
def test_a_tensor_without_values_is_no_cloud(tensor: torch.Tensor) -> None:
    with pytest.raises(InvalidPointCloudError, match="points: Tensor is not an array of numbers"):
        primfit.fit(tensor)
