"""Plugin of pytest: fixtures for trials and managers, and a report of what lived at a failure.

pytest loads this module in each of its runs, also in those of projects that use nothing of it: so
it imports pytest, which is there, and all else where it is used.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from rtkit.api.ports import PortReader
    from rtkit.api.tree import Tree

MODULES = "rtkit_modules"
_NOTES = pytest.StashKey[list[str]]()
"""Plans of a test, and what was reported while they were carried out."""
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


@pytest.fixture
def rtsystem(rtmanager: Tree, request: pytest.FixtureRequest) -> Callable[..., Tree]:
    """Return what brings the system of a profile up, at the manager of the test, and returns that.

    ::

        def test_it(rtsystem):
            system = rtsystem("Heating.xml", stand_in=["Heater0"])
            assert system.read("/localhost/Thermostat0.rtc:power", timeout_s=5.0).data == 0.0

    The file is looked for beside the test. All components are active then, unless `state` says
    otherwise. `stand_in` is True for stand-ins of all, a list of components, or a mapping of their
    names to values that their out ports transmit: ``{"Camera0": {"image": [{"width": 2}]}}``.
    `values` and `prefix` are those of `rtkit.load`, other arguments those of `rtkit.Tree.plan`.
    """
    notes: list[str] = []
    request.node.stash[_NOTES] = notes

    def bring_up(
        profile: Any, *, stand_in: Any = False, values: Any = None, prefix: str = "", **more: Any
    ) -> Tree:
        __tracebackhide__ = True
        from rtkit.api.system_profiles import load
        from rtkit.errors import RtkitError
        from rtkit.testing.system import bring_up

        if isinstance(profile, str | os.PathLike):
            beside = request.path.parent / profile
            profile = beside if beside.exists() else profile
        try:
            loaded = load(profile, values=values, prefix=prefix)
            bring_up(rtmanager, loaded, stand_in, notes, **more)
        except RtkitError as error:  # its text says what is wrong; how it was found does not help
            raise error.with_traceback(None) from None
        return rtmanager

    return bring_up


@pytest.fixture
def rtport(rtmanager: Tree) -> Iterator[Callable[[str], PortReader]]:
    """Return what reads an out port at the manager of the test, from that moment on.

    ::

        power = rtport("/localhost/Thermostat0.rtc:power")
        rtmanager.write("/localhost/Thermostat0.rtc:temperature", {"data": 20.0})
        assert power.read(timeout_s=5.0).data == 0.5
    """
    from contextlib import ExitStack

    from rtkit.api.ports import PortReader

    with ExitStack() as stack:
        yield lambda path: stack.enter_context(PortReader(rtmanager, [path]))


@pytest.hookimpl(hookwrapper=True)  # other forms need later versions of pytest
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Add to the report of a failure what lived then, and what was logged."""
    report: pytest.TestReport = (yield).get_result()
    if report.failed and "rtkit.testing.trial" in sys.modules:
        from rtkit.testing.failure import troubles

        report.sections += troubles(getattr(item, "funcargs", {}))
    if report.failed and _TREE in item.stash:
        from rtkit.testing.failure import system

        if notes := item.stash.get(_NOTES, []):
            report.sections.append(("rtkit: plan", "\n".join(notes)))
        report.sections += system()
