"""Commands that start and command managers, and check an installation."""
