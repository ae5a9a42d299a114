"""Recordings of port values: MCAP files with CDR payloads, and text for people."""
