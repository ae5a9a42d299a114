"""Shows packages: as records for other programs, and as rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import json_records, terminal
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.packages.records import Installed


def show(records: Sequence[dict[str, Any]], is_json: bool) -> None:
    """Write records of packages, one a line."""
    if is_json:
        terminal.write(json_records.lines("package", records))
        return
    rows = [
        [
            str(each["name"]),
            str(each["version"]),
            " ".join(each["types"]),
            str(each["place"]),
            f"signed by {each['signed_by']}" if each["signed_by"] else "",
        ]
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
    signed_by: str | None = None,
) -> dict[str, Any]:
    """Return the record of a package."""
    return {
        "name": name,
        "version": version,
        "types": [*types],
        "requires": [*requires],
        "wheels": [{"file": file, "sha256": digest} for file, digest in wheels.items()],
        "place": place,
        "signed_by": signed_by,
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
        signed_by=_signer(found),
    )


def _signer(found: Installed) -> str | None:
    """Return who has signed an installed package, and all that it needs."""
    from rtkit.packages.installed import kept_wheels
    from rtkit.packages.signing import shown_signer
    from rtkit.packages.wheel import read_wheel

    try:
        names = [shown_signer(read_wheel(each)) for each in kept_wheels(found)]
    except RtkitError:
        return None
    return names[0] if names and all(names) else None
