"""What the estimator is held to: each bar beside the figure that was measured."""

from collections.abc import Callable, Iterator

import numpy as np

from primfit.synthetic.recipes import KINDS

from ..cases import OBJECTS, ROUND
from ..pieces import CLEAR, INDISTINGUISHABLE, NOISE_LAWS
from ..records import Record
from ..scores import EXACT, is_exact, is_first, named, over_least_squares, spread, standard_errors
from ..track import TRACK
from .bar import STANDARD_ERRORS, Bar, Figure, Records, at_least, at_most, has_status, is_right
from .data import FOLDERS, OURS, Data
from .markdown import NOTHING, scientific, table
from .scan_bars import SCAN_BARS, SHAPE_BARS


def below(error: str, most: float) -> Callable[[Record], bool]:
    return lambda record: record.error(error) < most


def is_other_alone(record: Record) -> bool:
    """Whether a pair is answered as its more general kind, and nothing else is named."""
    other = str(record.groups["pair"]).split(" or ")[1]
    return record.status == "fitted" and named(record) == (other,)


def times_least_squares(most: float) -> Callable[[Records], Figure]:
    """Of the right answers."""

    def measure(records: Records) -> Figure:
        ratio, clouds = over_least_squares(records)
        known = np.isfinite(ratio)
        return Figure(f"{ratio:.3f}" if known else NOTHING, bool(ratio <= most) if known else None, clouds)

    return measure


def quartile_and_mean(error: str, third_quartile: float, mean: float) -> Callable[[Records], Figure]:
    """Of the clouds whose kind has this error; a wrong answer is infinitely far."""

    def measure(records: Records) -> Figure:
        kinds = ("plane", "cylinder") if error == "position" else KINDS
        found = spread([record.error(error) for record in records if record.kind in kinds])
        count = sum(record.kind in kinds for record in records)
        met = found.q3 <= third_quartile and found.mean <= mean
        return Figure(f"Q3 {scientific(found.q3)}, mean {scientific(found.mean)}", met, count)

    return measure


def mean_fitting_error(records: Records) -> Figure:
    """Means over the clouds; where both are rounding alone they are alike."""
    found = float(np.mean([record.error("mfe") for record in records]))
    own = float(np.mean([record.truth_errors.get("mfe") or 0.0 for record in records]))
    met = abs(found - own) <= max(0.01 * own, EXACT)
    return Figure(f"{found:.4g}, truth {own:.4g}" if np.isfinite(found) else "wrong", met, len(records))


def radius_bias(records: Records) -> Figure:
    """Of right answers: how many standard errors the mean error of the radius is from 0."""
    found = {name: standard_errors(errors[:, 0].tolist()) for name, errors in _radius_errors(records)}
    text = "; ".join(f"{name} {value:+.1f}" for name, value in found.items())
    met = all(abs(value) < STANDARD_ERRORS for value in found.values())
    return _of_right(text, met, records)


def radius_beside_reference(records: Records) -> Figure:
    """Of right answers: rms error of the radius over that of the reference, and whether it is larger."""
    cells, met = [], True
    for name, errors in _radius_errors(records):
        squares = errors**2
        found, reference = squares.mean(axis=0)
        cells.append(f"{name} {np.sqrt(found / reference):.3f}")
        met &= not standard_errors((squares[:, 0] - squares[:, 1]).tolist()) > STANDARD_ERRORS
    return _of_right("; ".join(cells), met, records)


def _of_right(text: str, met: bool, records: Records) -> Figure:
    return Figure(text or NOTHING, met if text else None, sum(record.right for record in records))


def _radius_errors(records: Records) -> Iterator[tuple[str, np.ndarray]]:
    """By kind and object, relative errors (N, 2) of the radii of the answers and of the reference."""
    for kind in ROUND:
        for shape in OBJECTS:
            errors = [
                (record.errors["radius"], record.reference_errors["radius"])
                for record in records
                if record.right and record.kind == kind and record.groups["object"] == shape
            ]
            if len(errors) > 1:
                yield f"{kind} {shape}", np.array(errors, float)


A9 = ("perturbation", "A9")

