"""The state store on disk, and the thread that writes it."""
