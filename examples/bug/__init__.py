"""Bug navigation: one generic algorithm, variants as data, sensor adaptors, a world."""
