"""Ranks by hand."""

import numpy as np

from primfit.models.training.metrics import rank_of_truth


def test_ranks_count_what_is_above_the_truth():
    probabilities = np.array([[0.5, 0.2, 0.1, 0.1, 0.1], [0.5, 0.2, 0.1, 0.1, 0.1], [0.2] * 5])
    assert rank_of_truth(probabilities, np.array([0, 1, 4])).tolist() == [0, 1, 4]
