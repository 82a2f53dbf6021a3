"""The settings as text: those in force, and the page docs/settings.md."""

from typing import Any

import orjson

from .settings import CONFIG, PREFIX, SECRET, Settings

_HEAD = f"""# Settings

Printed by `primfit settings --markdown` from the code that defines them (`app/service/settings.py`).

A setting is given by a flag of `primfit serve` (`--host`, `--port`, `--workers`), else by its environment
variable, else in the TOML file that `{CONFIG}` names, under its name and at the top level:

```toml
workers = 2
rate_limit = "120/minute"
api_keys_file = "/etc/primfit.keys"
```

Items of a list stand in an environment variable with commas between them; an empty variable counts as none.
`primfit settings` checks what is set and prints what is in force, as such a file, without the keys: `primfit
settings > primfit.toml` keeps it. A name in the file that is not below, and a value that is not allowed, are
named, and nothing starts (exit status 2).
[operations.md](operations.md) says what the settings are for. [Traces](operations.md#traces) have none: the
variables of OpenTelemetry (`OTEL_EXPORTER_OTLP_ENDPOINT`, ...) configure them.

| setting | environment | default | allowed | meaning |
|---|---|---|---|---|
"""


def in_force(settings: Settings) -> str:
    """The settings as a TOML file that sets the same, but for the keys: these are left out.

    What has no value stands in a comment.
    """
    return "".join(f"{_line(name, value)}\n" for name, value in settings.model_dump(mode="json").items())


def _line(name: str, value: Any) -> str:
    if value is None:
        return f"# {name} is not set"
    if name == "api_keys" and value:
        return (
            f"# {name}: {len(value)} in force, not shown; without them everybody may ask. "
            "Keep them in api_keys_file"
        )
    if name in SECRET and value:
        return f"# {name} is set, and not shown"
    # A string or a list in JSON is one in TOML, which wants this one character escaped, too.
    return f"{name} = {orjson.dumps(value).decode()}".replace("\x7f", "\\u007f")


def page() -> str:
    """What there is to set, in Markdown."""
    properties = Settings.model_json_schema()["properties"]
    return _HEAD + "".join(_row(name, schema) for name, schema in properties.items())


def _row(name: str, schema: dict[str, Any]) -> str:
    default = schema.get("x-default", schema.get("default"))
    shown = "none" if default in (None, []) else default
    return (
        f"| `{name}` | `{PREFIX}{name.upper()}` | {shown} | {_allowed(schema)} | {schema['description']} |\n"
    )


def _allowed(schema: dict[str, Any]) -> str:
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    low, high = schema.get("minimum"), schema.get("maximum")
    ends = [f"above {schema['exclusiveMinimum']:g}"] if "exclusiveMinimum" in schema else []
    ends += [f"from {low:g}"] if low is not None else []
    ends += [f"to {high:g}"] if high is not None else []
    return " ".join(ends)
