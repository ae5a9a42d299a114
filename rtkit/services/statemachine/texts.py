"""Texts of machines in any of their forms: Turtle, RDF/XML, SCXML."""

from __future__ import annotations

import re

from rtkit.services.statemachine.model import Machine
from rtkit.services.statemachine.rdf import read_machine, write_machine

_BASE = "file:///machine"
_XML = re.compile(r"\ufeff?\s*<(\?xml|rdf:RDF|scxml)")


def is_xml(text: str) -> bool:
    """Return whether a text is RDF/XML or SCXML."""
    return _XML.match(text) is not None


def read_text(text: str, machine: Machine | None = None, at: str = "") -> Machine:
    """Read a machine, or what is to be a state of another one, in any form.

    Raises:
        BadMachine: It is none; says where.
        Refused: A library that reads the form is not there.
    """
    if not (is_xml(text) and "<scxml" in text):
        return read_machine(text, machine, at)
    from rtkit.services.statemachine.scxml import read_scxml

    made = read_scxml(text)
    return read_machine(write_machine(made), machine, at) if machine else made


def as_rdf_xml(text: str) -> str:
    """Return a machine in Turtle as RDF/XML."""
    import warnings

    from rdflib import Graph

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of lists, which are written all the same
        return (
            Graph().parse(data=text, format="turtle", publicID=_BASE).serialize(format="pretty-xml")
        )
