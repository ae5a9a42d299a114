"""Interface definitions (OMG IDL): `rtkit.idl.read` makes data of them, `rtkit.idl.model`.

Not for: Python code of these declarations, which the builder generates.
"""
