"""Where components come from: found, described and loaded, from permitted folders only."""
