"""System profiles that are edited with nothing running."""
