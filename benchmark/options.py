"""The options of `primfit bench`."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from primfit.synthetic.recipes import FEWEST

from .batch import LEAST
from .cases import CASE_SETS
from .coverage import LAWS
from .methods import METHODS
from .proofs import PROOFS
from .scaling.options import Action, add_scaling
from .service import BODIES, SIZES

FOLDER = Path("build/bench")
"""Where records are kept unless something else is said."""

LEARNT = (2022, 2023, 2024, 20220, 20221)
"""Seeds of the clouds that the shipped classifiers were trained, calibrated and scored on, and the paper's
methods."""

LONGEST = 86400.0
"""Seconds that an answer may be waited for at most."""


def make_parser(
    program: str,
    run: Callable[..., int],
    report: Callable[..., int],
    service: Callable[..., int],
    coverage: Callable[..., int],
    proofs: Callable[..., int],
    drawing: Callable[..., int],
    steps: Callable[..., int],
    speed: Callable[..., int],
    batch: Callable[..., int],
    scaling: Mapping[str, Action],
) -> argparse.ArgumentParser:
    """A parser whose result holds `action`, one of the functions, which takes the result."""
    parser = argparse.ArgumentParser(
        prog=program,
        description="Measure primfit and what others make on the same clouds, and write the report.",
        epilog=f"""examples:
  {program} run                       primfit on small sets, a few minutes
  {program} run --set shrec --n 500 --seed 7 --method primfit --method primfit-knn
  {program} run --shrec22 DIR         a folder in the layout of the SHREC 2022 track
  {program} run --real DIR            segments of real scans, with a manifest of their kinds
  {program} run --full --peers        everything, a few hours; goes on where it was cut off
  {program} report                    tables and pictures from the records
  {program} service                   what a request to the service takes more than the fit alone
  {program} coverage --n 100          do the 95% intervals hold the truth?
  {program} proofs --seed 7           beside independent optimizers, and turned, moved, scaled, permuted
  {program} drawing                   how many clouds of each recipe are drawn in a minute
  {program} steps                     how long each step of a fit takes, and what the machine could do
  {program} speed                     primfit beside other libraries, and by the number of points
  {program} batch                     what more processes gain `primfit batch`
  {program} scaling run --n 1000      `primfit batch` watched, and killed, on one machine and on a cluster

