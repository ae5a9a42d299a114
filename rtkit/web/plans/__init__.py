"""Plans for systems, comparisons of systems, and the order of their parts."""
