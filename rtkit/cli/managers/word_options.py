"""Options of the words of ``rtmgr``, each of which is for a few of them only."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.cli.shared.options import flag, option, several
from rtkit.errors import UsageProblem

_OF_SERVICES = ("install", "uninstall")


class WordOptions(NamedTuple):
    """Options that only some words take."""

    is_kept: bool = flag("--keep", "stop: keep all for the next start.")
    is_forgotten: bool = flag("--forget", "restart: begin empty.")
    is_user: bool = flag("--user", "install: a service of this user (default but for root).")
    is_system: bool = flag("--system", "install: a service of the machine (root's default).")
    user: str = option("--run-as USER", "install --system: run as this user.", default="")
    is_forced: bool = flag("--force", "install, uninstall: also a unit that was changed.")
    hosts: tuple[str, ...] = several("--host NAME", "start, stop: on a host of rthost list.")
    replaces: bool = flag("--replace", "start --host: end a manager of another rtkit there.")

    def check(self, word: str) -> None:
        """Check that a word takes the options that were given; "" stands for no word.

        Raises:
            UsageProblem: It does not; or options exclude each other.
        """
        for option_, is_given, words in (
            ("--keep", self.is_kept, ("stop",)),
            ("--forget", self.is_forgotten, ("restart",)),
            ("--user", self.is_user, _OF_SERVICES),
            ("--system", self.is_system, _OF_SERVICES),
            ("--run-as", bool(self.user), ("install",)),
            ("--force", self.is_forced, _OF_SERVICES),
            ("--host", bool(self.hosts), ("start", "stop")),
            ("--replace", self.replaces, ("start",)),
        ):
            if is_given and word not in words:
                raise UsageProblem(f"{option_} is for rtmgr {' and '.join(words)}")
        if self.is_user and (self.is_system or self.user):
            raise UsageProblem("--user excludes --system and --run-as")
