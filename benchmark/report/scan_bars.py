"""Bars of real segments and of sensors' clouds, and of shapes that come close to a kind."""

from primfit.synthetic.recipes import KINDS

from ..cases import AMPLITUDES, BOW_BUCKETS, DEVIATIONS_SEEN, FAR_OFF, PIPE
from ..real import REAL
from ..records import Record
from ..scores import among, is_first, named, share
from .bar import Bar, Figure, Measure, Records, at_least, at_most, has_status, is_right
from .markdown import NOTHING, percent
from .scans import SENSOR

SEGMENTS = 36
"""Of the folder that the bars of real segments were set for; of another they are the same shares."""

MORE_GENERAL: dict[str, tuple[str, ...]] = {
    "plane": ("sphere", "cylinder", "cone", "torus"),
    "sphere": ("torus",),
    "cylinder": ("cone", "torus"),
    "cone": (),
    "torus": (),
}
"""The kinds that a kind is a limit of, so that they can follow its deviation."""

ACCIDENT = 2.0
"""Standard errors of a difference of two shares that are exceeded by accident in one of forty runs."""

NAMED = "deviat"
"""In the message of an answer that names a deviation ("deviates smoothly by", "deviation")."""


def names_other(record: Record) -> bool:
    """Whether kinds are named and the true one is not among them."""
    return bool(named(record)) and record.kind not in named(record)


def is_told(record: Record) -> bool:
    """Whether a part that clearly deviates is told for its kind or a more general one, or `ambiguous`."""
    general = record.status == "fitted" and named(record)[0] in MORE_GENERAL[record.kind]
    return record.right or record.status == "ambiguous" or general


def is_cautious(record: Record) -> bool:
    """Whether a shape that is no primitive is `no_fit` or `ambiguous`, or its deviation is named."""
    return record.status in ("no_fit", "ambiguous") or (record.status == "fitted" and NAMED in record.note)


def is_cylinder_alone(record: Record) -> bool:
    return record.status == "fitted" and named(record) == ("cylinder",)


def each_kind(least: float) -> Measure:
    """The kind that is right least often."""

    def measure(records: Records) -> Figure:
        shares = {kind: share([r for r in records if r.kind == kind], is_right) for kind in KINDS}
        known = {kind: found for kind, found in shares.items() if found == found}
        if not known:
            return Figure(NOTHING, None, 0)
        worst = min(known, key=lambda kind: known[kind])
        return Figure(f"{worst} {percent(known[worst])}", known[worst] >= least, len(records))

    return measure


def no_worse_with_more_points(records: Records) -> Figure:
    """Right on the clouds with the most points as often as on those with the fewest, but for accidents."""
    levels = [name for _, name in BOW_BUCKETS["points"]]
    of = [[record for record in records if record.groups.get("points") == level] for level in levels]
    shares = [share(mine, is_right) for mine in of]
    text = ", ".join(percent(found) for found in shares)
    if not of[0] or not of[-1]:
        return Figure(text, None, len(records))
    variances = [p * (1.0 - p) / len(mine) for p, mine in ((shares[0], of[0]), (shares[-1], of[-1]))]
    met = shares[-1] >= shares[0] - ACCIDENT * sum(variances) ** 0.5
    return Figure(text, met, len(records))


SCAN_BARS: tuple[Bar, ...] = (
    Bar("real segments", "at least 31 of 36 right", (REAL,), at_least(31 / SEGMENTS, is_right)),
    Bar(
        "real segments",
        "at least 34 of 36 right, or `ambiguous` with the true kind among those named",
        (REAL,),
        at_least(34 / SEGMENTS, among),
    ),
    Bar(
        "real segments",
        "other kinds named and the true one not on at most 2 of 36",
        (REAL,),
        at_most(2 / SEGMENTS, names_other),
    ),
    Bar("real segments", "`ambiguous` on at most 10%", (REAL,), at_most(0.1, has_status("ambiguous"))),
    Bar("clouds of sensors", "at least 93% right", (SENSOR,), at_least(0.93, is_right)),
    Bar(
        "clouds of sensors",
        "at least 97% right, or `ambiguous` with the true kind among those named",
        (SENSOR,),
        at_least(0.97, among),
    ),
    Bar("clouds of sensors", "at least 88% right of each kind", (SENSOR,), each_kind(0.88)),
)
"""What is asked of scans, real and as sensors make them."""

LARGEST = AMPLITUDES[-1]

SHAPE_BARS: tuple[Bar, ...] = (
    Bar(
        "bows, lobes, barrels of up to 1 noise scale",
        "at least 95% right",
        ("bows",),
        at_least(0.95, is_right),
        (("amplitude [noise]", LARGEST, False),),
    ),
    Bar(
        "bows, lobes, barrels of up to 1 noise scale",
        "right no less often with more points",
        ("bows",),
        no_worse_with_more_points,
        (("amplitude [noise]", LARGEST, False),),
    ),
    Bar(
        "bows, lobes, barrels of 3 noise scales",
        "right, a more general kind or `ambiguous` on at least 95%",
        ("bows",),
        at_least(0.95, is_told),
        (("amplitude [noise]", LARGEST, True),),
    ),
    Bar(
        "short arcs of cones",
        "`cylinder` alone on at most 5%",
        ("cone-arcs",),
        at_most(0.05, is_cylinder_alone),
        (("shape", "cone", True),),
    ),
    Bar(
        "short arcs of cones",
        "`cone`, alone or first of several, on at least 80%",
        ("cone-arcs",),
        at_least(0.8, is_first),
        (("shape", "cone", True),),
    ),
    Bar(
        "cylinders on the same arcs",
        "at least 90% right",
        ("cone-arcs",),
        at_least(0.9, is_right),
        (("shape", "cylinder", True),),
    ),
    Bar(
        "bars off a circle by 3 noise scales",
        "`no_fit` on at least 97%",
        ("sections",),
        at_least(0.97, has_status("no_fit")),
        (("deviation", FAR_OFF, True),),
    ),
    Bar(
        "bars off a circle by 1 to 3 noise scales",
        "`no_fit`, `ambiguous` or the deviation named on at least 95%",
        ("sections",),
        at_least(0.95, is_cautious),
        (("deviation", DEVIATIONS_SEEN[1][1], True),),
    ),
    Bar(
        "pipes beside them",
        "at least 99% right",
        ("sections",),
        at_least(0.99, is_right),
        (("deviation", PIPE, True),),
    ),
    Bar(
        "foreign shapes off every kind by 3 noise scales",
        "`no_fit` on at least 95%",
        ("foreign",),
        at_least(0.95, has_status("no_fit")),
        (("deviation", FAR_OFF, True),),
    ),
    Bar(
        "foreign shapes off every kind by 1 to 3 noise scales",
        "`no_fit`, `ambiguous` or the deviation named on at least 95%",
        ("foreign",),
        at_least(0.95, is_cautious),
        (("deviation", DEVIATIONS_SEEN[1][1], True),),
    ),
)
"""What is asked of shapes that are nearly a kind, and of kinds that are nearly something else."""
