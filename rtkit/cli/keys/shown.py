"""Rows and records of certificates."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal

if TYPE_CHECKING:
    from rtkit.cli.shared.app import App
    from rtkit.keys.authority import Issued

_SOON_DAYS = 30


def show(app: App, found: Iterable[Issued], *, is_json: bool) -> None:
    """Print certificates, and warn of those that end soon."""
    now = datetime.now(UTC)
    shown = list(found)
    if is_json:
        terminal.write(json_records.line("certificate", _record(each)) for each in shown)
    else:
        rows = [
            [
                each.name,
                each.role or "no role",
                each.serial,
                f"{each.begins:%Y-%m-%d}",
                f"{each.ends:%Y-%m-%d}",
                _state(each, now),
                " ".join(each.hosts),
            ]
            for each in shown
        ]
        terminal.write(terminal.table(rows))
    for each in shown:
        days = (each.ends - now).days
        if not each.revoked and each.ends > now and days < _SOON_DAYS:
            app.warn([f"{each.name} ends in {days} days (rtkeys issue {each.name})"])


def _state(each: Issued, now: datetime) -> str:
    if each.revoked is not None:
        return f"revoked {each.revoked:%Y-%m-%d}"
    return "good" if each.begins <= now <= each.ends else "expired"


def _record(each: Issued) -> dict[str, object]:
    times = (each.begins, each.ends, each.revoked)
    begins, ends, revoked = (at and at.isoformat() for at in times)
    shown = each._asdict() | {"hosts": [*each.hosts], "revoked": revoked}
    del shown["begins"], shown["ends"]
    return shown | {"from": begins, "until": ends}
