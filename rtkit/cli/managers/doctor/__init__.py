"""Checks of ``rtdoctor``: this installation, this user's folders, limits, managers."""
