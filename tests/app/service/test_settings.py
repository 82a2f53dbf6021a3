"""Settings: which place wins, what is said about a bad one, and the page that lists them."""

import importlib.util
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from primfit.app.cli.commands import app
from primfit.app.service.settings import Settings, SettingsError, load
from primfit.app.service.settings_page import in_force, page
from tests.paths import DOCS

PAGE = DOCS / "settings.md"
KEY = "s3cret-s3cret-s3cret"


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file that PRIMFIT_CONFIG names; nothing else is set."""
    for name in Settings.model_fields:
        monkeypatch.delenv(f"PRIMFIT_{name.upper()}", raising=False)
    path = tmp_path / "primfit.toml"
    monkeypatch.setenv("PRIMFIT_CONFIG", str(path))
    return path


def test_flags_win_over_the_environment_which_wins_over_the_file(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file.write_text('port = 1001\nqueue_size = 11\nworkers = 3\ntrusted_proxies = ["10.0.0.0/8"]\n')
    monkeypatch.setenv("PRIMFIT_PORT", "1002")
    monkeypatch.setenv("PRIMFIT_QUEUE_SIZE", "12")
    monkeypatch.setenv("PRIMFIT_STOP_PATIENCE", "")
    settings = load(port=1003)
    assert (settings.port, settings.queue_size, settings.workers) == (1003, 12, 3)
    assert settings.trusted_proxies == ("10.0.0.0/8",)
    assert settings.stop_patience == 10


def test_a_list_stands_in_the_environment_with_commas(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file.write_text("")
    monkeypatch.setenv("PRIMFIT_TRUSTED_PROXIES", "127.0.0.1, ::1,")
    assert load().trusted_proxies == ("127.0.0.1", "::1")


BAD_FILES = {
    "unknown": ("worker = 3", "worker: unknown setting; known are host, port, workers"),
    "a table": ("[limits]\nworkers = 3", "limits: unknown setting"),
    "too small": ("workers = 0", "workers: input should be greater than or equal to 1; it is '0'"),
    "a word": ('port = "http"', "port: input should be a valid integer"),
    "not one of": ('log_format = "xml"', "log_format: input should be 'text' or 'json'; it is 'xml'"),
    "no rate": ('rate_limit = "often"', "rate_limit: a number of requests in a time is needed"),
    "a rate of none": ('rate_limit = "0/minute"', 'such as "120/minute" or "5/2seconds"; it is \'0/minute\''),
    "two rates": ('rate_limit = "9/minute;1/second"', "rate_limit: a number of requests in a time is needed"),
    "no proxy": ('trusted_proxies = ["proxy.local"]', "trusted_proxies: an IP address, a network"),
    "no directory": (
        'temporary_directory = "/nowhere"',
        "temporary_directory: path does not point to a directory",
    ),
    "no host": ('allowed_hosts = ["a.example.com:80"]', "allowed_hosts: a name such as primfit.example.com"),
    "not TOML": ("workers 3", "Expected '='"),
    "not a number": ("fit_time_limit = nan", "fit_time_limit: input should be"),
}


@pytest.mark.parametrize(("text", "said"), BAD_FILES.values(), ids=BAD_FILES)
@pytest.mark.parametrize("command", ["serve", "settings"])
def test_what_is_wrong_in_the_file_is_said_in_a_line(file: Path, command: str, text: str, said: str) -> None:
    file.write_text(text)
    result = CliRunner().invoke(app, [command])
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"primfit: {command}: ")
    assert str(file) in line and said in line


def test_every_mistake_is_named_with_its_place(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file.write_text("queue_size = -1\n")
    monkeypatch.setenv("PRIMFIT_MAX_POINTS", "many")
    with pytest.raises(SettingsError) as raised:
        load(workers=0)
    places = [complaint.partition(": input")[0] for complaint in raised.value.complaints]
    assert sorted(places) == sorted(["--workers", "PRIMFIT_MAX_POINTS", f"{file}: queue_size"])


def test_a_missing_file_is_said(file: Path) -> None:
    result = CliRunner().invoke(app, ["settings"])
    assert result.exit_code == 2
    assert result.stderr == f"primfit: settings: PRIMFIT_CONFIG: {file}: no such file\n"


def test_keys_are_never_shown(file: Path) -> None:
    file.write_text(f'api_keys = ["alice:{KEY}"]')
    settings = load()
    assert settings.keys().owner(KEY) == "alice"
    shown = (repr(settings), str(settings), in_force(settings), repr(settings.keys()))
    assert not any("s3cret" in text for text in shown)


FULL = """\
host = "0.0.0.0"
port = 1001
workers = 3
fit_time_limit = 2.5
temporary_directory = "{folder}"
api_keys_file = "{folder}/keys"
rate_limit = "120/minute"
trusted_proxies = ["10.0.0.0/8", "*"]
cors_origins = ["https://viewer.example.com"]
log_format = "json"
stop_delay = 1.5
"""


@pytest.mark.parametrize("text", ["", FULL])
def test_what_is_printed_sets_the_same(file: Path, tmp_path: Path, text: str) -> None:
    (tmp_path / "keys").write_text(f"alice:{KEY}\n")
    file.write_text(text.format(folder=tmp_path))
    settings = load()
    file.write_text(CliRunner().invoke(app, ["settings"]).stdout)
    assert load() == settings
    assert set(Settings.model_fields) == set(re.findall(r"^(?:# )?(\w+) ", file.read_text(), re.MULTILINE))


def test_keys_are_left_out_of_what_is_printed(file: Path) -> None:
    file.write_text(f'port = 1001\napi_keys = ["alice:{KEY}"]')
    shown = in_force(load())
    assert "# api_keys: 1 in force, not shown" in shown
    file.write_text(shown)
    assert (load().port, load().api_keys) == (1001, ())


@pytest.mark.parametrize("origin", ["a.example", "https://a.example/", "ftp://a.example", "https://", "null"])
def test_an_origin_is_what_browsers_send(file: Path, origin: str) -> None:
    file.write_text(f'cors_origins = ["{origin}"]')
    with pytest.raises(SettingsError, match=r"cors_origins: an origin such as"):
        load()


BAD_KEYS = {
    "short": (f'api_keys = ["{KEY}", "s3cret"]', "api_keys[1]: KEY or NAME:KEY is needed"),
    "a number": ("api_keys = [1234567890123456]", "api_keys: input should be a valid string"),
    "one number": ("api_keys = 1234567890123456", "api_keys: input should be a valid tuple"),
    "odd name": (f'api_keys = ["a b:{KEY}"]', "api_keys[0]: KEY or NAME:KEY is needed"),
    "a name twice": (
        f'api_keys = ["a:{KEY}", "a:{KEY}x"]',
        "api_keys[1]: the name or the key is there already",
    ),
    "a key twice": (
        f'api_keys = ["a:{KEY}", "b:{KEY}"]',
        "api_keys[1]: the name or the key is there already",
    ),
    "no file": ('api_keys_file = "/nowhere/keys"', "/nowhere/keys: No such file or directory"),
}


@pytest.mark.parametrize(("text", "said"), BAD_KEYS.values(), ids=BAD_KEYS)
def test_a_bad_key_is_named_by_its_place_and_not_shown(file: Path, text: str, said: str) -> None:
    file.write_text(text)
    with pytest.raises(SettingsError) as raised:
        load()
    assert said in str(raised.value)
    assert "s3cret" not in str(raised.value) and "1234567890123456" not in str(raised.value)


def test_keys_may_stand_in_a_file(file: Path, tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    keys.write_text(f"# who may ask\n\nalice:{KEY}\n{KEY}x\n")
    file.write_text(f'api_keys_file = "{keys}"')
    known = load().keys()
    assert known.owner(KEY) == "alice"
    assert known.owner(f"{KEY}x") == "key-9b607dd4"
    assert known.owner(KEY[:-1]) is None


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "it holds no key"),
        ("# none\n", "it holds no key"),
        (f"\nalice:{KEY}\ns3cret\n", "line 3: KEY or"),
    ],
)
def test_a_file_of_keys_without_any_does_not_open_the_door(
    file: Path, tmp_path: Path, content: str, said: str
) -> None:
    keys = tmp_path / "keys"
    keys.write_text(content)
    file.write_text(f'api_keys_file = "{keys}"')
    with pytest.raises(SettingsError, match=said) as raised:
        load()
    assert "s3cret" not in str(raised.value)


def test_the_page_is_the_one_of_the_code() -> None:
    assert PAGE.read_text() == page(), "refresh it: primfit settings --markdown > docs/settings.md"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('jobs_address = "10.0.0.1:6379"', "jobs_address: .* jobs_executor must be ray"),
        ('jobs_executor = "ray"', "jobs_executor: jobs_path is needed, too"),
        ('jobs_executor = "dask"', "jobs_executor: input should be 'local' or 'ray'"),
    ],
)
def test_a_cluster_for_jobs_needs_jobs_and_an_address_a_cluster(file: Path, text: str, said: str) -> None:
    file.write_text(text)
    with pytest.raises(SettingsError, match=said):
        load()


@pytest.mark.skipif(importlib.util.find_spec("ray") is not None, reason="Ray is installed")
def test_a_cluster_for_jobs_needs_an_extra(file: Path, tmp_path: Path) -> None:
    file.write_text(f'jobs_executor = "ray"\njobs_path = "{tmp_path}"')
    with pytest.raises(
        SettingsError, match=r"jobs_executor: Ray needs an extra: pip install 'primfit\[ray\]'"
    ):
        load()
