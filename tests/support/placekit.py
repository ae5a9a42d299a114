"""System profiles whose components leave their host open, and require something of it."""

from __future__ import annotations

from pathlib import Path

import rts_text

TYPES = {"In1": "ConsoleIn", "Out1": "ConsoleOut", "Out2": "ConsoleOut"}


def free_profile(path: Path, optional: str = "", **required: dict[str, str]) -> str:
    """Write components that may be anywhere, with requirements; the first two are connected."""
    components = [
        rts_text.component(
            name,
            {
                "create": TYPES[name],
                **{f"place.{key}": text for key, text in own.items() if key != "path"},
            },
            type_id=f"RTC:rtkit:example:{TYPES[name]}:1.0",
            port="out" if name.startswith("In") else "in",
            folder=own.get("path", "*"),
            rate=10.0,
            required=name != optional,
        )
        for name, own in required.items()
    ]
    ids = [f"RTC:rtkit:example:{TYPES[each]}:1.0" for each in ("In1", "Out1")]
    wires = [rts_text.wire("w1", "In1.out", "Out1.in", ids)] if len(required) > 1 else []
    path.write_text(rts_text.system("Free", *components, *wires))
    return str(path)
