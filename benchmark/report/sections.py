"""The sections of benchmark.md, each as lines of Markdown."""

from collections.abc import Callable, Collection, Iterator, Sequence

from primfit.synthetic.recipes import KINDS

from ..measures import GRID
from ..records import SAMPLED, Record
from ..scores import CLOSE, EXACT, REJECTIONS, is_close, share
from .beside_paper import beside_the_paper
from .cells import level_name, measured, median, name_of, outcomes_of
from .data import OURS, Data, common, described, median_seconds
from .details import WITHOUT_ERRORS
from .markdown import NOTHING, commands, count, milliseconds, percent, scientific, table

HEADLINE = {"shrec": "benchmark", "scanner": "scans"}
"""The two sets that stand for all at a glance."""

WEAK = 0.95
MOST_WEAK = 15
"""Groups in which primfit is right less often than this are listed, so many at most."""
CLEARLY = 0.9
"""Ahead is who needs less than this share of the other's error or time."""


def head(data: Data) -> Iterator[str]:
    machines = sorted({str(about["machine"]) for about in data.about.values() if "machine" in about})
    clouds = len({record.key[:3] for record in data.records})
    yield "# Benchmark"
    yield ""
    yield "<!-- Written by `primfit bench report`; change benchmark/report/, not this file. -->"
    yield ""
    yield (
        f"primfit and what people use instead, on the same {clouds:,} clouds: who is right how often, how "
        "exact, how fast. One process, one thread, warm; the methods take turns cloud by cloud, and one "
        "that has changed since is measured anew by itself; one with fewer clouds of a set has the first of "
        f"them; {', '.join(machines)}. `make bench-full` runs "
        "all of it; the commands below make a part each. [benchmarking.md](benchmarking.md) says more; "
        "[benchmark-details.md](benchmark-details.md) has every table by perturbation, size and level."
    )


# -- at a glance --------------------------------------------------------------------------------------------


def at_a_glance(data: Data, drawn: Collection[str]) -> Iterator[str]:
    shown = {set_: name for set_, name in HEADLINE.items() if set_ in data.sets}
    if not shown:
        return
    header = ["method", "kind"]
    for name in shown.values():
        header += [f"{name}: kind right", "within 1%", "error", "ms"]
    yield "## At a glance"
    yield ""
    seen = [method for method in data.methods if any(data.of_set(set_, method) for set_ in shown)]
    yield from table(header, [_glance(data, method, list(shown)) for method in seen], left=2)
    yield ""
    yield (
        "*within 1%*: the kind is right, and the found surface within 1% of the cloud's extent of the true "
        "one (root mean square, where the cloud is). *error*: that distance, as a share of the extent, "
        "median. *ms*: a cloud, median. A wrong kind, `ambiguous` and `no_fit` count as wrong and as "
        "infinitely far. Methods that do not find the kind are *given* the true one and asked only for kinds "
        "that they know: their figures are easier to reach."
    )
    yield ""
    if "overview" in drawn:
        yield from _picture("overview", "Accuracy against time, on the benchmark and on scans")
    yield from commands([*data.commands(shown), "primfit bench report"])


def _glance(data: Data, method: str, sets: Sequence[str]) -> list[str]:
    decides = data.decides(method)
    known = len(data.about[method]["kinds"])
    asked = "found" if decides else "given"
    cells = [name_of(method), asked if known == len(KINDS) else f"{asked}, {known} of {len(KINDS)}"]
    for set_ in sets:
        records = data.of_set(set_, method)
        cells += [
            percent(share(records, lambda record: record.right)) if decides else NOTHING,
            percent(share(records, is_close)),
            scientific(median(records, "surface")),
            milliseconds(median_seconds(records)),
        ]
    return cells


# -- where primfit is not ahead -----------------------------------------------------------------------------


