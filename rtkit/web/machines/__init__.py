"""State machines that live, and drafts of them."""
