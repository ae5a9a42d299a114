"""Properties of a manager: keys, meanings, and when a change takes effect.

The keys are those of ``rtc.conf``. Names with ``corba.`` are the old ones of those with ``net.``;
each is shown under the name by which it was given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.rtc import context_settings
from rtkit.rtc.manager_address import parse_address
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings import formats, values

STRICT = "rtkit.start.strict"
"""Property: whether a warning or a failure at its start ends a manager."""
LIVE = "live"
START = "start"
FIXED = "read-only"
NONE = "no effect"
"""When a change takes effect: at once, at the next start, never, or it is only kept."""

LEVELS = ("SILENT", "FATAL", "ERROR", "WARN", "INFO", "DEBUG", "TRACE", "VERBOSE", "PARANOID")
INHERITED = ("exec_cxt.", "execution_contexts", "ec.", "logger.", "naming.", "os.", "sdo.", "port.")
"""Prefixes of properties that components inherit."""

_TRUE = ("YES", "TRUE", "ON", "1")
_FALSE = ("NO", "FALSE", "OFF", "0")
_OLD = {
    "corba.endpoint": "net.endpoints",
    "manager.corba_servant": "manager.net_servant",
    "corba.update_master_manager.enable": "manager.update_master_manager.enable",
    "corba.update_master_manager.interval": "manager.update_master_manager.interval",
}


class ManagerProperty(NamedTuple):
    """A key that is known.

    Attributes:
        kind: ``text``, ``list``, ``number``, ``boolean`` or ``level``.
        when: When a change takes effect.
        meaning: One line for the manual page.
    """

    key: str
    default: str
    kind: str
    when: str
    meaning: str


def _properties() -> Iterator[ManagerProperty]:
    for line in _TABLE.strip().replace("\n    ", " ").splitlines():
        key, default, kind, when, meaning = (cell.strip() for cell in line.split("|", 4))
        yield ManagerProperty(key, default, kind, _WHEN[when], meaning)


_WHEN = {"live": LIVE, "start": START, "fixed": FIXED, "-": NONE}
_TABLE = """
config.version | | text | live | version of the file, only shown
openrtm.name | rtkit | text | fixed | the implementation
openrtm.version | | text | fixed | its version
manager.name | manager | text | start | id in direct addresses, corbaloc::host:port/ID
manager.instance_name | | text | start | name in the tree; the name given to rtmgr start comes first
manager.naming_formats | %n.mgr | list | start
    | names of the manager itself beside NAME.mgr: %n name, %h host, %M name, %p pid
manager.is_master | YES | boolean | start | NO: registers with net.master_manager as its slave
manager.net_servant | YES | boolean | start | NO: no TCP door (as rtmgr start -a)
manager.update_master_manager.enable | YES | boolean | start | NO: it registers but once
manager.update_master_manager.interval | 10.0 | number | start | how often it registers [s]
manager.components.naming_policy | process_unique | text | live
    | which names a chosen TYPE<n> differs from: those of this manager with its slaves, or
    (node_unique, ns_unique) of all managers that the user has on this host
manager.components.precreate | | list | start | create strings of components to make
manager.components.preconnect | | list | start | connections: A.out?port=B.in&dataflow_type=push
manager.components.preactivation | | list | start | instances to activate
manager.modules.load_path | | list | live | folders of modules; by default the one of the start
manager.modules.Python.load_paths | | list | live | more of them
manager.modules.preload | | list | start | modules to load: FILE (InitFunc) or FILE:InitFunc
manager.preload.modules | | list | start | modules to load before those
manager.modules.abs_path_allowed | YES | boolean | live | NO: modules from load paths only
manager.modules.search_auto | YES | boolean | live | NO: no type whose module was not loaded
manager.modules.download_allowed | NO | boolean | - | nothing is ever downloaded
manager.modules.init_func_suffix | Init | text | -
    | the init function of FILE.py is FILEInit; rtmgr -l FILE:INIT names another
manager.modules.init_func_prefix | | text | -
    | the init function of FILE.py is FILEInit; rtmgr -l FILE:INIT names another
manager.modules.config_path | | list | - | paths of config_file begin in the folder of the start
manager.supported_languages | Python | list | fixed | languages of components
manager.cpu_affinity | | list | live | processors that manager and slaves may use
manager.shutdown_on_nortcs | YES | boolean | live | a slave ends with its last component
manager.shutdown_auto | YES | boolean | live
    | and so does a slave that was forked, when nothing has been made in it for
    manager.auto_shutdown_duration
