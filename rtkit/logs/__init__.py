"""Logs of processes: records, files and their rotation."""
