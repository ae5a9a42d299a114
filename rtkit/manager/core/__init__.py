"""The manager's mind: events in, instructions out; no clock, no socket, no process of its own."""
