"""Does work at several hosts at the same time, with progress, and tells what was done at each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, TypeVar

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.cli.shared.progress import Meter
    from rtkit.hosts.host import Host
    from rtkit.hosts.progress import HostStep, Progress

T = TypeVar("T")


def at_all(
    app: App,
    hosts: Sequence[Host],
    work: Callable[[Host, Progress], T],
    summary: Callable[[T], str],
) -> dict[str, T | RtkitError]:
    """Do work at all hosts; return what came of it by their names, in their order.

    Each that failed is told at once, each that did not in the end, by a line with its `summary`; an
    empty one is no line.
    """
    from rtkit.cli.shared.progress import metered_each
    from rtkit.hosts.at_once import at_once

    found: dict[str, T | RtkitError] = {}
    try:
        with metered_each(app, [host.name for host in hosts]) as meter:
            show = _progress(app, meter)
            asking = meter.hidden if meter else nullcontext
            for host, outcome in at_once(hosts, lambda host: work(host, show), asking):
                found[host.name] = outcome
                if isinstance(outcome, RtkitError):
                    app.fail(str(outcome))
    except KeyboardInterrupt:
        raise KeyboardInterrupt("the same command goes on where this one was") from None
    finally:
        found = {host.name: found[host.name] for host in hosts if host.name in found}
        done = ((n, e) for n, e in found.items() if not isinstance(e, RtkitError))
        lines = (f"{name}: {text}" for name, each in done if (text := summary(each)))
        terminal.write(map(terminal.printable, lines))  # parts of it are the words of the host
    return found


def status(app: App, found: dict[str, T | RtkitError]) -> int:
    """Return the exit status: that of the first host that was named and failed."""
    failures = (each for each in found.values() if isinstance(each, RtkitError))
    return next((app.status(each) for each in failures), 0)


def _progress(app: App, meter: Meter | None) -> Progress:
    from rtkit.hosts.progress import by_lines

    if meter is None:
        return by_lines(app.verbose)

    def show(name: str, step: HostStep) -> None:
        meter.show(name, step.done, step.total or None, terminal.printable(str(step)))

    return show
