"""Commands that run what ships as examples."""
