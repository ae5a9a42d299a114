"""Command lines that the server runs."""
