"""Commands that list and change the tree, and describe what is in it."""
