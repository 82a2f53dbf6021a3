"""The sections of benchmark.md, each as lines of Markdown."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmark.cases import Level
from benchmark.measures import GRID
from benchmark.records import Record
from benchmark.report import paper
from benchmark.report.data import OURS, Data, common, described, median_seconds
from benchmark.report.markdown import (
    NOTHING,
    commands,
    count,
    milliseconds,
    percent,
    scientific,
    table,
)
from benchmark.scores import (
    ANSWERS,
    CLOSE,
    REJECTIONS,
    answered,
    confusion,
    is_close,
    macro,
    rates,
    share,
    spread,
)
from benchmark.track import TRACK
from fitting.primitives import KINDS

HEADLINE = {"shrec": "benchmark", "scanner": "scans"}
"""The two sets that stand for all at a glance."""

WEAK = 0.95
MOST_WEAK = 15
"""Groups in which primfit is right less often than this are listed, so many at most."""
EXACT = 1e-12
"""Below this relative error nobody is ahead: what is left is rounding."""
CLEARLY = 0.9
"""Ahead is who needs less than this share of the other's error or time."""


def head(data: Data) -> Iterator[str]:
    machines = sorted({str(about["machine"]) for about in data.about.values()})
    clouds = len({record.key[:3] for record in data.records})
    yield "# Benchmark"
    yield ""
    yield "<!-- Written by `primfit bench report`; change benchmark/report/, not this file. -->"
    yield ""
    yield (
        f"primfit and what people use instead, on the same {clouds:,} clouds, in one run: who is right how often, how exact, "
        f"how fast. One process, one thread, warm, the methods taking turns cloud by cloud; {', '.join(machines)}. "
        f"[benchmarking.md](benchmarking.md) says how to run it; [benchmark-details.md](benchmark-details.md) has every table "
        f"by perturbation, size and level."
    )


# -- at a glance --------------------------------------------------------------------------------------------


def at_a_glance(data: Data) -> Iterator[str]:
    shown = {set_: name for set_, name in HEADLINE.items() if set_ in data.sets}
    header = ["method", "kind"]
    for name in shown.values():
        header += [f"{name}: kind right", "within 1 %", "error", "ms"]
    yield "## At a glance"
    yield ""
    yield from table(header, [_glance(data, method, list(shown)) for method in data.methods], left=2)
    yield ""
    yield (
        "*within 1 %*: the kind is right, and the found surface within 1 % of the cloud's extent of the true one (root mean "
        "square, where the cloud is). *error*: that distance, as a share of the extent, median. *ms*: a cloud, median. A "
        "wrong kind, `ambiguous` and `no_fit` count as wrong and as infinitely far. Methods that do not find the kind are "
        "*given* the true one and asked only for kinds that they know: their figures are easier to reach."
    )
    yield ""
    yield "![Share of the clouds that are right against time, on the benchmark and on scans](images/benchmark-overview.png)"
    yield ""
    yield from commands([*data.commands(shown), "primfit bench report"])


def _glance(data: Data, method: str, sets: Sequence[str]) -> list[str]:
    decides = data.decides(method)
    known = len(data.about[method]["kinds"])
    asked = "found" if decides else "given"
    cells = [_name(method), asked if known == len(KINDS) else f"{asked}, {known} of {len(KINDS)}"]
    for set_ in sets:
        records = data.of_set(set_, method)
        cells += [
            percent(share(records, lambda record: record.right)) if decides else NOTHING,
            percent(share(records, is_close)),
            scientific(_median(records, "surface")),
            milliseconds(median_seconds(records)),
        ]
    return cells


def _name(method: str) -> str:
    return f"**{method}**" if method == OURS else method


def _median(records: Sequence[Record], error: str) -> float:
    return spread([record.error(error) for record in records]).q2


# -- where primfit is not ahead -----------------------------------------------------------------------------


def behind(data: Data) -> Iterator[str]:
    yield "## Where primfit is not ahead"
    yield ""
    others = [method for method in data.methods if method.split("-")[0] != OURS]
    if others:
        yield (
            "Against each other method, on the clouds that both were asked about (theirs against ours): the share right "
            "and within 1 %, the median surface error, the median time in ms."
        )
        yield ""
        rows = [[method, *_ahead(data, method)] for method in others]
        yield from table(["method", "more often right", "more exact", "faster"], rows, left=4)
        yield ""
    weak = sorted(_weak_groups(data), key=lambda row: row[0])[:MOST_WEAK]
    yield f"Groups in which primfit is right on less than {percent(WEAK, 0)} of the clouds, the weakest first:"
    yield ""
    header = ["set", "group", "right", "another kind", *REJECTIONS[:2], "clouds"]
    yield from table(header, [row for _, row in weak], left=2)


