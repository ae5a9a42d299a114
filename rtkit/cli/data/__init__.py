"""Commands that print, write and record values of ports."""
