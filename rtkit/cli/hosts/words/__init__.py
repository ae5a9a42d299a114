"""Words of ``rthost``, a module each."""
