"""Imports what most components written for OpenRTM-aist need: a zygote does, once one is loaded.

Slaves that it forks from then on have that in common, in time and in memory.
"""

# ruff: noqa: F401 - nothing here names them

import rtkit.openrtm.absent
import rtkit.openrtm.api.adapter
import rtkit.openrtm.api.clock
import rtkit.openrtm.api.component_listeners
import rtkit.openrtm.api.connector_listeners
import rtkit.openrtm.api.logger
import rtkit.openrtm.api.manager
import rtkit.openrtm.api.ports
import rtkit.openrtm.api.properties
import rtkit.openrtm.api.rtobject
import rtkit.openrtm.api.service_ports
import rtkit.openrtm.api.string_util
import rtkit.openrtm.client_modules
import rtkit.openrtm.corba.definitions
import rtkit.openrtm.corba.enumerations
import rtkit.openrtm.corba.names
import rtkit.openrtm.corba.object_broker
import rtkit.openrtm.corba.operations
import rtkit.openrtm.corba.records
import rtkit.openrtm.corba.references
import rtkit.openrtm.corba.standard_types
import rtkit.openrtm.corba.stubs
import rtkit.openrtm.corba.twins
import rtkit.openrtm.loading.folder
import rtkit.openrtm.loading.module
import rtkit.openrtm.loading.names
