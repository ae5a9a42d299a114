"""Live properties, on pages of widgets."""
