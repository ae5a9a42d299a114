"""Shows packages: as records for other programs, and as rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import json_records, terminal

if TYPE_CHECKING:
    from rtkit.packages.installed import Installed


def show(records: Sequence[dict[str, Any]], is_json: bool) -> None:
    """Write records of packages, one a line."""
    if is_json:
        terminal.write(json_records.lines("package", records))
        return
    rows = [
        [str(each["name"]), str(each["version"]), " ".join(each["types"]), str(each["place"])]
        for each in records
    ]
    terminal.write(terminal.table(rows))


def record(
    name: str,
    version: str,
    place: str,
    *,
    types: Sequence[str] = (),
    requires: Sequence[str] = (),
    wheels: dict[str, str | None],
) -> dict[str, Any]:
    """Return the record of a package."""
    return {
        "name": name,
        "version": version,
        "types": [*types],
        "requires": [*requires],
        "wheels": [{"file": file, "sha256": digest} for file, digest in wheels.items()],
        "place": place,
    }


def installed_record(found: Installed) -> dict[str, Any]:
    """Return the record of an installed package."""
    return record(
        found.name,
        found.version,
        found.path,
        types=found.types,
        requires=found.requires,
        wheels={**found.wheels},
    )
