"""A strong ETag of an answer, known before the fit: equal requests have equal tags."""

import re
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

import numpy as np

from ..engine.answer import to_json
from ..readers import Cloud

_TAG = re.compile(r'(?:W/)?("[^"]*")')


def etag(receipt: Mapping[str, Any], cloud: Cloud) -> str:
    """The tag of the answer with this receipt, which with normals and warnings holds all that decides it."""
    digest = sha256(to_json({"receipt": receipt, "warnings": cloud.warnings}))
    if cloud.normals is not None:
        digest.update(np.ascontiguousarray(cloud.normals, "<f8").data)
    return f'"{digest.hexdigest()[:32]}"'


def names(condition: str, tag: str) -> bool:
    """Whether an `If-None-Match` names this tag, compared weakly (RFC 9110, 13.1.2); `*` names any."""
    return condition.strip() == "*" or tag in _TAG.findall(condition)