def _ahead(data: Data, method: str) -> list[str]:
    """Three cells: the sets on which this method is ahead of primfit, with figures."""
    cells: list[list[str]] = [[], [], []]
    for set_ in data.sets:
        ours, theirs = common(data.of_set(set_, OURS), data.of_set(set_, method))
        if not ours:
            continue
        shares = [share(records, is_close) for records in (theirs, ours)]
        errors = [_median(records, "surface") for records in (theirs, ours)]
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
                records = [r for r in data.of_set(set_, OURS) if r.groups.get(group) == level]
                right = share(records, lambda record: record.right)
                if right < WEAK:
                    yield right, [set_, f"{group}: {_level(level)}", *_outcomes(records), f"{len(records)}"]


def _level(level: Level) -> str:
    return f"{level:,}" if isinstance(level, int) else str(level)


def _outcomes(records: Sequence[Record], failed: bool = False) -> list[str]:
    """Right, another kind, ambiguous, no_fit, and on request failed, of the wrong ones."""
    wrong = [answered(record) for record in records if not record.right]
    names = REJECTIONS if failed else REJECTIONS[:2]
    rejected = [wrong.count(name) for name in names]
    other = len([answer for answer in wrong if answer not in REJECTIONS])
    return [percent(share(records, lambda record: record.right)), count(other), *map(count, rejected)]


# -- one set ------------------------------------------------------------------------------------------------


def of_set(data: Data, set_: str) -> Iterator[str]:
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
    yield from PICTURES.get(set_, [])
    if set_ in ("shrec", TRACK):
        yield from beside_the_paper(data, set_)
        yield ""
    yield from commands([*data.commands([set_]), "primfit bench report"])


PICTURES = {
    "shrec": [
        "![Share right and within 1 % by perturbation and method](images/benchmark-perturbations.png)",
        "",
        "![How the errors are spread, on the benchmark and on scans](images/benchmark-errors.png)",
        "",
        "![Confusion matrices](images/benchmark-confusion.png)",
        "",
    ],
    "outliers": [
        "![Share right and within 1 % by outliers, arc, exact share, number of points](images/benchmark-levels.png)",
        "",
    ],
    "sizes": ["![Time by number of points](images/benchmark-time.png)", ""],
}


def outcomes(data: Data, set_: str) -> Iterator[str]:
    """A row for each method: how often right and wrong in which way, how far, how long."""
    header = ["method", "clouds", "kind right", "another kind", *REJECTIONS, "within 1 %"]
    header += ["surface error", "parameter error", "position error", "ms"]
    rows = []
    for method, records in data.by_method(data.of_set(set_)).items():
        right, *wrong = _outcomes(records, failed=True)
        rows.append(
            [
                _name(method),
                f"{len(records):,}",
                right if data.decides(method) else "given",
                *wrong,
                percent(share(records, is_close)),
                *(
                    scientific(_median(_with(records, e), e))
                    for e in ("surface", "relative_l2", "relative_position")
                ),
                milliseconds(median_seconds(records)),
            ]
        )
    yield from table(header, rows)


def _with(records: Sequence[Record], error: str) -> list[Record]:
    """The records of the kinds for which a measure is defined."""
    return [
        r for r in records if r.kind in KINDS and ("position" not in error or r.kind in ("plane", "cylinder"))
    ]


def by_level(data: Data, set_: str, group: str) -> Iterator[str]:
    """A row for each method, a column for each level: the share right and within 1 %."""
    levels = data.levels(set_, group)
    rows = []
    for method, records in data.by_method(data.of_set(set_)).items():
        at = {level: [r for r in records if r.groups.get(group) == level] for level in levels}
        rows.append([_name(method), *(percent(share(at[level], is_close), 0) for level in levels)])
    yield f"Right and within 1 %, by {group}:"
    yield ""
    yield from table(["method", *map(_level, levels)], rows)


# -- beside the paper ---------------------------------------------------------------------------------------


