"""Manager daemon: loads modules, runs components in its own process and in slaves, keeps state."""
