"""Words of ``rtkeys``."""