def beside_the_paper(data: Data, set_: str) -> Iterator[str]:
    """Tables 1 and 2 of the paper, with ours in the same form."""
    records = data.of_set(set_)
    yield "### Beside the paper"
    yield ""
    yield (
        "M1 to M6 are the six methods of the paper, with the numbers of its tables 1 and 2, measured by its authors on "
        "their 925 test clouds; the others were measured here, on "
        + ("other clouds of the same laws." if set_ != TRACK else "the clouds of the folder.")
    )
    yield ""
    yield "Classification, macro averages (every class: [benchmark-details.md](benchmark-details.md)):"
    yield ""
    rows = [[_name(method), *_macro_rates(data.of_set(set_, method))] for method in data.deciders()]
    for method in next(iter(paper.CLASSIFICATION.values())):
        rows.append(
            [f"{method} (paper)", *(f"{rate[method][5]:.4f}" for rate in paper.CLASSIFICATION.values())]
        )
    yield from table(["method", *paper.CLASSIFICATION], rows)
    yield ""
    yield (
        "Errors in the unit of the clouds. The quartiles count a wrong answer as infinitely far; mean and standard "
        "deviation are those of the right ones. *truth* is what the true parameters reach on the same clouds. The paper "
        "measures MFE and Hausdorff distance to samples of the surface, which lie some distance apart: compare its numbers "
        f"with the tables *sampled surface*, ours from {GRID} x {GRID} samples, and with the truth's there."
    )
    for error, title in TABLE_2.items():
        yield ""
        yield from table([title, "Q1", "Q2", "Q3", "mean", "std"], _table_2(data, records, error))


TABLE_2 = {
    "l2": "L2",
    "mfe": "MFE, exact distances",
    "mfe_sampled": "MFE, sampled surface",
    "hausdorff": "directed Hausdorff, exact distances",
    "hausdorff_sampled": "directed Hausdorff, sampled surface",
}


def _table_2(data: Data, records: Sequence[Record], error: str) -> Iterator[list[str]]:
    if error != "l2":
        own = {record.key[:3]: record.truth_errors.get(error) for record in records}
        yield ["*truth*", *_five([np.inf if value is None else value for value in own.values()])]
    for method, mine in data.by_method(records).items():
        given = "" if data.decides(method) else " (kind given)"
        yield [_name(method) + given, *_five([record.error(error) for record in mine])]
    for method, numbers in paper.ERRORS.get(
        error.removesuffix("_sampled") if error != "mfe" else "", {}
    ).items():
        if error.endswith("_sampled") or error == "l2":
            yield [f"{method} (paper)", *map(scientific, numbers)]


def _five(values: Sequence[float]) -> list[str]:
    five = spread(values)
    return [scientific(value) for value in (five.q1, five.q2, five.q3, five.mean, five.std)]


def _macro_rates(records: Sequence[Record]) -> list[str]:
    return [f"{macro(values):.4f}" for values in rates(confusion(records)).values()]


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
                _name(method),
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
        "*errors*: exceptions; *crashes*: the process ended; *timeouts*: no answer within the limit, after which the "
        "process is killed. All count as wrong. *threads*: processor time over wall clock."
    )


def _threads(records: Sequence[Record]) -> str:
    wall = sum(record.seconds or 0.0 for record in records if record.cpu_seconds is not None)
    processor = sum(record.cpu_seconds or 0.0 for record in records)
    return f"{processor / wall:.1f}" if wall else NOTHING


MEASURES = f"""## The measures

- **kind right**: the answer is `fitted` and its kind the true one. `ambiguous` and `no_fit` are wrong, but of a shape that is no
  primitive `no_fit` is right.
- **surface error**: the points are carried to the true surface along its normals; the root mean square of their distances to the
  found surface, over the extent. Points that are known to be outliers are left out. It compares any two kinds, counts positions, and
  forgives parameters that the cloud says nothing about.
- **within 1 %**: the kind is right and the surface error at most {CLOSE:g}.
- **extent**: the diagonal of the bounding box of the points that belong to the surface.
- **L2**: the track's distance between the parameter vectors, in the unit of the clouds, minimised over the sign of the axis, a torus's radii
  sorted. It leaves out where planes and cylinders are.
- **parameter error**: L2 with lengths over the extent, so that clouds in different units compare.
- **position error**: what L2 leaves out, over the extent: difference of a plane's offsets at the cloud's centroid; distance of a
  cylinder's axis from the point of the true one that is closest to the centroid. Planes and cylinders only.
- **MFE**, **directed Hausdorff**: mean distance of all points to the found surface over the diagonal of their bounding box; largest such
  distance, in the unit of the clouds. Exact, or to the closest of {GRID} x {GRID} samples of the surface as in the paper.
- **PPV, NPV, TPR, TNR, ACC**: of each class against the rest; a rejection predicts no class. Macro: the mean over the classes.
- Quartiles are values that occur; every error of a wrong answer counts as infinite."""


