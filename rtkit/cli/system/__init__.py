"""Commands on whole systems: what runs, compared with an RTS profile and changed towards it."""
