"""Slave processes: the zygote that forks them, their supervision, their connections."""
