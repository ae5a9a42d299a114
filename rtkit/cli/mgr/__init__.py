"""What ``rtmgr`` does: the lives of managers, and what is asked of one."""
