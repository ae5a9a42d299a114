"""Names of `OpenRTM_aist` that authors of old components call.

Ports, listeners, properties, the manager, base classes of components, functions on texts and lists.
`rtkit.openrtm.loading.names` tells in which module each name is.
"""
