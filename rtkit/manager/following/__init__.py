"""Follows the events of systems on threads of their own, as clients of the manager's loop."""
