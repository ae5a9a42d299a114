"""Requests of commands to the manager of their host, over a socket of its own (decision 99)."""
