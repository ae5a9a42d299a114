"""The words of ``rtprofile``, a module each."""
