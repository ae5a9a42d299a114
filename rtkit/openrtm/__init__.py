"""Components written for OpenRTM-aist-Python: how their sources are read, converted and run."""
