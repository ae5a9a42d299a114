"""Makes wheels by hand, well-formed or not."""

from __future__ import annotations

import base64
import hashlib
import json
import zipfile
from pathlib import Path

from rtkit.packages.wheel import read_wheel

MODULE = '''
from rtkit import component as rt


class {type}(rt.Component):
    """Be {type}."""

    vendor = "me"
    category = "test"
    version = "{version}"


def {type}Init(manager):
    manager.register_factory({type})
'''


def made(
    folder: Path,
    name: str,
    version: str,
    files: dict[str, str] | None = None,
    *,
    type: str = "",
    requires: tuple[str, ...] = (),
    lies: tuple[str, ...] = (),
    links: tuple[str, ...] = (),
    source: str = MODULE,
) -> Path:
    """Write a wheel: `lies` are files whose bytes are not what RECORD says."""
    folder.mkdir(exist_ok=True, parents=True)
    info = f"{name}-{version}.dist-info"
    needs = "".join(f"Requires-Dist: {each}\n" for each in requires)
    inside = {
        **(files or {}),
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{needs}",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    if type:
        inside[f"{name}/{type}.py"] = source.format(type=type, version=version)
        inside[f"{name}/__init__.py"] = ""
        points = f"[rtkit.components]\n{type} = {name}.{type}:{type}Init\n"
        inside[f"{info}/entry_points.txt"] = points
    rows = [f"{path},sha256={_digest(text)},{len(text)}" for path, text in inside.items()]
    path = folder / f"{name}-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for each, text in inside.items():
            entry = zipfile.ZipInfo(each)
            entry.external_attr = (0o120777 if each in links else 0o100644) << 16
            archive.writestr(entry, f"{text}#" if each in lies else text)
        archive.writestr(f"{info}/RECORD", "\n".join([*rows, f"{info}/RECORD,,", ""]))
    return path


def _digest(text: str) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest()).decode().rstrip("=")


def unpacked(data: Path, wheel: Path) -> Path:
    """Unpack a wheel where ``rtpkg install`` would, below that data folder; nothing is checked."""
    found = read_wheel(str(wheel))
    place = data / "rtkit" / "packages" / found.name / found.version
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    (place / ".rtkit-package.json").write_text(
        json.dumps(
            {
                "types": [each.id for each in found.types],
                "requires": found.requires,
                "wheels": {found.file: found.sha256},
            }
        )
    )
    return place
