"""What the estimator is held to beyond single answers, shown on cases that are drawn from a seed.

`least_squares`, `zones` and `constraints` hold answers against optimizers that share nothing with `fitting`
(`oracles`, `zone_oracles`, `constraint_oracle`); `equivariance` and `determinism` hold answers against each
other.
"""

from . import constraints, determinism, equivariance, least_squares, zones
from .trial import Proof

PROOFS: dict[str, Proof] = {
    "least-squares": Proof(
        "parts of 1 to 500 mm beside the optimum or the nominal surface", 30, 1000, least_squares.draw
    ),
    "zones": Proof(
        "minimum zone, circumscribed and inscribed surfaces beside the optimum", 18, 540, zones.draw
    ),
    "constraints": Proof(
        "each constraint honoured, and the rest beside the optimum",
        2 * len(constraints.CONSTRAINED),
        16 * len(constraints.CONSTRAINED),
        constraints.draw,
    ),
    "equivariance": Proof("answers follow their cloud", 12, 300, equivariance.draw),
    "determinism": Proof(
        f"the same bytes, the same answer; {determinism.CLOUDS} clouds each", 1, 6, determinism.draw
    ),
}
"""By name, in the order of the report."""
