"""What ``rtcat`` shows: components with their ports and connections, and managers."""
