"""Cards are read to the letter: whatever does not match is refused."""

import json
import pickle

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.models.features import FEATURE_VERSION
from primfit.models.weights import WeightsMismatchError, archive, load, save

ARRAYS = {"a": np.arange(6, dtype=np.float32).reshape(2, 3), "b": np.array([1, 2], np.uint8)}


@pytest.fixture
def folder(tmp_path):
    save(ARRAYS, "small", {"clouds": 2}, 7, {"top1": 1.0}, tmp_path)
    return tmp_path


def edit(folder, **changes):
    card = json.loads((folder / "small.json").read_text())
    card.update(changes)
    (folder / "small.json").write_text(json.dumps(card))


def test_what_is_saved_is_loaded(folder):
    arrays, card = load("small", folder)
    assert set(arrays) == {"a", "b"}
    assert all(np.array_equal(arrays[name], ARRAYS[name]) for name in ARRAYS)
    assert (card.classes, card.feature_version, card.seed) == (KINDS, FEATURE_VERSION, 7)
    assert (card.recipe, card.metrics) == ({"clouds": 2}, {"top1": 1.0})


def test_equal_arrays_make_equal_bytes():
    assert archive(ARRAYS) == archive(dict(reversed(ARRAYS.items())))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sha256": "0" * 64}, "SHA-256"),
        ({"classes": list(reversed(KINDS))}, "class order"),
        ({"classes": list(KINDS[:4])}, "class order"),
        ({"feature_version": FEATURE_VERSION + 1}, "feature version"),
        ({"feature_version": str(FEATURE_VERSION)}, "feature version"),
        ({"feature_version": float(FEATURE_VERSION)}, "feature version"),
        ({"name": "other"}, "name"),
        ({"arrays": {"a": "<f4 [2, 3]"}}, "arrays"),
        ({"more": 1}, "exactly"),
    ],
)
def test_a_card_that_does_not_match_is_refused(folder, change, message):
    edit(folder, **change)
    with pytest.raises(WeightsMismatchError, match=message):
        load("small", folder)


@pytest.mark.parametrize("field", ["sha256", "classes", "seed", "metrics"])
def test_a_card_without_a_field_is_refused(folder, field):
    card = json.loads((folder / "small.json").read_text())
    del card[field]
    (folder / "small.json").write_text(json.dumps(card))
    with pytest.raises(WeightsMismatchError, match="exactly"):
        load("small", folder)


def test_one_changed_byte_is_refused(folder):
    content = bytearray((folder / "small.npz").read_bytes())
    content[len(content) // 2] ^= 1
    (folder / "small.npz").write_bytes(content)
    with pytest.raises(WeightsMismatchError, match="SHA-256"):
        load("small", folder)


@pytest.mark.parametrize("suffix", [".npz", ".json"])
def test_a_missing_file_is_refused(folder, suffix):
    (folder / f"small{suffix}").unlink()
    with pytest.raises(WeightsMismatchError, match="cannot be read"):
        load("small", folder)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"classes": 3}'])
def test_a_damaged_card_is_refused(folder, text):
    (folder / "small.json").write_text(text)
    with pytest.raises(WeightsMismatchError, match="cannot be read"):
        load("small", folder)


def test_objects_are_neither_written_nor_read(folder):
    class Bomb:
        def __reduce__(self):
            raise AssertionError("pickled")

    with pytest.raises(ValueError, match="Object arrays cannot be saved"):
        archive({"a": np.array([Bomb()], dtype=object)})
    (folder / "small.npz").write_bytes(pickle.dumps({"a": 1}))
    with pytest.raises(WeightsMismatchError, match="SHA-256"):
        load("small", folder)
