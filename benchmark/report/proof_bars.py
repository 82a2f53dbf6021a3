"""What the estimator is held to from fresh seeds: the bars of `primfit bench proofs`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..proofs.constraints import CRITERIA
from ..proofs.equivariance import MOST_ULP, TRANSFORMATIONS
from ..proofs.least_squares import ANGLE, LENGTH, RELATIVE
from ..proofs.records import ProofRecord
from ..proofs.trial import Level
from ..proofs.zones import PAIRS

Groups = dict[str, Callable[[Level], bool]]

ZONE, HONOURED, OVER_CLEAN = 1e-6, 1e-12, 1.05


@dataclass(frozen=True)
class ProofBar:
    """One line: which records of a set, and what their figures may be at most.

    Attributes
    ----------
    limits : by figure; a record counts if it has one of them, or none at all because it failed
    groups : what must hold of the levels of groups
    """

    set: str
    case: str
    bar: str
    limits: dict[str, float]
    groups: Groups

    def concerns(self, record: ProofRecord) -> bool:
        if record.set != self.set:
            return False
        within = all(
            name in record.groups and holds(record.groups[name]) for name, holds in self.groups.items()
        )
        return within and (bool(record.note) or any(name in record.figures for name in self.limits))

    def misses(self, record: ProofRecord) -> bool:
        return bool(record.note) or any(
            record.figures[name] is None or record.figures[name] > limit  # type: ignore[operator]
            for name, limit in self.limits.items()
            if name in record.figures
        )


def _is(*levels: Level) -> Callable[[Level], bool]:
    return lambda level: level in levels


def _zone_bar(kinds: Sequence[str], criterion: str) -> ProofBar:
    limits = {"excess": ZONE} | ({} if criterion == "minimum_zone" else {"beyond": HONOURED})
    bar = "equal to another optimizer to 1e-6"
    bar += "" if criterion == "minimum_zone" else ", no point beyond by 1e-12 of the coordinates"
    groups: Groups = {"kind": _is(*kinds), "criterion": _is(criterion)}
    return ProofBar("zones", f"`{criterion}`, {', '.join(kinds)}", bar, limits, groups)


SHALLOW, STEEP = (0.6, 2.0, 5.0), (75.0, 85.0)
NOISY: Groups = {"noise": _is("noisy"), "points": _is("more")}
EXACT: Groups = {"noise": _is("exact"), "points": _is("more")}
KNOWN = "angles to 1e-7 rad, positions and sizes to 1e-4 mm"

PROOF_BARS: tuple[ProofBar, ...] = (
    ProofBar(
        "least-squares",
        "`least_squares`, all kinds",
        "sum of squares equal to a brute-force optimum to 1e-8",
        {"excess": RELATIVE},
        {"points": _is("more")},
    ),
    ProofBar(
        "least-squares",
        "the same, noisy",
        f"{KNOWN} of the optimum",
        {"angle": ANGLE, "length": LENGTH},
        NOISY,
    ),
    ProofBar(
        "least-squares",
        "the same, exact",
        f"{KNOWN} of the nominal surface",
        {"angle": ANGLE, "length": LENGTH},
        EXACT,
    ),
    ProofBar(
        "least-squares",
        "the same, all",
        "missed by at most 1e-8 of radian or size and what the rounding of coordinates hides (1)",
        {"missed": 1.0},
        {},
    ),
    ProofBar(
        "least-squares",
        "minimal sets (3 to 7 points)",
        "optimum to 1e-8; surface through exact points to 1e-9 mm",
        {"excess": RELATIVE, "off": 1e-9},
        {"points": _is("minimal")},
    ),
    ProofBar(
        "least-squares",
        "partial features (30 to 90 degrees)",
        "the same bars",
        {"excess": RELATIVE, "missed": 1.0, "angle": ANGLE, "length": LENGTH, "off": 1e-9},
        {"arc": lambda arc: float(arc) <= 90.5, "kind": _is("sphere", "cylinder", "cone", "torus")},
    ),
    *(
        ProofBar(
            "least-squares",
            f"cones of {', '.join(f'{angle:g}' for angle in angles)} degrees",
            "the same bars",
            {"excess": RELATIVE, "missed": 1.0, "angle": ANGLE, "length": LENGTH, "off": 1e-9},
            {"half_angle": _is(*angles)},
        )
        for angles in (SHALLOW, STEEP)
    ),
    _zone_bar([kind for kind, criterion in PAIRS if criterion == "minimum_zone"], "minimum_zone"),
    _zone_bar(("sphere", "cylinder"), "minimum_circumscribed"),
    _zone_bar(("sphere", "cylinder"), "maximum_inscribed"),
    ProofBar(
        "constraints", "constraints, each and together", "honoured to 1e-12", {"violation": HONOURED}, {}
    ),
    ProofBar(
        "constraints",
        "constraints, `least_squares`",
        "the rest optimal to 1e-8",
        {"excess": RELATIVE},
        {"criterion": _is(CRITERIA[0])},
    ),
    ProofBar(
        "constraints",
        "constraints, `robust`, a tenth of the points stray",
        "at most 1.05 times the optimum of the others (rms)",
        {"over clean": OVER_CLEAN},
        {"criterion": _is(CRITERIA[1])},
    ),
    *(
        ProofBar(
            "equivariance",
            name if name.startswith("every") else f"cloud {name}",
            f"the same kind, parameters within {MOST_ULP:g} ulp times conditioning",
            {name: MOST_ULP},
            {},
        )
        for name in TRANSFORMATIONS
    ),
    ProofBar("determinism", "`primfit batch`, 1 and 8 workers", "no byte differs", {"batch": 0.0}, {}),
    ProofBar("determinism", "`primfit serve`, 1 and 8 workers", "no byte differs", {"service": 0.0}, {}),
    ProofBar("determinism", "service and batch", "no byte differs", {"service beside batch": 0.0}, {}),
)
"""In the order of the table."""
