"""Words of ``rtpkg``, a module each."""
