"""Interface data types of sensors, as ``idl/sensors.idl`` has them."""

from rtkit.component.standard_classes import family

__all__, __getattr__, __dir__ = family(__name__)
