"""Pages of ``rtdoc`` about a component, and the forms in which they are written."""
