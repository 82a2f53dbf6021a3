"""Plain values of an answer: those that the fields of its records say, one by one."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pytest

import primfit
from primfit.fitting.plain import field_names, plain
from tests.fitting.by_hand import ambiguous
from tests.fitting.clouds import EXAMPLES, noisy


def reference(value: Any) -> Any:
    """Slow and simple: asks every value what it is."""
    if is_dataclass(value):
        return {field.name: reference(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: reference(each) for name, each in value.items()}
    if isinstance(value, tuple | list):
        return [reference(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


@dataclass(frozen=True)
class _Record:
    number: np.float64
    pairs: tuple[tuple[float, np.int64], ...]
    by_name: Mapping[str, "_Record | None"]

    @cached_property
    def kept(self) -> float:
        """What is kept beside the fields is none of them."""
        return 2.0 * self.number


@pytest.mark.parametrize("kind", sorted(EXAMPLES))
def test_an_answer_is_as_its_fields_say(kind: str) -> None:
    recognition = primfit.fit(noisy(EXAMPLES[kind], 300, 0.01))
    found = recognition.to_dict()
    for name in ("error", "noise", "uncertainty"):
        assert found[name] == reference(getattr(recognition, name))
    assert found["extents"] == {"kind": recognition.primitive.kind} | reference(recognition.extents)  # type: ignore[union-attr]
    assert found["primitive"] == {"kind": recognition.primitive.kind} | reference(recognition.primitive)  # type: ignore[union-attr]
    assert list(found["primitive"]) == ["kind", *field_names(type(recognition.primitive))]


def test_records_of_records_and_what_is_no_record() -> None:
    inner = _Record(np.float64(1.5), ((0.5, np.int64(3)),), {})
    assert inner.kept == 3.0
    record = _Record(np.float64(2.5), (), {"inner": inner, "none": None})
    assert plain(record) == reference(record)
    assert type(plain(record)["by_name"]["inner"]["pairs"][0][1]) is int
    assert plain([np.arange(3), (True, "text")]) == [[0, 1, 2], [True, "text"]]
    assert field_names(int) == ()


def test_an_ambiguous_answer_by_hand() -> None:
    recognition = ambiguous("plane")
    for told, other in zip(recognition.to_dict()["alternatives"], recognition.alternatives, strict=True):
        assert told["error"] == reference(other.error)