manager.auto_shutdown_duration | 20 | number | live | [s]
manager.termination_waittime | 2 | number | live | grace of slaves between TERM and KILL [s]
manager.local_service.modules | | list | - | managers have no plug-ins
manager.local_service.enabled_services | ALL | list | - | managers have no plug-ins
net.endpoints | all | list | start | TCP door: [localhost]:PORT, all for 2810, none for none
net.tls | | text | start | port for certificates of rtkeys: [ADDRESS:]PORT (rtmgr start --tls)
net.nameservers | localhost | list | - | there is no name server: each manager keeps the names
net.master_manager | localhost:2810 | text | start | master to register with if is_master is NO
net.args | | text | - | the transport takes no arguments
net.id | | text | - | there is one transport
net.alternate_iiop_addresses | | list | - | managers are reached on this host only
net.endpoint_property | | text | - | managers are reached on this host only
net.nameserver.replace_endpoint | NO | boolean | - | there is no name server
net.nameservice.replace_endpoint | NO | boolean | - | there is no name server
naming.enable | YES | boolean | live | NO: no names, but below their manager
naming.type | corba | list | - | the manager itself registers names
naming.formats | %n.rtc | list | live
    | names of components: %n instance, %t and %m type, %v version, %V vendor, %c category, %h host,
    %M manager, %p pid
naming.update.enable | YES | boolean | - | names live in the manager and never get lost
naming.update.interval | 10.0 | number | - | names live in the manager and never get lost
naming.update.rebind | NO | boolean | - | names live in the manager and never get lost
exec_cxt.periodic.type | PeriodicExecutionContext | text | live | type of the context
exec_cxt.periodic.rate | 1000 | number | live | its rate [Hz]; only if given, else the type's own
exec_cxt.sync_transition | YES | boolean | live | NO: commands wait for no transition
exec_cxt.sync_activation | | boolean | live | the same for activation only
exec_cxt.sync_deactivation | | boolean | live | the same for deactivation only
exec_cxt.sync_reset | | boolean | live | the same for reset only
exec_cxt.transition_timeout | | number | live | how long at most [s]; by default as the command says
exec_cxt.activation_timeout | | number | live | the same for activation only [s]
exec_cxt.deactivation_timeout | | number | live | the same for deactivation only [s]
exec_cxt.reset_timeout | | number | live | the same for reset only [s]
exec_cxt.cpu_affinity | | list | live | processors of the threads that drive contexts
exec_cxt.sched_policy | | text | live
    | scheduling of those threads: other, fifo, rr; fifo where only a priority is given
exec_cxt.priority | | text | live | their priority, 1 to 99
exec_cxt.memory_lock | | text | live | YES: their process stays in RAM while they are at work
exec_cxt.garbage_collector | | text | live
    | of that process while they are at work: on, frozen, between (periods), off
execution_contexts | | list | live | contexts of components: TYPE(NAME),...; none for none
logger.enable | YES | boolean | live | NO: nothing is logged
logger.file_name | | list | start | further log files, stdout or stderr; %p is the pid
logger.log_level | INFO | level | live
    | least level: SILENT FATAL ERROR WARN INFO DEBUG TRACE VERBOSE PARANOID
logger.date_format | %b %d %H:%M:%S | text | start | of logger.file_name
logger.escape_sequence_enable | NO | boolean | start | YES: logger.file_name in colours
logger.clock_type | system | text | - | records bear the time of the system
logger.plugins | | list | - | logs are files, one JSON object a line
timer.enable | YES | boolean | - | nothing is polled
timer.tick | 0.1 | number | - | nothing is polled
sdo.service.provider.enabled_services | ALL | list | - | components have no SDO services
sdo.service.consumer.enabled_services | ALL | list | - | components have no SDO services
rtkit.start.strict | NO | boolean | start
    | YES: a warning or a failure while starting ends the manager (rtmgr start --strict)
manager.restart | never | text | live
    | what is made again after it has died, if its create string does not say: never, on-failure
    (by a signal, an exit status but 0, in Error), always
rtkit.restore | YES | boolean | start
    | NO: begins without what an earlier manager kept, which is put aside
