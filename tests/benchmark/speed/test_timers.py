"""Timers around functions by name: what they count, what they leave as it was, and names that are gone."""

import sys
from types import ModuleType

import pytest

from primfit.benchmark.speed import timers as timers_module
from primfit.benchmark.speed.timers import Clock, NameGoneError, check_entered, timers


@pytest.fixture
def package(monkeypatch):
    """A package of two modules, one of which has imported a function of the other by another name.

    Only `work.spend` takes time.
    """
    now = [0.0]
    monkeypatch.setattr(timers_module.time, "process_time_ns", lambda: int(1e9 * now[0]))
    made, user = ModuleType("made.work"), ModuleType("made.user")

    def spend(seconds):
        now[0] += seconds

    class Tool:
        @classmethod
        def make(cls):
            made.inner()
            spend(1.0)
            return cls

    made.spend, made.inner, made.Tool = spend, lambda: spend(3.0), Tool
    user.borrowed = made.inner
    for name, module in (("made", ModuleType("made")), ("made.work", made), ("made.user", user)):
        monkeypatch.setitem(sys.modules, name, module)
    return made, user


def test_time_within_an_inner_step_is_not_that_of_the_outer_one(package):
    made, _ = package
    clock = Clock()
    with timers(clock, {"outer": ["work:Tool.make"], "inner": ["work:inner"]}, "made"), clock.step("rest"):
        assert made.Tool.make() is made.Tool
        made.spend(2.0)
        made.inner()
    assert clock.seconds == {"outer": 1.0, "inner": 6.0, "rest": 2.0}
    assert clock.entries == {"outer": 1, "inner": 2, "rest": 1}
    clock.reset()
    assert not clock.seconds and not clock.entries and clock.entered == {"outer", "inner", "rest"}


def test_functions_are_timed_wherever_they_were_imported_and_put_back(package):
    made, user = package
    before, clock = (made.inner, user.borrowed, vars(made.Tool)["make"]), Clock()
    with timers(clock, {"inner": ["work:inner"], "make": ["work:Tool.make"]}, "made"):
        user.borrowed()
        assert made.inner is not before[0]
    assert clock.seconds == {"inner": 3.0}
    assert (made.inner, user.borrowed, vars(made.Tool)["make"]) == before


def test_what_is_raised_within_a_step_ends_it(package):
    made, _ = package
    made.fails = lambda: 1 // 0
    clock = Clock()
    with timers(clock, {"fails": ["work:fails"]}, "made"), clock.step("rest"):
        with pytest.raises(ZeroDivisionError):
            made.fails()
        made.spend(1.0)
    assert clock.seconds == {"fails": 0.0, "rest": 1.0}


@pytest.mark.parametrize("name", ["work:gone", "work:Tool.gone", "work:Gone.make", "gone:inner"])
def test_a_name_that_is_gone_is_named_and_nothing_stays_timed(package, name):
    made, _ = package
    before = made.inner
    steps = {"inner": ["work:inner"], "lost": [name]}
    with pytest.raises(NameGoneError, match=rf"`lost` names made\.{name}, which is gone; .*table\.py"):
        with timers(Clock(), steps, "made"):
            pass
    assert made.inner is before


def test_a_step_that_nothing_leads_into_is_named():
    clock = Clock()
    with clock.step("used"):
        pass
    check_entered(clock, {"used": ["a:b"]})
    with pytest.raises(NameGoneError, match=r"`idle` was never entered: nobody calls c:d, e:f"):
        check_entered(clock, {"used": ["a:b"], "idle": ["c:d", "e:f"]})
