"""Composites whose class an author derives from that of OpenRTM."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rtkit.component.base import Component
from rtkit.component.composite import Composite
from rtkit.component.composite import PeriodicECSharedComposite as SharedContext
from rtkit.component.configuration.config import DEFAULT
from rtkit.openrtm.api.adapter import HeldComponent
from rtkit.openrtm.api.component_listeners import ConfigurationSetListener
from rtkit.openrtm.api.rtobject import DataFlowComponentBase, default_callback
from rtkit.openrtm.api.string_util import stringToStrVec
from rtkit.openrtm.corba.enumerations import OK
from rtkit.openrtm.corba.references import Reference, RTObject


class HeldComposite(HeldComponent, SharedContext):
    """A composite that holds the object of an author's class; it drives the members itself."""

    def __init__(self, instance: str, options: Mapping[str, str] | None = None) -> None:
        given = options or {}
        # What its module describes is about the set itself, and would outrank the short form.
        short = {f"conf.{DEFAULT}.{key}": given[key] for key in self._parameters if key in given}
        super().__init__(instance, {**short, **given})

    def _configure(self) -> None:
        for parameter in self._parameters.values():
            self.configuration.bind(parameter.name, parameter.default)
        super()._configure()


class MemberReference(RTObject):
    """A member of a composite that was not written for OpenRTM."""

    def __init__(self, component: Component) -> None:
        self.rtkit_component = component


class PeriodicECOrganization(Reference):
    """The members of a composite: those that its parameters name."""

    def __init__(self, rtobj: Any) -> None:
        self._rtobj = rtobj

    def getObjRef(self) -> PeriodicECOrganization:
        """Return the reference to it."""
        return self

    def get_members(self) -> list[Any]:
        """Return the members that it has now."""
        members = self._rtobj.rtkit_component.member_components
        return [getattr(each, "servant", None) or MemberReference(each) for each in members]

    def updateDelegatedPorts(self) -> None:
        """Do nothing: rtkit shows the ports that the parameters name."""


class PeriodicECSharedComposite(DataFlowComponentBase):
    """Base of composites that drive their members in one execution context."""

    holder_class = HeldComposite
    _members: list[list[str]]

    def __init__(self, manager: Any) -> None:
        super().__init__(manager)
        self._org = PeriodicECOrganization(self)
        self._sdoOwnedOrganizations.append(self._org)
        self._members = [[]]
        self.bindParameter("members", self._members, " ", stringToStrVec)

    def _attach(self, component: HeldComponent) -> None:
        super()._attach(component)
        self._sdoOwnedOrganizations: list[PeriodicECOrganization] = []

    @property
    def _composite(self) -> Composite:
        assert isinstance(self.rtkit_component, Composite)
        return self.rtkit_component

    def get_owned_organizations(self) -> list[PeriodicECOrganization]:
        """Return its members as an organization."""
        return self._sdoOwnedOrganizations

    @default_callback
    def onActivated(self, ec_id: int) -> Any:
        """Activate every member, or none if one fails."""
        SharedContext.on_activated(self._composite, str(ec_id))
        return OK

    @default_callback
    def onDeactivated(self, ec_id: int) -> Any:
        """Deactivate every member that is Active."""
        SharedContext.on_deactivated(self._composite, str(ec_id))
        return OK

    @default_callback
    def onAborting(self, ec_id: int) -> Any:
        """Deactivate the members that still work."""
        SharedContext.on_aborting(self._composite, str(ec_id))
        return OK


class setCallback(ConfigurationSetListener):
    """Has the ports of members shown anew after a set was changed, or added."""

    def __init__(self, org: PeriodicECOrganization) -> None:
        self._org = org

    def __call__(self, config_set: Any) -> None:
        """React."""
        self._org.updateDelegatedPorts()


addCallback = setCallback
