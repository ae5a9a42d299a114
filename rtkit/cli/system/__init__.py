"""Shared parts of the commands that bring systems up from profiles, run and end them."""
