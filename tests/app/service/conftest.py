"""The page at / in one browser for all tests of it."""

from collections.abc import Iterator

import pytest

from tests.app.browser import IN_SOFTWARE, Browser, browser
from tests.app.serving import Service
from tests.app.viewing import visit


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile"), IN_SOFTWARE) as started:
        started.resize(1200)
        yield started


@pytest.fixture
def viewer(page: Browser, service: Service) -> Iterator[Browser]:
    """The page as it is at first; nothing was complained of when it is left, and nobody else was asked."""
    visit(page, service.port)
    page.complaints()
    page.network()
    yield page
    # What is refused is an error for Chromium, too; and the page about the API is another one.
    usual = ("Failed to load resource", "/docs - [DOM]")
    assert [each for each in page.complaints() if not any(words in each for words in usual)] == []
    assert page.hosts() <= {"127.0.0.1"}
