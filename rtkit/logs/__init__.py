"""Where each process writes what happens, and how long it is kept."""
