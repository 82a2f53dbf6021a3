"""What a service reads, tries and allows: drawn from the code and the settings that decide it."""

import re
from dataclasses import asdict
from functools import cache
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from typing import Any

from primfit.fitting.names import CRITERIA, KINDS
from primfit.models.names import CLASSIFIERS

from ..exports import FORMATS as ARTIFACTS
from ..readers import CODINGS, FORMATS
from ..wire.schemas import Capabilities, FitOptions, InputFormat, OptionRange, ServiceLimits, Versions
from .settings import Settings

_EXTRA = re.compile(r"""(?P<package>[\w.-]+).*extra *== *["'](?P<extra>[\w-]+)["']""")
_FOR_DEVELOPERS = ("dev", "fuzz")


def capabilities(settings: Settings, versions: Versions) -> Capabilities:
    """What this service can do."""
    return Capabilities(
        kinds=list(KINDS),
        classifiers=list(CLASSIFIERS),  # type: ignore[arg-type]
        criteria=list(CRITERIA),
        formats=[InputFormat.model_validate(asdict(format)) for format in FORMATS],
        artifacts=list(ARTIFACTS),
        content_encodings=list(CODINGS),
        options=_options(),
        limits=ServiceLimits(**{name: getattr(settings, name) for name in ServiceLimits.model_fields}),
        jobs=settings.jobs_path is not None,
        extras=_extras(),
        versions=versions,
    )


def _options() -> list[OptionRange]:
    """The options of a fit, off the schema that checks them."""
    schema = FitOptions.model_json_schema()
    ranges = []
    for name, described in schema["properties"].items():
        value = _resolved(described, schema["$defs"])
        item = _resolved(value.get("items", {}), schema["$defs"])
        ranges.append(
            OptionRange(
                name=name,
                description=described["description"],
                type=value.get("type", "object"),
                default=described.get("default"),
                values=value.get("enum", item.get("enum")),
                minimum=value.get("minimum"),
                exclusive_minimum=value.get("exclusiveMinimum"),
                maximum=value.get("maximum"),
            )
        )
    return ranges


def _resolved(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema that a value has to match where there is one, behind references and beside null."""
    chosen = next((one for one in schema.get("anyOf", []) if one != {"type": "null"}), schema)
    name = chosen.get("$ref", "").rpartition("/")[2]
    resolved: dict[str, Any] = definitions[name] if name else chosen
    return resolved


@cache
def _extras() -> dict[str, bool]:
    """Optional parts by their names in pyproject.toml; one is installed when all that it needs is."""
    names = metadata("primfit").get_all("Provides-Extra") or []
    installed = {name: True for name in names if name not in _FOR_DEVELOPERS}
    for requirement in requires("primfit") or []:
        found = _EXTRA.match(requirement)
        if found and found["extra"] in installed and not _is_installed(found["package"]):
            installed[found["extra"]] = False
    return installed


def _is_installed(package: str) -> bool:
    try:
        version(package)
    except PackageNotFoundError:
        return False
    return True
