"""Ports and state machines of CSP: a writer waits until its value is taken."""
