"""The object request broker of CORBA, and its object adapter: what is left of them here."""

from __future__ import annotations

from typing import Any

from rtkit.openrtm.absent import refuse
from rtkit.openrtm.client_modules import client_module


class ObjectAdapter:
    """The object adapter of CORBA: a servant is its own reference within a process."""

    def servant_to_reference(self, servant: Any) -> Any:
        """Return a servant as it is."""
        return servant

    def reference_to_servant(self, reference: Any) -> Any:
        """Return a reference as it is."""
        return reference

    def servant_to_id(self, servant: Any) -> int:
        """Return a number of a servant."""
        return id(servant)

    def deactivate_object(self, id: Any) -> None:
        """Do nothing."""

    def _get_the_POAManager(self) -> ObjectAdapter:
        return self

    def activate(self) -> None:
        """Do nothing."""


class ObjectRequestBroker:
    """The broker of a process, by which the first references are found; ``CORBA::ORB``."""

    def resolve_initial_references(self, identifier: str) -> Any:
        """Return the root of all names, or the object adapter.

        Raises:
            NotSupported: It is none of these two.
        """
        if identifier == "NameService":
            return client_module("naming").root()
        if identifier == "RootPOA":
            return ObjectAdapter()
        raise refuse(f"ORB.resolve_initial_references({identifier!r})")

    def shutdown(self, wait_for_completion: Any = None) -> None:
        """Do nothing: what runs ends with its component, or its process."""

    destroy = shutdown

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"ORB.{name}")


def ORB_init(*_: Any) -> ObjectRequestBroker:
    """Return the broker; its options of the command line have no effect."""
    return ObjectRequestBroker()
