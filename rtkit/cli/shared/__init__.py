"""Shared parts of the commands: the run, its options, output, signals."""
