"""Properties of this process, served: the loop that owns them, and its doors."""
