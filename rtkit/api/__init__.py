"""API room: all that is done to a running system, for scripts and for the commands alike."""
