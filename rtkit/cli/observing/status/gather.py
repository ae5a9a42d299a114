"""Gathers all that is known of a component, a slave or a manager, from it or from the disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.cli.observing.status.past import past_of
from rtkit.cli.shared.json_records import time_text
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.link.places import host_name, owner

if TYPE_CHECKING:
    from rtkit.api.rates import RateRow
    from rtkit.cli.shared.app import App
    from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

Record = dict[str, Any]
_RATES_S = 2.5
"""How long metrics are waited for [s]; they come once a second."""
_WELL = ("Created", "Inactive", "Active")
_SLOW = 0.9


class Known(NamedTuple):
    """Facts about a manager, living or not, and the entry of its tree that is asked about."""

    snapshot: Snapshot
    node: TreeNode
    is_live: bool


def record_of(app: App, path: Path, lines: int, *, has_rates: bool) -> Record:
    """Return all that is known of the entry at a path, with its last `lines` of the log.

    Raises:
        NotFound: Nothing is there, nor was when its manager ended.
        Refused: It is neither component, slave nor manager.
        Unreachable: Its manager does not run, and left nothing.
    """
    known = _find(app, path)
    snapshot, node, is_live = known
    facts = snapshot.component(node.instance) if node.instance else None
    process = _process(snapshot, facts.process if facts is not None else node.process)
    row = _rates(app, facts) if is_live and has_rates and facts is not None else None
    past = past_of(app.tree if is_live else None, snapshot.manager, facts, process, lines)
    record: Record = {
        "path": str(path),
        **_identity(snapshot, node, facts, process),
        "manager": {"name": snapshot.manager, "pid": snapshot.pid, "is_running": is_live},
        "process": _plain(process),
        **(_details(snapshot, facts, row) if facts is not None else _NOTHING),
        "components": [] if facts is not None else _held(snapshot, node),
        "hosts": [] if facts is not None or node.is_slave else links_of(snapshot),
        "movable": movable_of(app, snapshot) if is_live and facts is None else [],
        "events": past.events,
        "log": past.log,
        "crash": past.crash,
        "output": past.output,
    }
    if facts is not None and facts.zombie and not is_live:
        record.update(_end_in_log(facts, past.events))
    record["warnings"] = list(_warnings(record, facts))
    is_up = record["state"] in (*_WELL, "up") and not record["why"]
    whys = [each["why"] for each in (*record["hosts"], *record["movable"])]
    record["is_well"] = is_live and is_up and not any(whys)
    return record


def _find(app: App, path: Path) -> Known:
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import NodeKind, build

    if path.port is not None:
        raise Refused(f"Not a component, slave or manager: {path.typed}")
    try:
        root, host = app.root(path, is_deep=False)
        node, is_live = entry(root, path, host), True
        instances = [node.instance] if node.instance else None
        snapshot = app.tree.snapshot() if instances is None else app.tree.part(instances)
    except Unreachable as error:
        from rtkit.deployment.listing import listing_of
        from rtkit.manager.predecessor.last_known import last_known

        # One that runs and does not answer knows more than the disk does.
        left = last_known(app.manager) if owner(app.manager) is None else None
        if left is None:
            hint = f"; rtvlog {path.typed} shows what was logged" if path.typed else ""
            raise Unreachable(f"{error}{hint}") from None
        snapshot, is_live = left, False
        try:
            node = entry(build(listing_of(left)), path, left.host)
        except NotFound as absent:
            raise NotFound(f"{absent} (manager {left.manager!r} is not running)") from None
    if node.kind not in (NodeKind.COMPONENT, NodeKind.ZOMBIE, NodeKind.MANAGER):
        raise Refused(f"Not a component, slave or manager: {path.typed}")
    return Known(snapshot, node, is_live)


def _process(snapshot: Snapshot, name: str) -> ProcessFacts | None:
    """Return the process of that name, one that lives before one that is lost."""
    named = [each for each in snapshot.processes if each.name == name]
    return next((each for each in named if each.state != "lost"), named[-1] if named else None)


def _plain(process: ProcessFacts | None) -> Record:
    if process is None:
        return {"name": "", "pid": 0, "state": "", "reason": ""}
    return {key: getattr(process, key) for key in ("name", "pid", "state", "reason")}


def _identity(
    snapshot: Snapshot, node: TreeNode, facts: ComponentFacts | None, process: ProcessFacts | None
) -> Record:
    if facts is None:
        started = float(snapshot.properties.get("manager.started", 0)) if not node.is_slave else 0
        return {
            "kind": "slave" if node.is_slave else "manager",
            "name": node.process,
            "state": process.state if process is not None else "lost",
            "why": process.reason if process is not None else "",
            "since": _time(started),
            "type": "",
            "description": "",
        }
    status = facts.restart_status
    why = facts.zombie or facts.trouble or facts.cause or status.trouble or status.rested
    return {
        "kind": "component",
        "name": facts.instance,
        "state": "Zombie" if facts.zombie else facts.state,
        "why": why,
        "since": _time(facts.since),
        "type": facts.type.id,
        "description": facts.type.description,
    }


def _end_in_log(facts: ComponentFacts, events: Sequence[Mapping[str, str]]) -> Record:
    """Return why and when a zombie ended, if only the log of its manager knows that."""
    from rtkit.manager.predecessor.last_known import UNKNOWN

    head = f"{facts.instance} was lost: "
    last = events[-1] if events and facts.zombie == UNKNOWN else {"detail": ""}
    if not last["detail"].startswith(head):
        return {}
    return {"why": last["detail"].removeprefix(head), "since": last["time"]}


def _time(seconds: float) -> str:
    return time_text(int(seconds * 1e9)) if seconds else ""


_NOTHING: Record = {
    "contexts": [],
    "cpu_percent": None,
    "memory_bytes": None,
    "active_set": "",
    "restarts": None,
    "health": [],
    "limits": "",
    "connections": [],
}


def _details(snapshot: Snapshot, facts: ComponentFacts, row: RateRow | None) -> Record:
    from rtkit.deployment.extension import HEALTH
    from rtkit.deployment.health import policy_in
    from rtkit.deployment.limits import limits_in
    from rtkit.rtc.create import readable_create

    create, known = readable_create(facts.create), snapshot.properties
    process = create.place or snapshot.manager
    policy = policy_in(create.options, process, lambda key: known.get(key, ""))
    status = facts.restart_status
    return {
        "contexts": [
            {
                "id": context.id,
                "kind": context.kind.value,
                "is_running": context.is_running,
                "state": context.state.value,
                "rate_hz": context.rate,
                "reached_hz": row.reached_hz if row and row.context == context.id else None,
                "mean_s": row.mean_s if row and row.context == context.id else None,
                "longest_s": row.longest_s if row and row.context == context.id else None,
                "missed": context.missed,
                "missed_hz": row.missed_hz if row and row.context == context.id else None,
                "latest_s": row.latest_s if row and row.context == context.id else None,
                "trouble": context.trouble,
            }
            for context in facts.contexts
        ],
        "cpu_percent": row.cpu_percent if row else None,
        "memory_bytes": row.memory_bytes if row else None,
        "active_set": facts.active_set,
        "restarts": {
            "policy": policy.restart.value,
            "count": status.restarts,
            "why": status.why,
            "returning": status.returning,
            "given_up": status.given_up,
        },
        "health": [
            f"{key.removeprefix(HEALTH)} {value}"
            for key, value in create.options.items()
            if key.startswith(HEALTH)
        ],
        "limits": limits_in(facts.create).text,
        "connections": list(_connections(snapshot, facts, row)),
    }


def _connections(
    snapshot: Snapshot, facts: ComponentFacts, row: RateRow | None
) -> Iterator[Record]:
    """Yield each port with the paths of those at the other ends, and values a second."""
    from rtkit.cli.shared.component_paths import port_path
    from rtkit.deployment.shown_ports import OwnEnds
    from rtkit.rtc.profiles import PortRef

    rates = {**(row.written_hz or {}), **(row.read_hz or {})} if row else {}
    own = OwnEnds.of(snapshot)
    for port in facts.ports:
        end = own.end(PortRef(facts.instance, port.name))
        others = [o for c in snapshot.connectors if end in c.ports for o in c.ports if o != end]
        yield {
            "port": port.name,
            "type": port.port_type.value,
            "to": [port_path(snapshot, each.instance, each.port) or str(each) for each in others],
            "rate_hz": rates.get(port.name),
        }


def _held(snapshot: Snapshot, node: TreeNode) -> list[Record]:
    return [
        {
            "name": facts.instance,
            "state": "Zombie" if facts.zombie else facts.state,
            "why": facts.zombie or facts.trouble or facts.cause,
            "process": facts.process,
        }
        for facts in snapshot.components
        if not node.is_slave or facts.process == node.process
    ]


def links_of(snapshot: Snapshot) -> list[Record]:
    """Return the hosts that a manager of this host links, and why one cannot be reached."""
    from rtkit.link import host_links

    links = map(host_links.read, host_links.hosts() if snapshot.host == host_name() else ())
    return [
        {"name": link.host, "why": link.why} for link in links if link.manager == snapshot.manager
    ]


def movable_of(app: App, snapshot: Snapshot) -> list[Record]:
    """Return the components that an owner may make elsewhere, as a manager was told of them.

    Its owner knows why that failed, or where an older one may live.
    """
    from rtkit.api import owning

    with suppress(RtkitError):  # not told to those who may only look
        rows = [line.split(" ") for line in app.tree.get("get_fences").splitlines()]
        whys = owning.troubles(snapshot.manager) if snapshot.host == host_name() else {}
        return [
            {
                "name": name,
                "home": home,
                "epoch": int(epoch),
                "owner": owner,
                "why": whys.get(name, ""),
            }
            for name, epoch, home, owner in rows
        ]
    return []


def _rates(app: App, facts: ComponentFacts) -> RateRow | None:
    """Return the rates of a component, measured for a second; None where none are told."""
    from rtkit.api.rates import Rater
    from rtkit.deployment.delta import TREE
    from rtkit.deployment.metrics import METRICS, Metrics
    from rtkit.tree.subscription import ManagerSubscription

    if facts.zombie:
        return None
    rater, until = Rater(), monotonic() + _RATES_S
    try:
        with ManagerSubscription(app.tree, (TREE, METRICS)) as subscription:
            while not rater.has_rates and monotonic() < until:
                for event in subscription.wait(max(0.0, until - monotonic())):
                    if isinstance(event, Metrics):
                        rater.take(event)
            rows = rater.rows(subscription.facts, {facts.instance: ""})
            return next(rows, None)
    except Unreachable as error:
        app.fail(f"no rates: {error}")
        return None


def _warnings(record: Mapping[str, Any], facts: ComponentFacts | None) -> Iterator[str]:
    from rtkit.api.looking import present_code

    for context in record["contexts"]:
        asked, reached = context["rate_hz"], context["reached_hz"]
        is_waiting = facts is not None and facts.waits
        if asked and reached is not None and reached < _SLOW * asked and not is_waiting:
            yield f"context {context['id']} reaches {reached:.4g} of {asked:.4g} Hz"
        if context["trouble"]:
            yield f"context {context['id']} runs without {context['trouble']}"
    if not record["manager"]["is_running"]:
        yield f"rtmgr start {record['manager']['name']} makes again what was to be there"
        return
    if facts is None:
        return
    if facts.restart_status.stops:
        yield facts.restart_status.stops
    if facts.waits:
        yield f"it is {facts.waits}; rtattach {record['path']} gives it some"
    file = facts.changed_code(present_code([facts]))
    if file:
        yield f"its code has changed since it was loaded ({file})"
    if record["state"] == "Error":
        yield f"rtreset {record['path']} takes it out of Error"
    elif facts.zombie and not facts.restart_status.returning:
        yield f"rtdel -z {record['path']} takes the entry away"
