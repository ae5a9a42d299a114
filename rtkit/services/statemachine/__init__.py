"""State machine service: machines as RDF that read and set properties of any services."""

from __future__ import annotations

from rtkit.services.statemachine.service import StateMachine, StateMachineInit

__all__ = ["StateMachine", "StateMachineInit"]
