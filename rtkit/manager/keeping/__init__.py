"""The store of wishes on disk, and the thread that writes it."""
