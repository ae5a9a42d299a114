"""The system editor in the browser: what lives as records, a stream of changes, actions."""
