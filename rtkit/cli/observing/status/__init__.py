"""Page of ``rtstatus``: what is gathered about an entry of the tree, and its layout."""
