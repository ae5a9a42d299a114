"""Commands on live properties: read, set, listen, serve, relay."""
