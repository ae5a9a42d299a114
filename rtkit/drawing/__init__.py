"""Pictures as text: components with their ports, systems with their wires; SVG and dot.

What is drawn is plain data (`rtkit.drawing.scene`), so who draws needs no profile and no running
system. Nothing is imported here.
"""
