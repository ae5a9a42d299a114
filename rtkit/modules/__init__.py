"""Component modules: found, described and loaded, from permitted folders only."""
