"""Imports what most components written for OpenRTM-aist need: a zygote does, once one is loaded.

Slaves that it forks from then on have that in common, in time and in memory.
"""

from rtkit.openrtm import (
    absent as absent,
)
from rtkit.openrtm import (
    adapter as adapter,
)
from rtkit.openrtm import (
    client_modules as client_modules,
)
from rtkit.openrtm import (
    clock as clock,
)
from rtkit.openrtm import (
    component_listeners as component_listeners,
)
from rtkit.openrtm import (
    connector_listeners as connector_listeners,
)
from rtkit.openrtm import (
    corba as corba,
)
from rtkit.openrtm import (
    definitions as definitions,
)
from rtkit.openrtm import (
    enumerations as enumerations,
)
from rtkit.openrtm import (
    folder as folder,
)
from rtkit.openrtm import (
    loading as loading,
)
from rtkit.openrtm import (
    logger as logger,
)
from rtkit.openrtm import (
    manager as manager,
)
from rtkit.openrtm import (
    names as names,
)
from rtkit.openrtm import (
    object_broker as object_broker,
)
from rtkit.openrtm import (
    operations as operations,
)
from rtkit.openrtm import (
    ports as ports,
)
from rtkit.openrtm import (
    properties as properties,
)
from rtkit.openrtm import (
    records as records,
)
from rtkit.openrtm import (
    references as references,
)
from rtkit.openrtm import (
    rtobject as rtobject,
)
from rtkit.openrtm import (
    service_ports as service_ports,
)
from rtkit.openrtm import (
    standard_types as standard_types,
)
from rtkit.openrtm import (
    string_util as string_util,
)
from rtkit.openrtm import (
    stubs as stubs,
)
from rtkit.openrtm import (
    twins as twins,
)
