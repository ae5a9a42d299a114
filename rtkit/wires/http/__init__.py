"""Properties over HTTP: client, endpoint, and what both share."""