`{program} run --help` lists the sets and the methods. docs/benchmarking.md explains them.""",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = parser.add_subparsers(
        title="actions",
        metavar="run | report | service | coverage | proofs | drawing | steps | speed | batch | scaling",
    )
    _add_run(actions).set_defaults(action=run)
    _add_report(actions).set_defaults(action=report)
    _add_service(actions).set_defaults(action=service)
    _add_coverage(actions).set_defaults(action=coverage)
    _add_proofs(actions).set_defaults(action=proofs)
    _add_drawing(actions).set_defaults(action=drawing)
    _add_steps(actions).set_defaults(action=steps)
    _add_speed(actions).set_defaults(action=speed)
    _add_batch(actions).set_defaults(action=batch)
    add_scaling(actions, scaling)
    return parser


def _add_run(actions: Any) -> argparse.ArgumentParser:
    sets = "\n".join(
        f"  {name:16} {chosen.description.title} ({chosen.small} clouds, full: {chosen.full})"
        for name, chosen in CASE_SETS.items()
    )
    parser: argparse.ArgumentParser = actions.add_parser(
        "run",
        help="run methods over case sets and store a record for each cloud",
        description="Run methods over case sets and store a record for each cloud. "
        "A run that was cut off goes on.",
        epilog=f"sets:\n{sets}\n\nmethods, the first by default:\n  {', '.join(METHODS)}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--set", action="append", choices=CASE_SETS, metavar="NAME", help="a set (repeatable; default: all)")
    add("--shrec22", type=Path, metavar="DIR", help="a folder in the layout of the SHREC 2022 track")
    add("--real", type=Path, metavar="DIR", help="a folder of segments of real scans with a manifest.csv")
    add("--method", action="append", choices=METHODS, metavar="NAME", help="a method (repeatable)")
    add("--peers", action="store_true", help="all methods of others that are installed, too")
    sizes = parser.add_mutually_exclusive_group()
    sizes.add_argument("--n", type=_whole_from_1, metavar="N", help="the first N clouds of each set")
    sizes.add_argument("--full", action="store_true", help="large sets instead of small ones")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    add("--timeout", type=_seconds, default=60.0, metavar="S", help="seconds for a cloud (default: 60)")
    add("--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder of the records (default: {FOLDER})")
    add("--restart", action="store_true", help="make the records anew that are asked for")
    add("--show-wrong", action="store_true", help="print a line for each wrong answer")
    add("--python", type=_file, metavar="FILE", help="what runs the methods (default: .venv-peers, or this)")
    return parser


def _add_report(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "report",
        help="write benchmark.md and its pictures from the records",
        description="Write benchmark.md, benchmark-details.md and images/benchmark-*.png from the records, "
        "and where there are any of the paper's methods benchmark-six.md; nothing is measured.",
    )
    for name, default, what in (("records", FOLDER, "records"), ("out", FOLDER / "report", "report")):
        text = f"folder of the {what} (default: {default})"
        parser.add_argument(f"--{name}", type=Path, default=default, metavar="DIR", help=text)
    return parser


def _add_service(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "service",
        help="measure what a request to the service takes more than the fit alone",
        description="Start the service, and time requests and the fit alone in turns.",
    )
    add = parser.add_argument
    sizes = ", ".join(f"{size:,}" for size in SIZES)
    add(
        "--points",
        type=_whole_from_3,
        action="append",
        metavar="N",
        help=f"a size (repeatable; default: {sizes})",
    )
    add(
        "--format",
        action="append",
        choices=BODIES,
        metavar="NAME",
        help=f"of {', '.join(BODIES)} (default: all)",
    )
    add("--turns", type=_whole_from_1, default=5, metavar="N", help="through each cloud (default: 5)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    add("--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder of service.log (default: {FOLDER})")
    add("--picture", type=Path, metavar="FILE", help="draw the figure of docs/benchmarking.md")
    return parser


def _add_coverage(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "coverage",
        help="do the 95%% intervals hold the truth, and do warnings come when they should?",
        description="Fit clouds whose truth and noise are known, and write uncertainty-coverage.md and "
        "images/uncertainty-coverage.png.",
    )
    add = parser.add_argument
    add(
        "--n",
        type=_whole_from_1,
        default=100,
        metavar="N",
        help="clouds of each kind and noise (default: 100)",
    )
    add("--law", action="append", choices=LAWS, metavar="NAME", help="a noise (repeatable; default: all)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    add("--processes", type=_whole_from_1, default=1, metavar="N", help="that share the work (default: 1)")
    add("--out", type=Path, default=FOLDER / "report", metavar="DIR", help="folder of both files")
    return parser


def _add_proofs(actions: Any) -> argparse.ArgumentParser:
    sets = "\n".join(
        f"  {name:16} {proof.about} ({proof.small} cases, full: {proof.full})"
        for name, proof in PROOFS.items()
    )
    parser: argparse.ArgumentParser = actions.add_parser(
        "proofs",
        help="hold answers against independent optimizers, and against those for the cloud transformed",
        description="Draw cases from a seed, measure them, and store a record for each in proofs.jsonl, "
        "which the report reads. A run that was cut off goes on; another seed replaces the one before.",
        epilog=f"sets:\n{sets}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--set", action="append", choices=PROOFS, metavar="NAME", help="a set (repeatable; default: all)")
    sizes = parser.add_mutually_exclusive_group()
    sizes.add_argument("--n", type=_whole_from_1, metavar="N", help="the first N cases of each set")
    sizes.add_argument("--full", action="store_true", help="large sets instead of small ones")
    add("--seed", type=_seed, default=1, metavar="S", help="of all cases (default: 1)")
    add("--processes", type=_whole_from_1, default=1, metavar="N", help="that share the work (default: 1)")
    add("--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder of the records (default: {FOLDER})")
    add("--restart", action="store_true", help="make the records anew that are asked for")
    return parser


def _add_drawing(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "drawing",
        help="measure how many clouds of each recipe are drawn in a minute",
        description="Draw clouds of each recipe, and show how many there would be in a minute of one core.",
    )
    add = parser.add_argument
    add("--seconds", type=_seconds, default=5.0, metavar="S", help="of each recipe (default: 5)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    return parser


def _add_batch(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "batch",
        help="measure what more processes gain `primfit batch`, and what sharing the work costs",
        description="Answer the same scans by one process and by several, in turns, and a few of them, which "
        "shows what a start takes. Of each the least time counts: other programs only add to it.",
    )
    add = parser.add_argument
    add("--n", type=_clouds, default=1000, metavar="N", help="clouds (default: 1000)")
    add("--points", type=_scan, default=3000, metavar="N", help="points of each (default: 3000)")
    add("--workers", type=_whole_from_1, default=2, metavar="N", help="processes beside one (default: 2)")
    add("--turns", type=_whole_from_1, default=3, metavar="N", help="runs of each (default: 3)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    return parser


def _clouds(text: str) -> int:
    value = _whole_from_1(text)
    if value < LEAST:
        raise argparse.ArgumentTypeError(
            f"{value} is too few: the start would blur the rest (from {LEAST} on)"
        )
    return value


def _scan(text: str) -> int:
    value = _whole_from_1(text)
    if value < FEWEST:
        raise argparse.ArgumentTypeError(f"{value} is too few; a scan has at least {FEWEST} points")
    return value


def _add_steps(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "steps",
        help="measure how long each step of an answer takes, beside the least that this machine allows",
        description="Time the steps of answers, and show them beside their floors: operations that are "
        "needed, at the speed that is measured in the same run.",
    )
    add = parser.add_argument
    add("--n", type=_whole_from_1, default=3, metavar="N", help="clouds of each kind and set (default: 3)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    add("--write", action="store_true", help="write the tables into docs/performance.md")
    add("--keep", action="store_true", help="keep the figures, for later runs to be compared with")
    add("--compare", action="store_true", help="name the steps that are slower than what was kept, exit 1")
    return parser


def _add_speed(actions: Any) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(
        "speed",
        help="time primfit beside other libraries on the same clouds, and by the number of points",
        description="Time primfit, engeom and CGAL, where they are installed, in turns on clouds of "
        "shrec, scanner and sensor, and primfit alone on 1,000 to 1,000,000 points.",
    )
    add = parser.add_argument
    add("--n", type=_whole_from_1, default=100, metavar="N", help="clouds of each set (default: 100)")
    add("--seed", type=_seed, default=1, metavar="S", help="of all clouds (default: 1)")
    add("--real", type=Path, metavar="DIR", help="a folder of segments of real scans with a manifest.csv")
    add(
        "--largest",
        type=_whole_from_1,
        default=1_000_000,
        metavar="N",
        help="most points (default: a million)",
    )
    add("--write", action="store_true", help="write the tables into docs/performance.md")
    add("--out", type=Path, default=FOLDER, metavar="DIR", help=f"folder of methods.log (default: {FOLDER})")
    add("--python", type=_file, metavar="FILE", help="what runs the methods (default: .venv-peers, or this)")
    return parser


def _file(text: str) -> Path:
    if not Path(text).is_file():
        raise argparse.ArgumentTypeError(f"is {text}, which is no file")
    return Path(text)


def _whole(text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"is {text}, not a whole number from {least} on")
    return int(text)


def _whole_from_1(text: str) -> int:
    return _whole(text, 1)


def _whole_from_3(text: str) -> int:
    return _whole(text, 3)


def _seed(text: str) -> int:
    value = _whole(text, 0)
    if value in LEARNT:
        seen = f"what is measured has seen clouds of the seeds {', '.join(map(str, LEARNT))}"
        raise argparse.ArgumentTypeError(f"is {value}; {seen}")
    return value


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= LONGEST:
        raise argparse.ArgumentTypeError(f"is {text}, not a number of seconds above 0 and up to {LONGEST:g}")
    return value
