"""Placement: chooses hosts for components by what these require."""
