"""System states: the configuration of a system in each, and the events between them."""
