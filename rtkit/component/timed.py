"""The basic data types of the RTC specification, as ``idl/timed.idl`` has them."""

from rtkit.component.standard_classes import family

__all__, __getattr__, __dir__ = family(__name__)
