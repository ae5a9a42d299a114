"""Components that are built by forms."""