BARS: tuple[Bar, ...] = (
    *SCAN_BARS,
    Bar("real clouds", "all right", (TRACK,), at_least(1.0, is_right)),
    Bar(
        "real clouds",
        "L2: third quartile at most 1e-10, mean at most 1e-9",
        (TRACK,),
        quartile_and_mean("l2", 1e-10, 1e-9),
    ),
    Bar(
        "real clouds",
        "position error: the same",
        (TRACK,),
        quartile_and_mean("position", 1e-10, 1e-9),
    ),
    Bar("real clouds", "MFE within 1% of the truth's own", (TRACK,), mean_fitting_error),
    Bar("benchmark clouds", "at least 99.5% right", ("shrec",), at_least(0.995, is_right)),
    Bar(
        "benchmark clouds but A9",
        "L2 below 1e-6 on at least 99%",
        ("shrec",),
        at_least(0.99, below("l2", 1e-6)),
        ((*A9, False),),
    ),
    Bar(
        "benchmark clouds, A9 (bumps)",
        "L2 below 1e-4 on at least 99%",
        ("shrec",),
        at_least(0.99, below("l2", 1e-4)),
        ((*A9, True),),
    ),
    Bar(
        "10% of the points exact",
        "exact on at least 85%",
        ("exact-share",),
        at_least(0.85, is_exact),
        (("exact [%]", 10, True),),
    ),
    Bar("scans, noise 0.3%", "at least 98% right", ("scans-0.3",), at_least(0.98, is_right)),
    Bar(
        "scans, noise 0.3%",
        "at most 1.1 times the error of least squares",
        ("scans-0.3",),
        times_least_squares(1.1),
    ),
    Bar("scans, noise 2%", "at least 95% right", ("scans-2",), at_least(0.95, is_right)),
    Bar(
        "scans, noise 2%",
        "at most 1.1 times the error of least squares",
        ("scans-2",),
        times_least_squares(1.1),
    ),
    Bar(
        "40% gross outliers",
        "at least 95% right",
        ("outliers",),
        at_least(0.95, is_right),
        (("outliers [%]", 40, True),),
    ),
    Bar(
        "40% gross outliers",
        "at most 1.3 times the error of least squares",
        ("outliers",),
        times_least_squares(1.3),
        (("outliers [%]", 40, True),),
    ),
    Bar(
        "indistinguishable pairs",
        "the simpler kind, alone or first of several, on at least 90%",
        ("ambiguity",),
        at_least(0.9, is_first),
        (("the pair is", INDISTINGUISHABLE, True),),
    ),
    Bar(
        "indistinguishable pairs",
        "the other kind alone on at most 5%",
        ("ambiguity",),
        at_most(0.05, is_other_alone),
        (("the pair is", INDISTINGUISHABLE, True),),
    ),
    Bar(
        "clearly distinguishable pairs",
        "at least 98% right",
        ("ambiguity",),
        at_least(0.98, is_right),
        (("the pair is", CLEAR, True),),
    ),
    Bar(
        "clearly distinguishable pairs",
        "`ambiguous` on at most 2%",
        ("ambiguity",),
        at_most(0.02, has_status("ambiguous")),
        (("the pair is", CLEAR, True),),
    ),
    Bar(
        "benchmark clouds and scans",
        "`no_fit` on at most 1%",
        ("shrec", "scanner"),
        at_most(0.01, has_status("no_fit")),
    ),
    Bar(
        "noise along the normal",
        "mean error of the radius under 3 standard errors",
        ("bias",),
        radius_bias,
        (("noise", NOISE_LAWS[0], True),),
    ),
    Bar(
        "isotropic noise",
        "rms error of the radius not above that of least squares, by 3 standard errors",
        ("bias",),
        radius_beside_reference,
        (("noise", NOISE_LAWS[1], True),),
    ),
    *SHAPE_BARS,
)
"""In the order of the table."""


def held_to(data: Data) -> Iterator[str]:
    """The table of all bars, but those of folders that there are no records of."""
    left_out = set(FOLDERS) - set(data.sets)
    bars = [bar for bar in BARS if not left_out.issuperset(bar.sets)]
    figures = [_figure(bar, data.of_method(OURS)) for bar in bars]
    yield "## What the estimator is held to"
    yield ""
    yield from table(
        ["case", "bar", "measured", "clouds", "met?"],
        [[bar.case, bar.bar, *_cells(figure)] for bar, figure in zip(bars, figures, strict=True)],
        left=3,
    )
    yield ""
    missed = [f"{bar.case} ({bar.bar})" for bar, f in zip(bars, figures, strict=True) if f and f.met is False]
    measured = sum(figure is not None and figure.met is not None for figure in figures)
    yield f"{OURS} misses {len(missed)} of {measured}" + (f": {'; '.join(missed)}." if missed else ".")
    yield ""
    yield (
        f"*exact*: a surface error of at most {EXACT:g} of the extent. *error of least squares*: "
        "covariance-normalized, root mean square over the clouds answered right (those counted), against "
        "least squares on the points of the surface alone, started at the truth. *rms error of the radius*: "
        "over that of the same least squares."
    )


def _figure(bar: Bar, records: Records) -> Figure | None:
    """None where no such cloud was run."""
    concerned = [record for record in records if bar.concerns(record)]
    return bar.measure(concerned) if concerned else None


def _cells(figure: Figure | None) -> list[str]:
    if figure is None:
        return ["not run", "", NOTHING]
    met = {True: "yes", False: "**no**", None: NOTHING}[figure.met]
    return [figure.text, f"{figure.clouds:,}", met]
