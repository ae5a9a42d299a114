"""Probes: ports of data tools, which read from and write to the ports of components."""
