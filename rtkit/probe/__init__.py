"""Ports of a tool's own on the ports of components: what data tools read with and write with."""
