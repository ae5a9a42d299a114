"""Generates project files of a component: metadata for pip, linter settings, ignored files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

from rtkit.builder.regions import FILE_STAMP
from rtkit.builder.source_text import one_line
from rtkit.builder.subject import GeneratedComponent

ENTRY_POINTS = "rtkit.components"
"""Entry points of this group are modules of components: ``NAME = MODULE:INIT``."""

_VERSION = re.compile(r"v?(\d{1,9}(?:\.\d{1,9}){0,5})(?:[-_.]?(?:(a|b|rc)|alpha|beta)(\d{0,9}))?")
_PLAIN_NAME = re.compile(r"[A-Za-z0-9][\w.-]*", re.ASCII)
_DEVELOPMENT = (
    "[project.optional-dependencies]",
    'dev = ["pytest>=8", "ruff>=0.9"]',
    "",
    "[tool.pytest.ini_options]",
    'pythonpath = ["."]',
    'testpaths = ["tests"]',
    "",
)
OWN_RULES = ("E742", "N802", "N999")
FOREIGN_RULES = ("E741", "E742", "E743", "N802", "N803", "N999")
TYPE_RULES = ("E741", "E742", "E743", "N801", "N802", "N803", "N815", "N816", "N999")
"""Rules about names that do not hold in a file: our own, with names of IDL files, of types."""

_MIRROR_RULES = tuple(sorted({*FOREIGN_RULES, *TYPE_RULES, "I001"}))
_SELECT = ("E", "F", "W", "I", "UP", "B", "C4", "D", "N", "SLF", "RUF", "PT", "SIM", "TID")


def project_name(type_name: str) -> str:
    """Return a name that package indexes take."""
    name = re.sub("[^a-z0-9]+", "-", type_name.lower()).strip("-")
    return f"rtc-{name}" if name else "rtc-component"


def package_name(type_name: str) -> str:
    """Return the name of the package that an installed component is."""
    return project_name(type_name).replace("-", "_")


def project_version(version: str) -> str:
    """Return the version in the form of package indexes; ``0`` where it is none."""
    found = _VERSION.match(version.strip())
    return found[1] if found else "0"


def toml(text: str) -> str:
    """Return a basic string of TOML."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in plain) + '"'


def entries(subjects: Sequence[GeneratedComponent]) -> dict[str, str]:
    """Return the lines by which the components are found where the package is installed."""
    package = package_name(subjects[0].type_name)
    found = {}
    for each in subjects:
        name = each.type_name if _PLAIN_NAME.fullmatch(each.type_name) else each.module
        target = f"{package}.{each.module}:{each.init}"
        found[target] = f"{toml(name)} = {toml(target)}"
    return found


def with_entries(text: str, lines: Mapping[str, str]) -> str:
    """Return a ``pyproject.toml`` of users with the entry points that it lacks; "" where it can't.

    Args:
        text: Its present content.
        lines: The line of each entry point, by its target.
    """
    heading = f'[project.entry-points."{ENTRY_POINTS}"]\n'
    new = "".join(f"{line}\n" for target, line in lines.items() if target not in text)
    if new and heading not in text:
        return ""
    return text.replace(heading, f"{heading}{new}", 1)


def pyproject(
    subjects: Sequence[GeneratedComponent], *, has_idl: bool = False, has_mirror: bool = False
) -> str:
    """Return ``pyproject.toml`` of components, named after the first one, not yet stamped.

    Args:
        subjects: The components.
        has_idl: Whether IDL files go with them.
        has_mirror: Whether there is a mirror of one.
    """
    subject = subjects[0]
    package = package_name(subject.type_name)
    rules: dict[str, Sequence[str]] = {}
    for each in subjects:
        rules[f"{each.module}.py"] = FOREIGN_RULES if _has_foreign_names(each) else OWN_RULES
        if each.has_types:
            rules[f"{each.types_module}.py"] = TYPE_RULES
    description = subject.description or f"Component {subject.type_name}"
    lines = [
        FILE_STAMP,
        "",
        "[build-system]",
        'requires = ["setuptools>=77"]',
        'build-backend = "setuptools.build_meta"',
        "",
        "[project]",
        f"name = {toml(project_name(subject.type_name))}",
        f"version = {toml(project_version(subject.info.version))}",
        f"description = {toml(one_line(description))}",
        'readme = "README.md"',
        'requires-python = ">=3.11"',
        'dependencies = ["rtkit"]',
        "",
        *_DEVELOPMENT,
        "# By this rtmgr finds what is in the package where that is installed.",
        f'[project.entry-points."{ENTRY_POINTS}"]',
        *entries(subjects).values(),
        "",
        "# This folder is the package, so that no module hides one of another component.",
        "[tool.setuptools]",
        f"packages = [{toml(package)}]",
        f'package-dir = {{ {toml(package)} = "." }}',
        "include-package-data = false",
        "",
        "[tool.setuptools.package-data]",
        f"{toml(package)} = [{_listed(['*.xml', *(['idl/*.idl'] if has_idl else [])])}]",
        "",
        *linter(rules),
        '"tests/**" = ["D", "N999", "SLF"]',
        *([f'"mirror/**" = [{_listed(_MIRROR_RULES)}]'] if has_mirror else []),
        "",
    ]
    return "\n".join(lines)


def linter(rules: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the settings of ruff; `rules` are those that do not hold, by file."""
    return [
        "[tool.ruff]",
        "line-length = 100",
        'target-version = "py311"',
        "",
        "[tool.ruff.lint]",
        f"select = [{_listed(_SELECT)}]",
        "# Texts of the profile may be of any language.",
        'ignore = ["D105", "D107", "N818", "RUF001", "RUF002", "RUF003"]',
        "",
        "[tool.ruff.lint.pydocstyle]",
        'convention = "google"',
        "",
        "[tool.ruff.lint.per-file-ignores]",
        "# Names that loaders look for, and those of interface definitions.",
        *(f"{toml(file)} = [{_listed(codes)}]" for file, codes in rules.items()),
    ]


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(map(toml, texts))


def _has_foreign_names(subject: GeneratedComponent) -> bool:
    return any(offer.methods for service in subject.services for offer in service.offers)
