"""Commands that watch a running system: activity, events, logs, states awaited."""
