"""Interface definitions (OMG IDL): reads IDL files into data.

Not for: Python code of these declarations, which the builder generates.
"""

from __future__ import annotations

from rtkit.idl.model import Definitions, InterfaceDeclaration, Path
from rtkit.idl.read import read_idl
from rtkit.idl.source import InvalidIdl

__all__ = ["Definitions", "InterfaceDeclaration", "InvalidIdl", "Path", "read_idl"]
