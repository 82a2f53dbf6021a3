"""How segments are cut into tasks: in their order, none twice, and none too long."""

from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.app.bulk.refs import Ref
from primfit.app.bulk.tasks import LARGEST, LONGEST, seconds, tasks


def refs(sizes: list[int]) -> list[Ref]:
    return [Ref(str(i), "file", i, size) for i, size in enumerate(sizes)]


def cost(cut: tuple[Ref, ...]) -> float:
    return seconds(len(cut), sum(ref.n_points for ref in cut))


@settings(deadline=None)
@given(st.lists(st.integers(0, 2_000_000), max_size=300))
def test_every_segment_is_in_one_task_and_no_task_of_several_takes_long(sizes: list[int]) -> None:
    found = list(tasks(refs(sizes)))
    assert [task.number for task in found] == list(range(len(found)))
    assert [ref for task in found for ref in task.refs] == refs(sizes)
    for task, after in pairwise(found):
        assert len(task.refs) == 1 or cost(task.refs) <= LONGEST * (1 + 1e-9)
        assert len(task.refs) == LARGEST or cost((*task.refs, after.refs[0])) > LONGEST * (1 - 1e-9)


def test_small_segments_are_hundreds_a_task_and_never_more_than_the_most() -> None:
    assert {len(task.refs) for task in list(tasks(refs([1000] * 2000)))[:-1]} <= set(range(100, LARGEST + 1))


def test_it_is_a_stream() -> None:
    taken = []

    def endless() -> object:
        number = 0
        while True:
            taken.append(number)
            yield Ref(str(number), "file", number, 1000)
            number += 1

    first = next(tasks(endless()))  # type: ignore[arg-type]
    assert len(taken) == len(first.refs) + 1
