"""What ``rtdoc`` writes: the page about a component, and the forms in which it is written."""
