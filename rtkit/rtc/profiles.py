"""The profile records of the OMG RTC specification, as plain facts.

They describe what exists; the XML documents (RTC Profile, RTS Profile) have models of their own
in `rtkit.profile`.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, Polarity, PortType

NOTHING: Mapping[str, str] = {}


DEFINITION = "rtkit.idl"
"""Property of a port: the IDL of its data type, unless that is one of the standard; of a service
port, the IDL of its interfaces."""
_OPERATION = r"(?m)^    (.* _?(\w+)\([^()]*\)(?: raises \(.*\))?);$"


def operations_in(definition: str) -> list[tuple[str, str]]:
    """Return name and declaration of each operation in the definition of a service port.

    Without reading it as IDL, which takes longer than a press of TAB may.
    """
    import re  # each command loads this module, few tell operations

    return [(name, text) for text, name in re.findall(_OPERATION, definition)]


@dataclass(frozen=True, slots=True)
class PortInterfaceProfile:
    """One interface of a service port."""

    instance_name: str
    type_name: str
    polarity: Polarity


@dataclass(frozen=True, slots=True)
class PortProfile:
    """A port: its name within the component, its type, properties and interfaces."""

    name: str
    port_type: PortType
    properties: Mapping[str, str] = field(default_factory=dict)
    interfaces: tuple[PortInterfaceProfile, ...] = ()

    @property
    def data_type(self) -> str:
        """Name of the data type, ``IDL:RTC/TimedLong:1.0``; empty for service ports."""
        return self.properties.get("dataport.data_type", "")

    @property
    def definition(self) -> str:
        """IDL of the data type and all that it contains; empty where everybody knows it."""
        return self.properties.get(DEFINITION, "")


@dataclass(frozen=True, slots=True, order=True)
class PortRef:
    """A port by the name of its component instance and its own name."""

    instance: str
    port: str

    def __str__(self) -> str:
        return f"{self.instance}.{self.port}"


@dataclass(frozen=True, slots=True)
class ConnectorProfile:
    """A made connection. A data connector names its out port first.

    Attributes:
        trouble: Why only the own half of it is there, where the other end is in another manager
            (`rtkit.rtc.far_ends`); empty when it is whole.
    """

    connector_id: str
    name: str
    ports: tuple[PortRef, ...]
    properties: Mapping[str, str] = field(default_factory=dict)
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class ExecutionContextProfile:
    """An execution context as one participant sees it.

    Attributes:
        id: Its name within the component; ``"0"`` for the first.
        rate: [Hz]; 0 where the kind has none.
        state: Life-cycle state of the component in this context.
        missed: Periods at which nothing was done, as of the last report.
        trouble: Settings that the system refused; empty for none.
    """

    id: str
    kind: ExecutionKind
    rate: float
    owner: str
    is_running: bool = True
    state: LifeCycleState = LifeCycleState.INACTIVE
    participants: tuple[str, ...] = ()
    properties: Mapping[str, str] = field(default_factory=dict)
    missed: int = 0
    trouble: str = ""


@dataclass(frozen=True, slots=True)
class TypeProfile:
    """Identity of a component type, as its factory offers it."""

    type_name: str
    vendor: str = ""
    category: str = ""
    version: str = ""
    description: str = ""
    language: str = "Python"

    @property
    def id(self) -> str:
        """``RTC:vendor:category:type_name:version``, the form that system profiles use."""
        return f"RTC:{self.vendor}:{self.category}:{self.type_name}:{self.version}"

    @property
    def full_id(self) -> str:
        """``RTC:vendor:category:type_name:language:version``, the form of create strings."""
        fields = (self.vendor, self.category, self.type_name, self.language, self.version)
        return ":".join(("RTC", *fields))


@dataclass(frozen=True, slots=True)
class ModuleProfile:
    """A loaded module and the component types that one of its init functions offers.

    Attributes:
        path: By which it was loaded first.
        init: Name of the init function; a module that was loaded by several is there once for each.
        file: Where it was found, without links.
        aliases: Other paths by which it was loaded.
    """

    path: str
    init: str
    types: tuple[TypeProfile, ...] = ()
    file: str = ""
    aliases: tuple[str, ...] = ()

    def is_at(self, path: str) -> bool:
        """Return whether a path as it is typed means this module."""
        return path in (self.path, self.file, *self.aliases)


def split_module(module: str) -> tuple[str, str]:
    """Split ``PATH:INIT`` at the last colon that is followed by no slash."""
    path, colon, init = module.rpartition(":")
    return (path, init) if colon and "/" not in init else (module, "")