def measures() -> list[str]:
    return MEASURES.splitlines()


# -- the details --------------------------------------------------------------------------------------------


def details(data: Data) -> Iterator[str]:
    """benchmark-details.md: everything by class, perturbation, size and level."""
    yield "# Benchmark: all tables"
    yield ""
    yield "<!-- Written by `primfit bench report`. -->"
    yield ""
    yield "[benchmark.md](benchmark.md) explains the measures and has the pictures. Errors as there: a wrong answer is infinitely far in"
    yield "the quartiles, mean and standard deviation are those of the right ones."
    for set_ in data.sets:
        yield ""
        yield f"## {described(set_).title} (`{set_}`)"
        yield ""
        yield from commands(data.commands([set_]))
        if set_ != "foreign":
            yield ""
            yield from per_class(data, set_)
            yield ""
            yield from confusions(data, set_)
        for group in data.groups(set_):
            yield ""
            yield from detailed(data, set_, group)


def per_class(data: Data, set_: str) -> Iterator[str]:
    """Table 1 of the paper in full, with ours."""
    yield "Rates by class:"
    yield ""
    rows = []
    measured = {method: rates(confusion(data.of_set(set_, method))) for method in data.deciders()}
    for rate, published in paper.CLASSIFICATION.items():
        for method, found in measured.items():
            ordered = [float(found[rate][KINDS.index(kind)]) for kind in paper.KINDS]
            rows.append([rate, _name(method), *map(_rate, (*ordered, macro(found[rate])))])
        if set_ in ("shrec", TRACK):
            rows += [
                [rate, f"{method} (paper)", *map(_rate, numbers)] for method, numbers in published.items()
            ]
    yield from table(["rate", "method", *paper.KINDS, "macro"], rows, left=2)


def _rate(value: float) -> str:
    return NOTHING if np.isnan(value) else f"{value:.4f}"


def confusions(data: Data, set_: str) -> Iterator[str]:
    yield "Confusion matrices, a row for each true kind:"
    yield ""
    rows = []
    for method in data.deciders():
        for kind, counts in zip(KINDS, confusion(data.of_set(set_, method)), strict=True):
            rows.append([_name(method), kind, *(count(int(number)) for number in counts)])
    yield from table(["method", "truth", *ANSWERS], rows, left=2)


def detailed(data: Data, set_: str, group: str) -> Iterator[str]:
    """A row for each level and method with every measure."""
    yield f"By {group}:"
    yield ""
    header = [group, "method", "clouds", "kind right", "another kind", *REJECTIONS, "within 1 %"]
    header += [f"macro {rate}" for rate in paper.CLASSIFICATION]
    header += [f"L2 {name}" for name in ("Q1", "Q2", "Q3", "mean", "std")]
    header += ["surface Q1", "surface Q2", "surface Q3", "position Q2"]
    header += ["MFE Q2", "of the truth", "Hausdorff Q2", "of the truth", "ms Q1", "ms Q2", "ms Q3"]
    rows = []
    for level in data.levels(set_, group):
        at = [record for record in data.of_set(set_) if record.groups.get(group) == level]
        for method, records in data.by_method(at).items():
            rows.append([_level(level), _name(method), *_detailed(records, data.decides(method))])
    yield from table(header, rows, left=2)


def _detailed(records: Sequence[Record], decides: bool) -> list[str]:
    right, *wrong = _outcomes(records, failed=True)
    surface = spread([record.error("surface") for record in _with(records, "surface")])
    times = spread([record.seconds for record in records if record.seconds is not None])
    cells = [f"{len(records):,}", right if decides else "given", *wrong, percent(share(records, is_close))]
    cells += _macro_rates(records) if decides else [NOTHING] * len(paper.CLASSIFICATION)
    cells += _five([record.error("l2") for record in _with(records, "l2")])
    cells += map(
        scientific,
        (surface.q1, surface.q2, surface.q3, _median(_with(records, "position"), "relative_position")),
    )
    for error in ("mfe", "hausdorff"):
        own = [value for record in records if (value := record.truth_errors.get(error)) is not None]
        cells += map(scientific, (_median(_with(records, error), error), spread(own).q2))
    return [*cells, *map(milliseconds, (times.q1, times.q2, times.q3))]
