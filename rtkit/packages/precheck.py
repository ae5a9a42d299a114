"""Tells whether a system may need packages, before anything is loaded that handles them."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rtkit.profile.rts_model import ComponentInstance

_VARIABLE = "RTKIT_REPOSITORIES"


def known_repositories(given: Sequence[str] = ()) -> list[str]:
    """Return those that were given, else those of the settings; there may be none."""
    return [*given] or [each for each in os.environ.get(_VARIABLE, "").split(";") if each]


def is_built_in(component: ComponentInstance) -> bool:
    """Return whether rtkit alone makes a component: by its services, or by its examples."""
    from rtkit.component.composite import TYPES as COMPOSITES
    from rtkit.deployment.described import properties_of, type_of
    from rtkit.deployment.extension import CREATE, MODULE, STAND_IN
    from rtkit.errors import RtkitError
    from rtkit.modules.creatable import lacking
    from rtkit.modules.search import Search, file_of
    from rtkit.resources import resource
    from rtkit.rtc.create import readable_create
    from rtkit.rtc.profiles import split_module

    own = properties_of(component.properties)
    create = readable_create(own.get(CREATE, ""))
    type = type_of(component.id)
    if STAND_IN in own or create.implementation_id in COMPOSITES or type.type_name in COMPOSITES:
        return True
    path, init = split_module(own.get(MODULE, ""))
    examples = resource("examples", "basic")  # each manager has them in its load path
    search = Search([examples], is_absolute_allowed=False)
    try:
        real = search.read(path or f"{type.type_name}.py").real
        question = json.dumps([(f"{path}:{init}" if path else "", type.full_id)])
        why = json.loads(lacking(question, (), search, is_search_allowed=True))[0]
    except RtkitError:
        return False
    shipped = (os.path.dirname(os.path.realpath(file_of("rtkit"))), os.path.realpath(examples))
    return not why and real.startswith(tuple(f"{each}/" for each in shipped))
