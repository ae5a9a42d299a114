"""Lists loadable modules: all in load paths and installed packages, read and not run."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.manager.core.operations import record
from rtkit.modules.describing import OfferedType, describe
from rtkit.modules.search import Search

MOST = 2000
"""How many files are looked at."""


def loadable(folders: Sequence[str]) -> str:
    """Return a line for each type, ``RTC:…?description=…&module=FILE``, or ``FILE?problem=WHY``."""
    return "\n".join(_lines(Search(folders)))


def _lines(search: Search) -> Iterator[str]:
    for name in itertools.islice(search.modules(), MOST):
        try:
            source = search.read(name)
            offers = describe(source.text, source.file, source.init)
        except (Refused, NotFound, Malformed) as error:
            yield record(name, {"problem": str(error)})
            continue
        for offer in offers or ():
            yield _record(offer, source.file)


def _record(offer: OfferedType, file: str) -> str:
    known = offer.type
    told = {
        "implementation_id": known.type_name,
        "type_name": known.type_name,
        "description": known.description,
        "version": known.version,
        "vendor": known.vendor,
        "category": known.category,
        "activity_type": "PERIODIC",
        "max_instance": "0",
        "language": known.language,
        "lang_type": "SCRIPT",
        "module": file,
    }
    values = {f"conf.default.{name}": text for name, text in offer.parameters.items()}
    return record(known.full_id, {**told, **values})
