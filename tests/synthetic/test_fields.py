"""Random fields: each cloud has the variogram of its law, whatever the points."""

import numpy as np
import pytest

from primfit.synthetic.fields import Rough, SelfAffine, Smooth

FIELDS = (Rough(0.1), Rough(0.5), Smooth(0.1), SelfAffine(0.5, 0.01, 2.0), SelfAffine(0.3, 0.01, 2.0))
POINTS = 700
DRAWN = 40


def variogram(field, count=DRAWN, dimension=3):
    """Half the mean squared difference of `count` fields at pairs of points, by distance."""
    rng = np.random.default_rng(1)
    points = rng.random((POINTS, dimension)) * [1.0, 1.0, *[0.0] * (dimension - 2)]
    pairs = rng.integers(0, POINTS, (2, 20_000))
    distance = np.linalg.norm(points[pairs[0]] - points[pairs[1]], axis=1)
    values = [field.draw(rng, points) for _ in range(count)]
    halves = np.mean([(value[pairs[0]] - value[pairs[1]]) ** 2 / 2.0 for value in values], axis=0)
    bins = np.digitize(distance, np.linspace(0.0, 1.0, 15))
    inside = [bins == i for i in range(1, 15)]
    return [(distance[chosen], halves[chosen].mean()) for chosen in inside]


@pytest.mark.parametrize("field", FIELDS, ids=str)
def test_the_variogram_is_that_of_the_law(field):
    """Forty fields: the mean square of as many normal numbers is known to sqrt(2 / 40) = 22%, and each field
    holds several, the more the shorter its range."""
    for distance, found in variogram(field):
        expected = np.mean(1.0 - field.correlation(distance))
        assert found == pytest.approx(expected, rel=0.3, abs=0.02)


def test_each_short_field_alone_has_the_variogram_of_its_law():
    """Wave numbers are stratified, so one field of a short range agrees, not only the mean of many."""
    for distance, found in variogram(Rough(0.05), count=1)[1:]:
        assert found == pytest.approx(np.mean(1.0 - np.exp(-distance / 0.05)), rel=0.25)


def test_brownian_fields_have_a_straight_variogram():
    field = SelfAffine(0.5, 1e-3, 4.0)
    distance = np.array([0.02, 0.05, 0.1, 0.2])
    halves = 1.0 - field.correlation(distance)
    assert np.diff(np.log(halves)) / np.diff(np.log(distance)) == pytest.approx(1.0, abs=0.12)
    steeper = 1.0 - SelfAffine(0.7, 1e-3, 40.0).correlation(distance)
    assert np.polyfit(np.log(distance), np.log(steeper), 1)[0] == pytest.approx(1.4, abs=0.1)


@pytest.mark.parametrize("field", FIELDS, ids=str)
def test_the_range_is_where_the_correlation_falls_to_1_e(field):
    assert field.correlation(np.array([field.range]))[0] == pytest.approx(np.exp(-1), abs=0.01)


def test_fields_are_the_same_for_the_same_generator_and_follow_any_number_of_points():
    points = np.random.default_rng(0).random((25_000, 3))
    whole = Rough(0.2).draw(np.random.default_rng(5), points)
    few = Rough(0.2).draw(np.random.default_rng(5), points[-10:])
    assert whole[-10:] == pytest.approx(few, abs=1e-5)
    assert np.std(whole) == pytest.approx(1.0, abs=0.3)
