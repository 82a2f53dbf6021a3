"""`primfit bench speed`: primfit beside others on the same clouds, one after the other, in processor time.

The methods take turns cloud by cloud, so that a noisy machine hits all alike; each cloud is asked once, of
warm processes on one thread. Nothing is stored but the report.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from primfit.synthetic.recipes import KINDS

from ..cases import CASE_SETS, Case
from ..real import REAL, RealFolder
from ..records import Outcome
from ..runner import Child, asked_about, introduce
from ..service import scan

OURS, REVERSED = "primfit-whole", "primfit-whole-reversed"
PROGRAM = ("-m", "primfit.benchmark.speed.whole")
METHODS = (OURS, REVERSED, "engeom", "cgal")
CALLED = {
    OURS: "primfit",
    REVERSED: "primfit, ranking reversed",
    "engeom": "engeom, kind given",
    "cgal": "CGAL, kind sought",
}
SETS = ("shrec", "scanner", "sensor")
SIZES = (1000, 10_000, 100_000, 1_000_000)
"""Points of scans, one of each kind, on which primfit alone is timed."""
TIMES = 3
"""How often each of those is fitted, once warm; the fastest counts."""
PATIENCE = 60.0
"""Seconds that an answer is waited for."""
MS = 1e3


@dataclass(frozen=True)
class Lap:
    """One cloud: where it is from, its true kind, its points, and what each method that was asked took."""

    set: str
    kind: str
    points: int
    outcomes: Mapping[str, Outcome]

    def seconds(self, method: str, with_normals: bool = True) -> float | None:
        """Of the processor; None where the method was not asked or gave up."""
        outcome = self.outcomes.get(method)
        if outcome is None or outcome.cpu_seconds is None or outcome.status == "error":
            return None
        return outcome.cpu_seconds - (0.0 if with_normals else outcome.normals_seconds)


@dataclass(frozen=True)
class Race:
    """All laps, the milliseconds of primfit by size, and what was told of each method."""

    laps: Sequence[Lap]
    by_size: Mapping[int, float]
    machine: str
    versions: Mapping[str, str]
    missing: Mapping[str, str]


def run(
    each: int,
    seed: int,
    python: Path,
    log: Path,
    real: Path | None = None,
    sizes: Sequence[int] = SIZES,
    watch: Callable[[Iterator[Lap], int], Iterable[Lap]] = lambda laps, count: laps,
) -> Race:
    """So many clouds of each set, all segments of the folder, and the sizes.

    `watch` gets the laps as they come, and their number, and passes them on.

    Raises
    ------
    MethodError, RealError : a method cannot be started, or the folder cannot be read
    """
    with Child(python, log, PROGRAM) as child:
        told = introduce(child, METHODS)
        missing = {name: about["missing"] for name, about in told.items() if "missing" in about}
        there = {name: about for name, about in told.items() if name not in missing}
        folder = None if real is None else RealFolder(real)
        count = each * len(SETS) + (len(folder.names) if folder else 0)
        coming = (lap(child, there, set, case) for set, case in clouds(each, seed, folder))
        laps = list(watch(coming, count))
        by_size = {size: MS * _of_size(child, seed, size) for size in sizes}
    versions = {name: about["versions"][about["package"]] for name, about in there.items()}
    versions[OURS] = f"(source {there[OURS]['versions']['source']})"
    return Race(laps, by_size, there[OURS]["machine"], versions, missing)


def clouds(each: int, seed: int, real: RealFolder | None) -> Iterator[tuple[str, Case]]:
    """The sets in turn, a cloud of each; then the segments."""
    for index in range(each):
        for name in SETS:
            yield name, CASE_SETS[name].draw(seed, index)
    if real is not None:
        for name in real.names:
            yield REAL, real.case(name)


def lap(child: Child, methods: Mapping[str, dict[str, object]], set: str, case: Case) -> Lap:
    """All methods on one cloud."""
    outcomes = {
        name: child.fit(name, case, None if about["decides_kind"] else case.kind, PATIENCE)
        for name, about in methods.items()
        if asked_about(about, case.kind)
    }
    return Lap(set, case.kind, len(case.points), outcomes)


def _of_size(child: Child, seed: int, size: int) -> float:
    """Seconds of the processor: the median over the kinds."""
    fastest = []
    for kind in KINDS:
        case = scan(seed, kind, size)
        outcomes = [child.fit(OURS, case, None, PATIENCE) for _ in range(1 + TIMES)]
        fastest.append(min(outcome.cpu_seconds or np.nan for outcome in outcomes[1:]))
    return float(np.median(fastest))


# -- the section of docs/performance.md ---------------------------------------------------------------------


def section(race: Race) -> str:
    parts = [_about(race), _methods(race), _sets(race), _kinds(race), _scaling(race)]
    return "\n\n".join(part for part in parts if part)


def _about(race: Race) -> str:
    counts = {name: sum(lap.set == name for lap in race.laps) for name in (*SETS, REAL)}
    told = ", ".join(f"{count} of `{name}`" for name, count in counts.items() if count)
    versions = ", ".join(
        f"{CALLED[name].partition(',')[0]} {version}"
        for name, version in race.versions.items()
        if name != REVERSED
    )
    left_out = "".join(f" {name} is not installed." for name in race.missing)
    return f"{len(race.laps)} clouds ({told}); {race.machine}, one thread; {versions}.{left_out}"


def _pairs(race: Race, method: str, with_normals: bool) -> np.ndarray:
    """(C, 2) milliseconds of a method and of primfit on the clouds that both answered."""
    found = [(lap.seconds(method, with_normals), lap.seconds(OURS)) for lap in race.laps]
    return MS * np.array([pair for pair in found if None not in pair], np.float64).reshape(-1, 2)


def _methods(race: Race) -> str:
    names = ("method", "clouds", "median", "95% below", "ratio of medians", "median of ratios")
    lines = [f"| {' | '.join(names)} | without normals | gave up |", "|" + "---|" * 8]
    for name in race.versions:
        times, bare = _pairs(race, name, True), _pairs(race, name, False)
        asked = sum(name in lap.outcomes for lap in race.laps)
        if not len(times):
            lines.append(f"| {CALLED[name]} | 0 | – | – | – | – | – | {asked} |")
            continue
        median, ours = np.median(times, axis=0)
        cells = [f"{len(times)}", f"{median:.1f} ms", f"{np.percentile(times[:, 0], 95):.1f} ms"]
        cells += [f"{median / ours:.2f}", f"{np.median(times[:, 0] / times[:, 1]):.2f}"]
        apart = (times != bare).any()
        cells.append(
            f"{np.median(bare[:, 0]):.1f} ms, ratio {np.median(bare[:, 0]) / ours:.2f}" if apart else "–"
        )
        lines.append(f"| {CALLED[name]} | {' | '.join(cells)} | {asked - len(times)} |")
    return "\n".join(lines)


def _cells(laps: Sequence[Lap], methods: Sequence[str]) -> str:
    """The medians of each method over some clouds."""
    cells = []
    for name in methods:
        spent = [value for lap in laps if (value := lap.seconds(name)) is not None]
        cells.append(f"{MS * np.median(spent):.1f} ms" if spent else "–")
    return " | ".join(cells)


def _grouped(race: Race, title: str, groups: Mapping[str, Callable[[Lap], bool]]) -> str:
    """A table with a row for each group that has clouds."""
    names = list(race.versions)
    head = (
        f"| {title} | clouds | points | {' | '.join(CALLED[name] for name in names)} | primfit, 95% below |"
    )
    lines = [head, "|" + "---|" * (4 + len(names))]
    for group, belongs in groups.items():
        laps = [lap for lap in race.laps if belongs(lap)]
        ours = [value for lap in laps if (value := lap.seconds(OURS)) is not None]
        if ours:
            points = np.median([lap.points for lap in laps])
            lines.append(
                f"| {group} | {len(laps)} | {points:,.0f} | {_cells(laps, names)} "
                f"| {MS * np.percentile(ours, 95):.1f} ms |"
            )
    return "\n".join(lines)


def _sets(race: Race) -> str:
    return _grouped(race, "set", {name: partial(_is_of, set=name) for name in (*SETS, REAL)})


def _is_of(lap: Lap, set: str | None = None, kinds: Sequence[str] = KINDS) -> bool:
    return lap.kind in kinds and set in (None, lap.set)


def _kinds(race: Race) -> str:
    others = [kind for kind in KINDS if kind != "torus"]
    groups = {kind: partial(_is_of, kinds=(kind,)) for kind in KINDS}
    groups["all but tori"] = partial(_is_of, kinds=others)
    table = _grouped(race, "true kind", groups)
    ours = {
        torus: [value for lap in race.laps if (lap.kind == "torus") == torus and (value := lap.seconds(OURS))]
        for torus in (True, False)
    }
    if not (ours[True] and ours[False]):
        return table
    ratio = np.median(ours[True]) / np.median(ours[False])
    return f"{table}\n\nA torus takes primfit {ratio:.2f} times as long as the others, by medians."


def exponent(by_size: Mapping[int, float]) -> float:
    """The slope of the logarithm of the time over that of the number of points, by least squares."""
    sizes, times = np.log(list(by_size)), np.log(list(by_size.values()))
    return float(np.polyfit(sizes, times, 1)[0])


def _scaling(race: Race) -> str:
    if len(race.by_size) < 2:
        return ""
    lines = ["| points of a scan | primfit | exponent from the size before |", "|---|---|---|"]
    before: tuple[int, float] | None = None
    for size, spent in race.by_size.items():
        steep = "–" if before is None else f"{exponent({before[0]: before[1], size: spent}):.2f}"
        lines.append(f"| {size:,} | {spent:.1f} ms | {steep} |")
        before = (size, spent)
    lines += ["", f"Over all sizes the time grows as the {exponent(race.by_size):.2f}th power of the points."]
    return "\n".join(lines)
