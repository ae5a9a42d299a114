"""Plugin of pytest: fixtures for trials and managers, and a report of what lived at a failure.

pytest loads this module in each of its runs, also in those of projects that use nothing of it: so
it imports pytest, which is there, and all else where it is used.
"""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

MODULES = "rtkit_modules"
_TREE = pytest.StashKey["Tree"]()
"""The manager of a test, as long as it lives."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare where managers of tests look for modules."""
    text = (
        "folders where managers of tests look for modules, besides those of the test and of pytest"
    )
    parser.addini(MODULES, text, type="paths", default=[])


@pytest.fixture
def rtmanager(request: pytest.FixtureRequest) -> Iterator[Tree]:
    """Start a manager for the test alone, and return the connection to it (`rtkit.Tree`).

    It looks for modules in the folder of the test, in that of pytest's configuration, and in those
    of the setting ``rtkit_modules``. Commands that the test runs reach it, too.
    """
    from rtkit.testing.realm import own_manager

    folders = [request.path.parent, request.config.rootpath, *request.config.getini(MODULES)]
    with own_manager(*dict.fromkeys(folders)) as tree:
        request.node.stash[_TREE] = tree
        try:
            yield tree
        finally:
            del request.node.stash[_TREE]


@pytest.hookimpl(hookwrapper=True)  # other forms need later versions of pytest
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Add to the report of a failure what lived then, and what was logged."""
    report: pytest.TestReport = (yield).get_result()
    if report.failed and "rtkit.testing.trial" in sys.modules:
        from rtkit.testing.failure import troubles

        report.sections += troubles(getattr(item, "funcargs", {}))
    if report.failed and _TREE in item.stash:
        from rtkit.testing.failure import system

        report.sections += system()
