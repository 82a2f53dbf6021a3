"""The options of `primfit bench scaling`."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, get_args

from .model import FILE
from .records import FOLDER, Executor, Kill
from .sets import PER_FILE

Action = Callable[[argparse.Namespace], int]


def add_scaling(actions: Any, do: Mapping[str, Action]) -> None:
    """Add the action, whose own actions are those of `do`."""
    parser = actions.add_parser(
        "scaling",
        help="measure runs of `primfit batch` on one machine and on a cluster, and simulate larger ones",
        description="Draw segments, run `primfit batch` on them while processes are watched and killed, and "
        "compare, predict and simulate such runs. Runs on a cluster need what `make test-ray` installs. "
        "docs/scaling.md has the figures and the sequence of commands.",
    )
    inner = parser.add_subparsers(title="actions", metavar=" | ".join(do))
    for name, action in do.items():
        added = inner.add_parser(name, help=_HELP[name], description=_HELP[name])
        added.add_argument(
            "--folder", type=Path, default=FOLDER, metavar="DIR", help=f"of all files (default: {FOLDER})"
        )
        _ADD[name](added.add_argument)
        added.set_defaults(action=action)


_HELP = {
    "segments": "Draw segments, where they are not there yet.",
    "run": "Run `primfit batch` once, watched; a run whose record is there is not made again.",
    "compare": "Are the parts of two runs equal byte for byte, and is each segment there once?",
    "runs": "Show all runs that are kept, and what is to be said of them.",
    "scan": "Fit a scan with labels in random order, beside reading it and fitting its segments.",
    "parameters": "Measure the parameters of the simulation: steps alone, and runs of up to 5,000 segments.",
    "predict": "Predict a run, before it is made.",
    "verdict": "Show what became of the predictions; 1 where one was off by more than a tenth.",
    "simulate": "Simulate runs of a million to a billion segments on 10 to 1,000 nodes.",
}


def _add_segments(add: Callable[..., Any]) -> None:
    add("--n", type=segments, required=True, metavar="N", help=f"segments, a multiple of {PER_FILE}")
    add("--seed", type=int, default=1, metavar="S", help="of all segments (default: 1)")
    add("--processes", type=int, default=2, metavar="N", help="that draw (default: 2)")


def _add_run(add: Callable[..., Any]) -> None:
    add_asked(add)
    add("--again", action="store_true", help="make the run anew, and its record")


def add_asked(add: Callable[..., Any]) -> None:
    """What says which run it is."""
    add("--n", type=segments, required=True, metavar="N", help="segments, drawn before")
    add("--seed", type=int, default=1, metavar="S", help="of the segments (default: 1)")
    add("--executor", choices=get_args(Executor), default="local", help="default: local")
    add("--workers", type=int, metavar="N", help="processes (default: 2), or nodes of a cluster (3)")
    add("--kill", choices=get_args(Kill), default="none", help="what is killed by SIGKILL on the way")
    add(
        "--at",
        type=share,
        metavar="X",
        help="share of tasks finished by then (default: node 0.5, driver 0.3)",
    )
    add("--turn", type=int, default=1, metavar="N", help="the same run may be made several times")


def _add_compare(add: Callable[..., Any]) -> None:
    add("names", nargs=2, metavar="RUN", help="such as local-2-1000 and ray-3-1000-node-killed")


def _add_scan(add: Callable[..., Any]) -> None:
    add("--n", type=segments, default=20_000, metavar="N", help="segments (default: 20000)")
    add("--points", type=int, default=2500, metavar="N", help="of each segment (default: 2500)")
    add("--seed", type=int, default=1, metavar="S", help="of all points (default: 1)")
    _add_write(add)


def _add_write(add: Callable[..., Any]) -> None:
    add("--write", action="store_true", help="write the table into docs/scaling.md, too")


def _add_parameters(add: Callable[..., Any]) -> None:
    _add_file(add)
    _add_write(add)


def _add_file(add: Callable[..., Any]) -> None:
    add(
        "--parameters",
        type=Path,
        default=FILE,
        metavar="FILE",
        help="default: benchmark/scaling/parameters.json",
    )


def _add_predict(add: Callable[..., Any]) -> None:
    add_asked(add)
    _add_file(add)


def _add_simulate(add: Callable[..., Any]) -> None:
    _add_parameters(add)
    add("--largest", type=int, default=10**9, metavar="N", help="segments at most (default: a billion)")
    add("--seed", type=int, default=1, metavar="S", help="of all that is drawn (default: 1)")
    add("--processes", type=int, default=2, metavar="N", help="that simulate (default: 2)")


_ADD: dict[str, Callable[[Callable[..., Any]], None]] = {
    "segments": _add_segments,
    "run": _add_run,
    "compare": _add_compare,
    "runs": _add_write,
    "scan": _add_scan,
    "parameters": _add_parameters,
    "predict": _add_predict,
    "verdict": _add_write,
    "simulate": _add_simulate,
}


def segments(text: str) -> int:
    if not text.isdecimal() or not int(text) or int(text) % PER_FILE:
        raise argparse.ArgumentTypeError(f"is {text}, not a multiple of {PER_FILE}")
    return int(text)


def share(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"is {text}, not a share between 0 and 1")
    return value
