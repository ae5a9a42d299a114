"""Geometric data types of the RTC world, as ``idl/geometry.idl`` has them."""

from rtkit.component.standard_classes import family

__all__, __getattr__, __dir__ = family(__name__)
