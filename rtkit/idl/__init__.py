"""Interface definitions (OMG IDL): what IDL files declare, as data.

Not for: what becomes of it in Python, which is the builder's.
"""

from __future__ import annotations

from rtkit.idl.model import Definitions, InterfaceDeclaration, Path
from rtkit.idl.read import read_idl
from rtkit.idl.source import InvalidIdl

__all__ = ["Definitions", "InterfaceDeclaration", "InvalidIdl", "Path", "read_idl"]
