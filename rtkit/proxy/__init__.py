"""Calls and events carried on between any two doors; values are not understood here."""
