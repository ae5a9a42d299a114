"""Subcommands of ``rtprofile``, a module each."""
