"""State machine service: machines as RDF that read and set properties of any services."""

from __future__ import annotations

from rtkit.services.statemachine.service import StateMachineService, StateMachineServiceInit

__all__ = ["StateMachineService", "StateMachineServiceInit"]
