"""Extended data types beyond plain geometry, as ``idl/extended.idl`` has them."""

from rtkit.component.standard_classes import family

__all__, __getattr__, __dir__ = family(__name__)
