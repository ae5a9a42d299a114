"""Wires of the Property Service: a package each, with the client and the server side of it."""
