"""Problems of remote manipulation, after D. E. Whitney (1969), for `rtkit.planner`."""
