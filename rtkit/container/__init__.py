"""Containers of components: the code that manager, slaves and attached processes have in common."""
