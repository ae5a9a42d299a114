"""Extensions of rtkit in system profiles and create strings.

In a profile they are extension properties of a component, so that the file stays valid for other
tools. In the create string of a stand-in they keep what its profile stated in extensions of its
own, so that a saved profile states the same again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rtkit.errors import Malformed
from rtkit.rtc import naming_properties as naming
from rtkit.rtc.create import parse_create, readable_create

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts

CREATE = naming.CREATE
MODULE = "rtkit.module"
"""Property: ``PATH:INIT`` of the module that it needs."""
HOT = "rtkit.hot"
"""Property: parameters that may be changed while the component is active, comma separated."""
COST = "rtkit.cost"
"""Property: what interrupting the component costs in plans, or ``KIND=NUMBER``, comma separated."""
STATES = "rtkit.states"
"""Property of a system: the names of its states, comma separated; in the first one it begins."""
TRANSITIONS = "rtkit.transitions"
"""Property of a system: what leads from state to state, ``A -EVENT-> B``, semicolon separated."""
STATE_CHART = "rtkit.state-chart"
"""Property of a system: the same as SCXML, the text or a file; instead of those two."""
STATE = naming.STATE
EVENT = naming.EVENT
FOLLOW = "rtkit.follow"
"""Property of a system: ``true`` to have its manager follow its events once it is brought up; and
of a manager: the systems that it follows."""
STAND_IN = "rtkit.stand-in"
"""Property: ``yes`` for a stand-in; with ``.PORT`` added, JSON values that the port transmits."""
INTERFACES = "rtkit.interfaces"
"""Property of a service port: its interfaces, ``Provided TYPE NAME``, comma separated."""
STATED_TYPE = "rtkit.stated-type"
"""Property of a live port: data type that its profile states, when its connection has another."""
STATED_ID = "rtkit.id"
"""Option: the identity as the profile writes it, when not in the usual form."""
STATED_KIND = "rtkit.kind."
"""Option: the kind of the context that follows, as the profile writes it."""
UNSTATED = "rtkit.unstated"
"""Option: what the profile leaves open: ``active-set``, ``set:NAME``, comma separated."""
RESTART = "rtkit.restart"
"""Property of a component: ``never``, ``on-failure`` or ``always``."""
RESTART_DELAY = f"{RESTART}.delay"
"""Property of a component: how long the first restart waits [s]."""
RESTART_LIMIT = f"{RESTART}.limit"
"""Property of a component: how many restarts within 60 s are made."""
SLAVE_RESTART = naming.SLAVE_RESTART
CRITICAL = "rtkit.critical"
"""Property of a component: ``yes`` if its loss stops the system."""
HEALTH = "rtkit.health."
"""Property of a component, with the name of a rule: what it must do to count as well."""
LIMIT = "rtkit.limit."
"""Property of a component, with what is limited: the most that its slave may use of it."""
LIMIT_MEMORY = f"{LIMIT}memory"
"""Property of a component: resident memory that its slave may have, such as ``200M``."""
LIMIT_PROCESSES = f"{LIMIT}processes"
"""Property of a component: how many processes its slave may be."""
LIMIT_DESCRIPTORS = f"{LIMIT}descriptors"
"""Property of a component: how many files each of those processes may have open."""
LIMIT_PROCESSOR = f"{LIMIT}processor"
"""Property of a component: share of a processor that its slave may use, ``0.5`` or ``50%``."""
MOVABLE = "rtkit.movable"
"""Property of a component: ``SECONDS [HOST...]``: made there when its host was lost for so long."""
PLACE = "rtkit.place."
"""Property of a component, with the name of a requirement: where it may be."""
PLACE_HOSTS = f"{PLACE}hosts"
"""Property of a component: the hosts of which it is to be on one, comma separated."""
PLACE_TAGS = f"{PLACE}tags"
"""Property of a component: words that its host must have, comma separated."""
PLACE_MEMORY = f"{PLACE}memory"
"""Property of a component: memory that must be free on its host, such as ``500M``."""
PLACE_DEVICE = f"{PLACE}device"
"""Property of a component: devices that its host must have, ``video0`` or a path."""
PLACE_DEVICE_POLICY = f"{PLACE}device_policy"
"""Property of a component: what becomes of it when a device goes, ``end`` or ``keep``."""
PLACE_WITH = f"{PLACE}with"
"""Property of a component: the components in whose process it is to be, comma separated."""
PLACE_APART = f"{PLACE}not_with"
"""Property of a component: the components on whose hosts it is not to be, comma separated."""
TRANSMIT = "standin.transmit"
"""Option: ``default`` to have a stand-in write default values, and answer calls with them."""


def is_policy(key: str) -> bool:
    """Return whether a property states restarts, health, limits or a place, perhaps misspelt."""
    begins = (f"{RESTART}.", f"{CRITICAL}.", HEALTH, LIMIT, PLACE)
    return key in (RESTART, CRITICAL) or key.startswith(begins)


def policy_in(create: str) -> dict[str, str]:
    """Return the properties of a policy in a create string; none in one that cannot be read."""
    options = readable_create(create).options
    return {key: value for key, value in options.items() if is_policy(key)}


def with_policy(create: str, policy: Mapping[str, str]) -> str:
    """Return a create string with these properties for the policy that it has.

    Raises:
        Malformed: The create string cannot be read, or one of them is no property of a policy.
    """
    for key in policy:
        if not is_policy(key):
            raise Malformed(f"{key} is no property of restarts, health, limits or places")
    made = parse_create(create)
    return str(made.with_options(**{**dict.fromkeys(policy_in(create), ""), **policy}))


def options_of(facts: ComponentFacts) -> Mapping[str, str]:
    """Return the options of the create string that made a component."""
    return readable_create(facts.create).options


def stated_id(facts: ComponentFacts) -> str:
    """Return the identity of a component's type as its profile writes it."""
    return options_of(facts).get(STATED_ID, "") or facts.type.id
