"""Commands about components written for OpenRTM-aist-Python."""
