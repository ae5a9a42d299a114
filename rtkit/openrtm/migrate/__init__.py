"""Makes Python 3 of sources for older versions: in memory (`source`), or in their files (`files`).

The latter is ``rtkit openrtm migrate``. See `rtkit.openrtm.convert` for native components.
"""
