"""The steps of an answer, and the functions whose time counts as theirs.

A function that moved, or got another name, moves here, too: `primfit bench steps` ends with a sentence where
one is gone, or where a step is never entered. Time within a function that another step names is that one's,
so that nothing counts twice; what a name stands before is `primfit.`.
"""

STEPS: dict[str, tuple[str, ...]] = {
    "read": ("app.readers:read",),
    "check": (
        "app.engine.arrays:as_cloud",
        "fitting.cloud.cloud:_cloud_in_box",
        "fitting.cloud.cloud:check_normals",
        "fitting.cloud.weights:factors_of",
    ),
    "order": (
        "fitting.cloud.order:distance_keys",
        "fitting.cloud.order:canonical_order",
        "fitting.cloud.order:canonical_sample",
        "fitting.cloud.order:shuffled",
    ),
    "rounding": ("fitting.noise.rounding:rounding_of",),
    "frame, patches": ("fitting.cloud.cloud:Cloud.prepare",),
    "normals": ("fitting.cloud.normals:local_planes",),
    "rank": ("fitting.recognize:_rank",),
    "starts": ("fitting.search.starts:ranked_starts", "fitting.search.starts:distinct_starts"),
    "anneal": ("fitting.search.anneal:search", "fitting.search.anneal:anneal"),
    "polish": ("fitting.search.polish:polish", "fitting.search.criteria:cheapest_minimum"),
    "evidence": ("fitting.verdict.evidence:Evidence.weigh",),
    "verdict": (
        "fitting.answer.figures:summarize",
        "fitting.answer.figures:summarize_noise",
        "fitting.verdict.judge:claim",
        "fitting.verdict.judge:may_overtake",
        "fitting.verdict.judge:decide",
    ),
    "rivals": ("fitting.search.starts:distance_to",),
    "extents": ("fitting.extents:extents_of",),
    "uncertainty": ("fitting.uncertainty.appraise:uncertainty_of",),
    "assemble": ("fitting.answer.assembly:assemble",),
    "serialise": ("app.engine.answer:answer", "app.engine.answer:to_json"),
}

REST = "between the steps"
"""What no function of the table takes: options, trials, the queue of kinds."""

MODULES = ("primfit.app.engine.answer", "primfit.app.readers")
"""What imports all modules that hold functions of the table; see `asked`."""
