"""What every test of real processes starts from, and what must be gone after it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest
from forked import Commands
from hypothesis import HealthCheck, settings
from kept import KeptManager
from shells import ROOT, Shell, opened_shell

# A law holds or does not, however slow or busy the machine is that tries it.
settings.register_profile(
    "rtkit", settings(), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("rtkit")


def pytest_configure() -> None:
    """Heed the keys of a terminal, commands too: a shell in the background starts them deaf."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)


@pytest.fixture(scope="session")
def commands(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Commands]:
    """What runs commands as forks of one process, which spares each its imports."""
    commands = Commands({**os.environ, "PYTHONPATH": str(ROOT)}, tmp_path_factory.getbasetemp())
    yield commands
    commands.close()


@pytest.fixture
def shell(request: pytest.FixtureRequest) -> Iterator[Shell]:
    """A shell without a manager; whatever it starts must be gone at the end.

    Its commands are forks, but in modules of tests that say ``RUNS_PROCESSES``: these are about
    more than what a command says and does.
    """
    if _keeps_manager(request):
        kept = request.getfixturevalue("kept_manager")
        yield kept.take()
        kept.give_back()
        return
    is_real = getattr(request.module, "RUNS_PROCESSES", False)
    with opened_shell(None if is_real else request.getfixturevalue("commands")) as shell:
        yield shell


@pytest.fixture(scope="module")
def shared_shell(commands: Commands) -> Iterator[Shell]:
    """A shell for all tests of a module, which leave what is there as it is."""
    with opened_shell(commands) as shell:
        yield shell


@pytest.fixture
def shells() -> Callable[[], AbstractContextManager[Shell]]:
    """What opens one shell after the other, for tests that try many things."""
    return opened_shell


@pytest.fixture
def manager(request: pytest.FixtureRequest, shell: Shell) -> Shell:
    """A shell with a running manager, which nothing is known of.

    In modules of tests that say ``KEEPS_MANAGER`` it is the one of the test before, if it is as new
    (see `KeptManager`).
    """
    if not _keeps_manager(request):
        shell.ok("rtmgr start")
    return shell


@pytest.fixture(scope="module")
def kept_manager(commands: Commands) -> Iterator[KeptManager]:
    kept = KeptManager(commands)
    yield kept
    kept.close()


def _keeps_manager(request: pytest.FixtureRequest) -> bool:
    return getattr(request.module, "KEEPS_MANAGER", False) and "manager" in request.fixturenames
