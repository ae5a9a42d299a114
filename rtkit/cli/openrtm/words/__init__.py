"""Words of ``rtopenrtm``."""
