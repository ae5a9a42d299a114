"""Keeps what a dialogue knows in a file: site, names, prices, definitions, results, tasks, legs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from manipulation.dialogue import Dialogue
from manipulation.jobs import Job
from manipulation.knowledge import Prices, Site, Thing
from manipulation.language import Go, PickUp, Take, parse
from manipulation.legs import Leg, Question
from rtkit.errors import Malformed

_FORM = 1


def site_of(drawing: Mapping[str, Any]) -> Site:
    """Return what is known of a site at first: its walls, but none of the things."""
    walls = {(x, y) for x, y in drawing.get("walls", ())}
    return Site(drawing["width"], drawing["height"], walls, (*drawing.get("hand", (1, 1)), 0))


def saved(dialogue: Dialogue) -> dict[str, Any]:
    """Return what is to survive as plain data."""
    site = dialogue.site
    return {
        "form": _FORM,
        "width": site.width,
        "height": site.height,
        "walls": sorted(site.walls),
        "hand": site.hand,
        "holding": site.holding,
        "things": {name: vars(thing) for name, thing in site.things.items()},
        "places": site.places,
        "regions": site.regions,
        "prices": site.prices,
        "risks": site.risks,
        "definitions": dialogue.definitions,
        "jobs": [_job(job) for job in dialogue.jobs],
        "results": dialogue.results,
        "numbers": dialogue.numbers,
        "evaluations": dialogue.legs.evaluations,
        "remembered": dialogue.legs.remembered,
        "legs": [
            [key, leg.poses, leg.cost, sorted(leg.blocked)]
            for key, leg in dialogue.legs.known.items()
        ],
    }


def _job(job: Job) -> dict[str, Any]:
    chosen = [[str(goal), of] for goal, of in job.chosen]
    return vars(job) | {"goals": [str(goal) for goal in job.goals], "chosen": chosen}


def restored(data: Mapping[str, Any]) -> Dialogue:
    """Return the dialogue that was saved; its questions are asked again.

    Raises:
        Malformed: It was saved in another form.
    """
    if data.get("form") != _FORM:
        raise Malformed(f"saved in form {data.get('form')}, not {_FORM}")
    site = Site(data["width"], data["height"], _places(data["walls"]), tuple(data["hand"]))
    site.holding = data["holding"]
    for name, each in data["things"].items():
        found = each["found"]
        site.things[name] = Thing(
            tuple(each["pose"]),
            tuple(map(tuple, each["shape"])),
            tuple(found) if found is not None else None,
            each["is_bar"],
            each["is_named"],
            [tuple(spot) for spot in each["empty"]],
        )
    site.places = {name: tuple(place) for name, place in data["places"].items()}
    site.regions = {name: tuple(map(tuple, each)) for name, each in data["regions"].items()}
    site.prices, site.risks = Prices(*data["prices"]), dict(data["risks"])
    dialogue = Dialogue(site)
    dialogue.definitions = {n: (tuple(p), body) for n, (p, body) in data["definitions"].items()}
    dialogue.results = [tuple(each) for each in data["results"]]
    dialogue.numbers = dict(data["numbers"])
    legs = dialogue.legs
    legs.evaluations, legs.remembered = data["evaluations"], data["remembered"]
    for key, poses, cost, blocked in data["legs"]:
        leg = Leg(tuple(map(tuple, poses)), cost, frozenset(map(tuple, blocked)))
        legs.known[_question(key)] = leg
    dialogue.resume([_restored_job(each) for each in data["jobs"]])
    return dialogue


def _restored_job(data: Mapping[str, Any]) -> Job:
    goals = [_goal(text) for text in data["goals"]]
    chosen = [(_goal(text), of) for text, of in data["chosen"]]
    return Job(**{**data, "goals": goals, "chosen": chosen})


def _goal(text: str) -> Go | PickUp | Take:
    goal = parse(text, {})
    assert isinstance(goal, Go | PickUp | Take)
    return goal


def _question(key: Any) -> Question:
    shape, step, turn, risks, start, goal = key
    told = tuple((tuple(place), cost) for place, cost in risks)
    return Question(tuple(map(tuple, shape)), step, turn, told, tuple(start), tuple(goal))


def _places(places: Any) -> set[Any]:
    return {tuple(place) for place in places}


def write(dialogue: Dialogue, path: Path) -> None:
    """Write what is to survive, whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(".new")
    beside.write_text(json.dumps(saved(dialogue)), encoding="utf-8")
    os.replace(beside, path)


def read(path: Path) -> Dialogue | None:
    """Return what was written; None where nothing was.

    Raises:
        Malformed: It cannot be understood.
        OSError: It cannot be read.
    """
    if not path.exists():
        return None
    try:
        return restored(json.loads(path.read_text(encoding="utf-8")))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise Malformed(f"{path}: {error}: move it away to begin anew") from error
