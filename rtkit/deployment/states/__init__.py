"""The states of a system: what it is to be like in each, what leads from one to another."""
