"""Functional core of the manager: events in, instructions out; no clock, no socket, no process."""
