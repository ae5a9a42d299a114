"""Help texts: topics, statuses, examples, manual pages."""
