"""``rtpkg search``: what do repositories have?"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.packages.records import record, show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, several
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.packages.repository import Offer


@command(
    "search",
    is_local=True,
    examples=(
        ("rtpkg search scale --repository wheels", "By name, type or description."),
        ("rtpkg search --json", "All that the repositories of rtkit.toml have."),
    ),
    json=("package",),
    arguments=("anything",),
    statuses={"1": "Nothing was found, or a repository could not be read."},
)
def main(
    app: App,
    repositories: tuple[str, ...] = several("--repository PLACE", "Where to look; repeatable."),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments("[WORD]"),
) -> int:
    """Search repositories for packages, the newest version of each first.

    WORD is part of a name, type or description; of a simple index only names are known. Wheels
    that are not safe are told and left out; nothing of a package is run.
    """
    from rtkit.packages.repository import named_repositories, newest_first, offers, opened

    if len(words) > 1:
        raise WrongArguments("takes one word")
    failed: list[RtkitError] = []
    found: list[Offer] = []
    with opened(named_repositories(repositories)) as there:
        for each in offers(there):
            if isinstance(each, RtkitError):
                failed.append(each)
                app.fail(str(each))
            elif _is_meant(each, words[0].lower() if words else ""):
                found.append(each)
    show([_record(each) for each in newest_first(found)], is_json)
    if failed:
        return app.status(failed[0])
    return 0 if found else 1


def _is_meant(offer: Offer, word: str) -> bool:
    texts = [offer.name]
    if offer.wheel is not None:
        texts += [offer.wheel.summary, *(f"{e.id} {e.description}" for e in offer.wheel.types)]
    return any(word in text.lower() for text in texts)


def _record(offer: Offer) -> dict[str, object]:
    from rtkit.packages.signing import shown_signer

    wheel = offer.wheel
    return record(
        offer.name,
        offer.version,
        offer.repository,
        types=[each.id for each in wheel.types] if wheel else (),
        requires=wheel.requires if wheel else (),
        wheels={offer.file: wheel.sha256 if wheel else None},
        signed_by=shown_signer(wheel) if wheel else None,
    )
