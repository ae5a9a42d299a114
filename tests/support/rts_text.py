"""Writes system profiles as XML, as users keep them in files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  rts:id="RTSystem:Me:{}:1.0" rts:version="0.2" rts:abstract="{}"
  rts:creationDate="2025-01-01T00:00:00" rts:updateDate="2025-01-01T00:00:00">
"""
END = "</rts:RtsProfile>"
COMPONENT = """<rts:Components rts:id="{type_id}" rts:pathUri="{folder}/{instance}.rtc"
  rts:instanceName="{instance}" rts:isRequired="{required}"{active}>
{parts} <rts:ExecutionContexts rts:id="{context}" rts:kind="PERIODIC" rts:rate="{rate}"/>
{properties}</rts:Components>
"""
PORT = ' <rts:DataPorts rts:name="{}.{}"/>\n'
SET = """ <rts:ConfigurationSets rts:id="default">
  <rts:ConfigurationData rts:name="gain" rts:data="{}"/>
 </rts:ConfigurationSets>
"""
PROPERTY = ' <rtsExt:Properties rtsExt:name="rtkit.{}" rtsExt:value="{}"/>\n'
WIRE = """<rts:DataPortConnectors rts:connectorId="{wire}" rts:name="{wire}"
  rts:interfaceType="corba_cdr" rts:dataType="IDL:RTC/TimedLong:1.0" rts:dataflowType="push"
  rts:subscriptionType="new">
 <rts:sourceDataPort {source}/>
 <rts:targetDataPort {target}/>
</rts:DataPortConnectors>
"""


def system(name: str, *elements: str, abstract: str = "") -> str:
    """Return the profile of the system ``RTSystem:Me:NAME:1.0``."""
    return HEAD.format(name, abstract) + "".join(elements) + END


def properties(told: Mapping[str, str]) -> str:
    """Return the properties ``rtkit.KEY`` of a component or a system."""
    return "".join(PROPERTY.format(key, escape(text)) for key, text in told.items())


def with_properties(profile: str, told: Mapping[str, str]) -> str:
    """Return a profile whose system has these properties, too."""
    assert END in profile
    return profile.replace(END, properties(told) + END)


def type_of(instance: str) -> str:
    """Return the type that an instance is named for: ``RTC:Me:test:Source:1.0`` of ``Source0``."""
    return f"RTC:Me:test:{instance.rstrip('0123456789')}:1.0"


def component(
    instance: str,
    told: Mapping[str, str] | None = None,
    *,
    type_id: str = "",
    port: str = "",
    gain: str = "",
    folder: str = "localhost",
    required: bool = True,
    context: str = "0",
    rate: float = 1000.0,
) -> str:
    """Return a component with these properties; one with a `gain` has a set, which is active."""
    return COMPONENT.format(
        type_id=type_id or type_of(instance),
        instance=instance,
        folder=folder,
        required=str(required).lower(),
        active=' rts:activeConfigurationSet="default"' if gain else "",
        parts=(PORT.format(instance, port) if port else "") + (SET.format(gain) if gain else ""),
        context=context,
        rate=rate,
        properties=properties(told or {}),
    )


def wire(name: str, source: str, target: str, type_ids: Sequence[str] = ()) -> str:
    """Return a connector from ``INSTANCE.PORT`` to another one."""
    ends = (source, target)
    kinds = type_ids or [type_of(end.partition(".")[0]) for end in ends]
    out, into = (
        f'rts:componentId="{kind}" rts:instanceName="{end.partition(".")[0]}" rts:portName="{end}"'
        for kind, end in zip(kinds, ends, strict=True)
    )
    return WIRE.format(wire=name, source=out, target=into)
