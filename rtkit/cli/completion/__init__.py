"""Completion on the shell's command line, and the shell functions that ask for it."""
