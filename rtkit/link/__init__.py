"""Transport: calls to services and streams between ports, over zenoh or inside one process."""
