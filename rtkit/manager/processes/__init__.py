"""Processes of a manager: their start, their connections, their exit."""
