"""The version of rtkit."""

__version__ = "0.1.0"
