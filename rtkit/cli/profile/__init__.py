"""Words of ``rtprofile``, a module each."""
