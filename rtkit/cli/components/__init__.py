"""Commands that change components: states, connectors, configuration, composites."""
