"""The options of a fit on the command line, which several commands take."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Annotated, Any

import typer

from primfit.fitting import names
from primfit.fitting.errors import InvalidOptionError
from primfit.models.names import CLASSIFIER, ClassifierName

from .status import BAD_INPUT, complain

# Options that are lists or objects, and the flags that are repeated for them.
FLAGS = {"kinds": "kind", "constraints": "constraint"}
PLAIN = (
    "classifier",
    "criterion",
    "max_error",
    "tolerance",
    "seed",
    "form_tolerance",
    "columns",
    "missing",
    "unit",
)
OBJECTS = ("initial_guess", "nominal")
"""Options that go on as they are, and those in JSON."""

# Typer takes lists of an enum, not of a Literal.
Kind = StrEnum("Kind", [(kind, kind) for kind in names.KINDS])  # type: ignore[misc]
Part = StrEnum("Part", [(part, part) for part in (*names.ANSWER_PARTS, "none")])  # type: ignore[misc]
Kinds = Annotated[
    list[Kind] | None,
    typer.Option(
        "--kind",
        metavar="KIND",
        help=f"Allow this kind (repeatable): {', '.join(names.KINDS)}; all of them by default.",
    ),
]
Classifier = Annotated[
    ClassifierName | None,
    typer.Option(help="Who ranks the kinds; with 'none' all are tried.", show_default=CLASSIFIER),
]
Criterion = Annotated[
    names.Criterion | None,
    typer.Option(
        metavar="NAME",
        help="What the parameters minimize: 'robust' rejects outliers, 'least_squares' counts every point "
        "alike; 'huber' and 'tukey' are M-estimators; 'minimum_zone', and for spheres and cylinders "
        "'minimum_circumscribed' and 'maximum_inscribed', are those of metrology.",
        show_default=names.CRITERION,
    ),
]
MaxError = Annotated[
    float | None,
    typer.Option(
        help="Largest accepted mean distance of the inliers, as a share of the bounding-box diagonal; "
        "by default it follows from the noise of the cloud."
    ),
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        help="What counts as no deviation, in the unit of the cloud: kinds that agree within it are equal, "
        "and the simplest is answered; a smooth deviation within it never leads to 'no_fit'. By default none."
    ),
]
Constraint = Annotated[
    list[str] | None,
    typer.Option(
        "--constraint",
        metavar="NAME=VALUE",
        help="What is known (repeatable): radius=5, radius=4..6, axis=0,0,1, axis=0,0,1@0.05 (radians), "
        "center=1,2,3; also major_radius, minor_radius, half_angle, normal, apex, point.",
    ),
]
InitialGuess = Annotated[
    str | None,
    typer.Option(metavar="JSON", help="A primitive, as in an answer, that joins the starts of its kind."),
]
Include = Annotated[
    list[Part] | None,
    typer.Option(
        metavar="PART",
        help="Compute this part of the answer (repeatable): extents, uncertainty; by default both, with "
        "'none' neither.",
    ),
]
Labels = Annotated[
    str | None,
    typer.Option(
        metavar="COLUMN",
        help="Fit each segment of a file: the points of one label in this column; 'auto' looks for a column "
        "of a usual name.",
    ),
]
Nominal = Annotated[
    str | None,
    typer.Option(
        metavar="JSON",
        help='What the primitive should be, as {"kind": "cylinder", "radius": {"value": 25, '
        '"tolerance": 0.05}}; the answer says how far it deviates.',
    ),
]
FormTolerance = Annotated[
    float | None,
    typer.Option(help="Largest form error of the inliers allowed, in the unit of the cloud; for a verdict."),
]
Columns = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z",
        help="Which columns of a file are x, y and z, and perhaps nx, ny, nz: names, or numbers from 1. By "
        "default they are found by their names, or are the first three.",
    ),
]
Missing = Annotated[
    names.Missing | None,
    typer.Option(
        help="Points that are NaN or infinite, or exact zeros like several others, are dropped and counted; "
        "'error' refuses the former and keeps the latter.",
        show_default="drop",
    ),
]
Unit = Annotated[
    names.Unit | None,
    typer.Option(
        help="Of the coordinates, for the words of the answer and for exports; nothing is converted. By "
        "default that of the file, if its header or format tells it.",
    ),
]
Seed = Annotated[int | None, typer.Option(help="Seed of every random choice.", show_default=str(names.SEED))]


def checked(given: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a fit, as the engine takes them, out of all that a command was given; it may have few.

    They are checked before the first file is read.
    """
    from ..engine.fit import config_of
    from .constraint_flags import parse_constraints

    options = {name: given[name] for name in PLAIN if given.get(name) is not None}
    if given.get("kind"):
        options["kinds"] = list(map(str, given["kind"]))
    try:
        if given.get("constraint"):
            options["constraints"] = parse_constraints(given["constraint"])
        options |= {name: _json(name, given[name]) for name in OBJECTS if given.get(name) is not None}
        if given.get("include"):
            options["include"] = _parts(list(map(str, given["include"])))
        config_of(**options)
    except InvalidOptionError as error:
        option = error.field.partition(".")[0]
        complain(f"--{FLAGS.get(option, option).replace('_', '-')}", str(error))
        raise typer.Exit(BAD_INPUT) from None
    return options


def _parts(named: list[str]) -> list[str]:
    """The parts named; `none` stands alone and names none."""
    if "none" not in named:
        return named
    if set(named) != {"none"}:
        raise InvalidOptionError("include names none beside a part", "include")
    if len(named) > 1:
        raise InvalidOptionError("include names none twice", "include")
    return []


def _json(name: str, text: str) -> Any:
    """The value of a JSON text; `InvalidOptionError` where it is none."""
    import orjson

    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        raise InvalidOptionError(f"not valid JSON at character {error.pos}", name) from None
