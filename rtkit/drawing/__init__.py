"""Pictures as text: components with their ports, systems with their wires; SVG and dot.

A drawing starts from plain data (`rtkit.drawing.scene`), so it needs no profile and no running
system. This package imports nothing.
"""
