"""Records that are made up."""

from primfit.benchmark.records import Record


def record(kind: str, answer: str, surface: float = 0.0, **fields: object) -> Record:
    """A record of a cloud of this kind whose answer falls into a column of the confusion matrix."""
    status = {"ambiguous": "ambiguous", "no_fit": "no_fit", "failed": "timeout"}.get(answer, "fitted")
    given = {
        "set": "shrec",
        "seed": 1,
        "case": "0",
        "method": "primfit",
        "kind": kind,
        "truth": None,
        "groups": {},
        "points": 100,
        "extent": 1.0,
        "cloud": "",
        "status": status,
        "right": answer == kind or (kind == "foreign" and answer == "no_fit"),
        "answer": {"kind": answer} if status == "fitted" else None,
        "note": "",
        "attempts": (),
        "errors": {"surface": surface},
        "truth_errors": {},
        "versions": {},
    }
    return Record(**given | fields)
