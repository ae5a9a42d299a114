"""Operations of ``rtmgr``: starting and stopping managers, and requests to one."""