def behind(data: Data) -> Iterator[str]:
    yield "## Where primfit is not ahead"
    yield ""
    others = [method for method in data.methods if method.split("-")[0] != OURS]
    if others:
        yield (
            "Against each other method, on the clouds that both were asked about (theirs against ours): the "
            "share right and within 1%, the median surface error, the median time in ms."
        )
        yield ""
        given = {method: "" if data.decides(method) else " (kind given)" for method in others}
        rows = [[method + given[method], *_ahead(data, method)] for method in others]
        yield from table(["method", "more often right", "more exact", "faster"], rows, left=4)
        yield ""
    weak = sorted(_weak_groups(data), key=lambda row: row[0])
    if not weak:
        yield f"primfit is right on {percent(WEAK, 0)} of the clouds of every group, or more."
        return
    yield f"Where primfit is right on less than {percent(WEAK, 0)} of the clouds, the weakest first:"
    yield ""
    header = ["set", "group", "right", "another kind", *REJECTIONS[:2], "clouds"]
    yield from table(header, [row for _, row in weak[:MOST_WEAK]], left=2)
    if len(weak) > MOST_WEAK:
        yield ""
        yield f"And {len(weak) - MOST_WEAK} more groups, which the tables below show."


def _ahead(data: Data, method: str) -> list[str]:
    """Three cells: the sets on which this method is ahead of primfit, with figures."""
    cells: list[list[str]] = [[], [], []]
    for set_ in data.sets:
        ours, theirs = common(data.of_set(set_, OURS), data.of_set(set_, method))
        if not ours:
            continue
        shares = [share(records, is_close) for records in (theirs, ours)]
        errors = [median(records, "surface") for records in (theirs, ours)]
        times = [median_seconds(records) for records in (theirs, ours)]
        if shares[0] > shares[1]:
            cells[0].append(f"{set_} {' / '.join(map(percent, shares))}")
        if errors[1] > EXACT and errors[0] < CLEARLY * errors[1]:
            cells[1].append(f"{set_} {' / '.join(map(scientific, errors))}")
        if times[0] < CLEARLY * times[1]:
            cells[2].append(f"{set_} {' / '.join(map(milliseconds, times))}")
    return ["<br>".join(cell) or NOTHING for cell in cells]


def _weak_groups(data: Data) -> Iterator[tuple[float, list[str]]]:
    for set_ in data.sets:
        for group in data.groups(set_):
            for level in data.levels(set_, group):
                records = [r for r in data.at_level(set_, group, level) if r.method == OURS]
                right = share(records, lambda record: record.right)
                if right < WEAK:
                    yield (
                        right,
                        [set_, f"{group}: {level_name(level)}", *outcomes_of(records), f"{len(records)}"],
                    )


# -- one set ------------------------------------------------------------------------------------------------


def of_set(data: Data, set_: str, drawn: Collection[str]) -> Iterator[str]:
    """What it is, who is right how often and how exactly, and what is special to it."""
    description = described(set_)
    yield f"## {description.title}"
    yield ""
    yield description.about
    yield ""
    yield from outcomes(data, set_)
    yield ""
    for group in data.groups(set_):
        yield from by_level(data, set_, group)
        yield ""
    if set_ not in WITHOUT_ERRORS:
        yield from errors_by_level(data, set_, data.groups(set_)[0])
        yield ""
    for name, shows in PICTURES.get(set_, {}).items():
        if name in drawn:
            yield from _picture(name, shows)
    if set_ in SAMPLED:
        yield from beside_the_paper(data, set_)
        yield ""
    yield from commands([*data.commands([set_]), "primfit bench report"])


PICTURES = {
    "shrec": {
        "perturbations": "Accuracy by perturbation and method",
        "errors": "How the errors are spread, on the benchmark and on scans",
        "confusion": "Confusion matrices",
    },
    "outliers": {"levels": "Accuracy by outliers, arc, exact share, number of points"},
    "sizes": {"time": "Time by number of points"},
}
"""The pictures that stand with a set, and what they show."""


def _picture(name: str, shows: str) -> Iterator[str]:
    yield f"![{shows}](images/benchmark-{name}.png)"
    yield ""


def outcomes(data: Data, set_: str) -> Iterator[str]:
    """A row for each method: how often right and wrong in which way, how far, how long."""
    header = ["method", "clouds", "kind right", "another kind", *REJECTIONS, "within 1%"]
    header += ["surface error", "parameter error", "position error", "ms"]
    rows = []
    for method, records in data.by_method(data.of_set(set_)).items():
        right, *wrong = outcomes_of(records, failed=True)
        rows.append(
            [
                name_of(method),
                f"{len(records):,}",
                right if data.decides(method) else "given",
                *wrong,
                percent(share(records, is_close)),
                *(
                    scientific(median(measured(records, e), e))
                    for e in ("surface", "relative_l2", "relative_position")
                ),
                milliseconds(median_seconds(records)),
            ]
        )
    yield from table(header, rows)