rtkit.tags | | list | live | words by which rtkit.place.tags of components choose this host
rtkit.allow_faults | NO | boolean | start | YES: RTKIT_FAULT is heeded by root's manager, too
manager.modules.*.load_paths | | list | - | components are Python
manager.modules.*.suffixes | | list | - | modules end in .py
manager.modules.*.manager_cmd | | text | - | slaves are forked
manager.modules.*.profile_cmd | | text | - | modules are read, not run
manager.restart.* | | text | live | the same for what slave * holds
manager.local_service.* | | text | - | managers have no plug-ins
logger.logstream.* | | text | - | logs are files, one JSON object a line
ec.* | | text | live | ec.TYPE.KEY, ec.NAME.KEY: rate of contexts, and what exec_cxt.KEY says of all
port.* | | text | live | defaults of ports and their connections
sdo.* | | text | - | components have no SDO services
os.* | | text | fixed | operating system of the manager
*.*.config_file | | text | live | CATEGORY.TYPE or .INSTANCE: more properties
*.*.conf.* | | text | live | CATEGORY.TYPE or .INSTANCE: conf.SET.PARAMETER, over that file
*.*.exec_cxt.* | | text | live | CATEGORY.TYPE or .INSTANCE: of its contexts, over that file
"""
"""All properties; a star in a key stands for anything."""
_READERS: Mapping[str, Callable[[str], object]] = {
    "manager.cpu_affinity": values.processors,
    "exec_cxt.cpu_affinity": values.processors,
    **{f"exec_cxt.{key}": read for key, read in context_settings.READERS.items()},
    "manager.components.naming_policy": values.naming_policy,
    "manager.naming_formats": formats.check_early,
    "manager.modules.preload": values.modules,
    "manager.preload.modules": values.modules,
    "net.master_manager": parse_address,
    "naming.formats": formats.check,
    "net.endpoints": values.endpoint,
    "net.tls": values.tls_endpoint,
    "manager.restart": values.restart,
    "manager.restart.*": values.restart,
}
_OF_COMPONENTS = ("conf", "exec_cxt")
_PATTERNS = tuple(each for each in _properties() if "*" in each.key)
KNOWN: Mapping[str, ManagerProperty] = {
    each.key: each for each in _properties() if "*" not in each.key
}


def properties() -> Iterator[ManagerProperty]:
    """Yield all that there are; a star in a key stands for anything."""
    yield from KNOWN.values()
    yield from _PATTERNS


def canonical(key: str) -> str:
    """Return the present name of a key: ``net.…`` for ``corba.…``."""
    if key in _OLD:
        return _OLD[key]
    rest = key.removeprefix("corba.")
    return f"net.{rest}" if rest != key else key


def find(key: str) -> ManagerProperty | None:
    """Return what is known of a key, by its present or old name."""
    name = canonical(key)
    known = KNOWN.get(name)
    if known is not None:
        return known
    return next((each for each in _PATTERNS if _fits(each.key, name)), None)


def unknown(key: str) -> str:
    """Return a finding about a key that is not known."""
    old = [f"corba.{name.removeprefix('net.')}" for name in KNOWN if name.startswith("net.")]
    return f"unknown property: {key}{did_you_mean(key, [*KNOWN, *old, *_OLD], 1)}"


def vain(key: str, value: str) -> str:
    """Return a finding about a value that has no effect; empty when it has."""
    known = find(key)
    if known is None or known.when not in (FIXED, NONE) or not value.strip():
        return ""
    if check(key, value) == known.default:
        return ""
    what = "is read-only" if known.when == FIXED else "has no effect"
    return f"{key} {what}: {known.meaning}"


def check(key: str, value: str) -> str:
    """Return a value as it is kept: trimmed, booleans as YES or NO.

    Raises:
        Malformed: It is not of the kind that the key has.
    """
    text = value.strip()
    known = find(key)
    if known is None or not text:
        return text
    if any(ord(c) < 32 or ord(c) == 127 for c in text):
        raise Malformed(f"{key}: has control characters: {text!r}")
    if known.kind == "boolean":
        word = text.upper()
        if word not in _TRUE + _FALSE:
            raise Malformed(f"{key}: neither YES nor NO: {text}")
        return "YES" if word in _TRUE else "NO"
    if known.kind == "number":
        return _number(key, text)
    if known.kind == "level" and text.upper() not in LEVELS:
        raise Malformed(f"{key}: no log level: {text} (one of {' '.join(LEVELS)})")
    reader = _READERS.get(known.key)
    if reader is not None:
        try:
            reader(text)
        except RtkitError as error:
            raise type(error)(f"{key}: {error}") from None
    return text.upper() if known.kind == "level" else text


class Settings:
    """The properties that were given to a manager, over the defaults of all that there are."""

    def __init__(self, given: Mapping[str, str] | None = None) -> None:
        self._values: dict[str, str] = {}
        self._spellings: dict[str, str] = {}
        for key, value in (given or {}).items():
            self.take(key, value)

    def copy(self) -> Settings:
        """Return the same, to go back to."""
        other = Settings()
        other._values, other._spellings = dict(self._values), dict(self._spellings)
        return other

    def put_back(self, key: str, before: Settings) -> None:
        """Give one property the value that it had."""
        name = canonical(key)
        for own, others in ((self._values, before._values), (self._spellings, before._spellings)):
            own.pop(name, None)
            if name in others:
                own[name] = others[name]

    def take(self, key: str, value: str) -> None:
        """Note a value, also of an unknown key.

        Raises:
            Malformed: It is not of the kind that the key has.
        """
        name = canonical(key)
        self._values[name] = check(key, value)
        self._spellings[name] = key

    def change(self, key: str, value: str) -> None:
        """Change a property of a manager that runs.

        Raises:
            NotFound: No such property; names the one that looks most like it.
            Refused: It cannot be changed while the manager runs; gives the reason.
            Malformed: The value is not of its kind.
        """
        known = find(key)
        if known is None:
            raise NotFound(unknown(key))
        if known.when == FIXED:
            raise Refused(f"read-only property: {key}")
        if known.when == START:
            raise Refused(
                f"{key} takes effect only at start: give it in rtc.conf or to rtmgr start -o"
            )
        self.take(key, value)

    def is_given(self, key: str) -> bool:
        """Return whether it was given a value."""
        return bool(self._values.get(key))

    def text(self, key: str) -> str:
        """Return a value, the default if nobody gave one."""
        given = self._values.get(key)
        return KNOWN[key].default if given is None and key in KNOWN else given or ""

    def flag(self, key: str) -> bool:
        """Return a boolean."""
        return self.text(key) == "YES"

    def number(self, key: str) -> float:
        """Return a number, 0 if there is none."""
        return float(self.text(key) or 0)

    def items(self, key: str) -> tuple[str, ...]:
        """Return the items of a comma list."""
        return tuple(item for item in map(str.strip, self.text(key).split(",")) if item)

    def below(self, *prefixes: str) -> dict[str, str]:
        """Return what was given with keys that begin with one of these."""
        return {k: v for k, v in self._values.items() if k.startswith(prefixes) and v}

    def of_components(self) -> dict[str, dict[str, str]]:
        """Return what was given for types and instances, by ``CATEGORY.NAME``."""
        found: dict[str, dict[str, str]] = {}
        for key, value in self._values.items():
            name, own = _of_component(key.split("."))
            if own and value:
                found.setdefault(name, {})[own] = value
        return found

    def table(self) -> dict[str, str]:
        """Return all properties with their values, each under the name by which it was given."""
        keys: Iterable[str] = dict.fromkeys([*KNOWN, *self._values])
        return {self._spellings.get(key, key): self.text(key) for key in keys}

    def lookup(self, key: str) -> str | None:
        """Return the value of a property by its present or old name, None if there is none."""
        name = canonical(key)
        return self.text(name) if name in KNOWN or name in self._values else None


def _number(key: str, text: str) -> str:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise Malformed(f"{key}: not a number of 0 or more: {text}")
    if value == 0 and key.endswith(".rate"):
        raise Malformed(f"{key}: a rate is above 0 [Hz]: {text}")
    return text


def _of_component(parts: Sequence[str]) -> tuple[str, str]:
    """Return ``CATEGORY.NAME`` and the key of a component in a key; two empty texts for others."""
    for index in range(2, len(parts) - 1):
        if parts[index] in _OF_COMPONENTS and all(parts):
            return ".".join(parts[:index]), ".".join(parts[index:])
    return "", ""


def _fits(pattern: str, key: str) -> bool:
    """Return whether a key matches; a star at an end stands for any number of elements."""
    wanted, parts = pattern.split("."), key.split(".")
    if wanted[0] == wanted[-1] == "*":
        return wanted[2] == _of_component(parts)[1].partition(".")[0]
    if wanted[-1] == "*":
        parts = parts[: len(wanted)]
    elif wanted[0] == "*":
        parts = parts[-len(wanted) :]
    return len(wanted) == len(parts) and all(
        want in ("*", part) and part for want, part in zip(wanted, parts, strict=True)
    )
