"""Data sets: the same clouds whatever the length, the number of processes and what was there before."""

from dataclasses import fields

import numpy as np
import pytest

from primfit.models.training import dataset
from primfit.models.training.dataset import FAMILIES, make_dataset, numbers, option
from primfit.models.training.metrics import metrics
from primfit.synthetic.sensors import SENSORS

FEW = {"benchmark": 20, "scanner": 15, "sensor": 10}


def test_numbers_of_clouds_are_read():
    assert numbers("7") == dict.fromkeys(FAMILIES, 7)
    assert numbers(option(FEW)) == FEW
    for wrong in ("benchmark=1", "benchmark=1,scanner=2,sensors=3", "many"):
        with pytest.raises(ValueError):
            numbers(wrong)


def test_datasets_do_not_depend_on_their_length():
    short, long = make_dataset(8, 4), make_dataset(8, 9)
    for family in FAMILIES:
        assert np.array_equal(
            short.where(short.families == family).rows, long.where(long.families == family).rows[:4]
        )


def test_processes_and_a_cache_change_nothing(tmp_path):
    plain = make_dataset(8, 4)
    for _ in range(2):
        other = make_dataset(8, 4, processes=2, cache=tmp_path)
        for name in (field.name for field in fields(plain)):
            assert np.array_equal(getattr(plain, name), getattr(other, name))


def test_a_run_goes_on_where_it_was_cut_off(tmp_path, monkeypatch):
    monkeypatch.setattr(dataset, "SHARD", 2)
    plain = make_dataset(8, 6, families=("benchmark",))
    make_dataset(8, 4, families=("benchmark",), cache=tmp_path)
    kept = {file: file.stat().st_mtime_ns for file in tmp_path.iterdir()}
    longer = make_dataset(8, 6, families=("benchmark",), cache=tmp_path)
    assert len(kept) == 2 and len(list(tmp_path.iterdir())) == 3
    assert {file: file.stat().st_mtime_ns for file in kept} == kept
    assert np.array_equal(plain.rows, longer.rows)


def test_clouds_of_sensors_can_be_learned_from():
    data = make_dataset(9, 10, families=("scanner", "sensor"))
    assert data.rows.shape[0] == 20 and np.isfinite(data.rows).all()
    scores = metrics(np.full((20, 5), 0.2), data)
    assert list(scores) == ["scanner", "sensor"]
    assert scores["scanner"]["top1_by_sensor"] == {}
    assert set(scores["sensor"]["top1_by_sensor"]) <= set(SENSORS)
