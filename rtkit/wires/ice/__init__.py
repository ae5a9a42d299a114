"""Properties over Ice: client, endpoint, and what both share."""
