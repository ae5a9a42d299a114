"""Values of data types: how they are laid out, encoded, defined and written."""
