"""Ports at which a manager is asked, and the processes that hold them open."""
