"""The client's view: a tree of hosts, managers and components, and calls to their owners."""