def by_level(data: Data, set_: str, group: str) -> Iterator[str]:
    """A row for each method, a column for each level: the share right and within 1 %."""
    yield f"Right and within 1%, by {group}:"
    yield ""
    yield from _levels(data, set_, group, lambda records: percent(share(records, is_close), 0))


def errors_by_level(data: Data, set_: str, group: str) -> Iterator[str]:
    yield f"Surface error, median, by {group}:"
    yield ""
    yield from _levels(data, set_, group, lambda records: scientific(median(records, "surface")))


def _levels(data: Data, set_: str, group: str, cell: Callable[[list[Record]], str]) -> list[str]:
    levels = data.levels(set_, group)
    rows = []
    for method, records in data.by_method(data.of_set(set_)).items():
        at = [[r for r in records if r.groups.get(group) == level] for level in levels]
        rows.append([name_of(method), *map(cell, at)])
    return table(["method", *map(level_name, levels)], rows)


# -- the rest -----------------------------------------------------------------------------------------------


def methods(data: Data) -> Iterator[str]:
    yield "## The methods"
    yield ""
    header = [
        "method",
        "version",
        "kind",
        "kinds",
        "settings",
        "clouds",
        "errors",
        "crashes",
        "timeouts",
        "threads",
    ]
    rows = []
    for method in data.methods:
        about = data.about[method]
        records = data.of_method(method)
        failures = [sum(r.status == status for r in records) for status in ("error", "crash", "timeout")]
        rows.append(
            [
                name_of(method),
                about["versions"][about["package"]],
                "decides" if about["decides_kind"] else "is given",
                "all" if len(about["kinds"]) == len(KINDS) else ", ".join(about["kinds"]),
                about["settings"],
                f"{len(records):,}",
                *map(count, failures),
                _threads(records),
            ]
        )
    yield from table(header, rows, left=5)
    yield ""
    yield (
        "*errors*: exceptions; *crashes*: the process ended; *timeouts*: no answer within the limit, after "
        "which the process is killed. All count as wrong. *threads*: processor time over wall clock."
    )


def _threads(records: Sequence[Record]) -> str:
    wall = sum(record.seconds or 0.0 for record in records if record.cpu_seconds is not None)
    processor = sum(record.cpu_seconds or 0.0 for record in records)
    return f"{processor / wall:.1f}" if wall else NOTHING


MEASURES = f"""## The measures

- **kind right**: the answer is `fitted` and its kind the true one. `ambiguous` and `no_fit` are wrong, but of
  a shape that is no primitive `no_fit` is right, and of a pair that nobody can tell the simpler kind.
- **surface error**: the points are carried to the true surface along its normals; the root mean square of
  their distances to the found surface, over the extent. Points that are known to be outliers are left out. It
  compares any two kinds, counts positions, and forgives parameters that the cloud says nothing about.
- **within 1%**: the kind is right and the surface error at most {CLOSE:g}. **exact**: at most {EXACT:g};
  below that nobody is called more exact than another.
- **extent**: the diagonal of the bounding box of the points that belong to the surface.
- **L2**: the track's distance between the parameter vectors, in the unit of the clouds, minimized over the
  sign of the axis, a torus's radii sorted. It leaves out where planes and cylinders are.
- **parameter error**: L2 with lengths over the extent, so that clouds in different units compare.
- **position error**: what L2 leaves out, over the extent: difference of a plane's offsets at the cloud's
  centroid; distance of a cylinder's axis from the point of the true one that is closest to the centroid.
  Planes and cylinders only.
- **MFE**, **directed Hausdorff**: mean distance of all points to the found surface over the diagonal of their
  bounding box; largest such distance, in the unit of the clouds. Exact, or to the closest of {GRID} x {GRID}
  samples of the surface as in the paper.
- **PPV, NPV, TPR, TNR, ACC**: of each class against the rest; a rejection predicts no class. Macro: the mean
  over the classes.
- Quartiles are values that occur; every error of a wrong answer counts as infinite."""
