"""Properties over zenoh: client, endpoint, and what both share."""
