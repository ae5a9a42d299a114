"""Data types of the module ``Img``, camera images, as ``idl/images.idl`` has them."""

from rtkit.component.standard_classes import family

__all__, __getattr__, __dir__ = family(__name__)
