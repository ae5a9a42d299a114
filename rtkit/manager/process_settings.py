"""What properties mean for one process: its log, its processors, where it looks for modules."""

from __future__ import annotations

import logging
import os

from rtkit.errors import Refused
from rtkit.manager.events import Message
from rtkit.manager.loader import Loader
from rtkit.manager.properties import Settings
from rtkit.manager.values import processors

_LEVELS = {
    "FATAL": logging.CRITICAL,
    "ERROR": logging.ERROR,
    "WARN": logging.WARNING,
    "INFO": logging.INFO,
}
_SILENT = logging.CRITICAL + 1
_STREAMS = {"stdout": 1, "stderr": 2}


def configure(message: Message, loader: Loader) -> None:
    """Make a process what its manager says (see `rtkit.manager.configuring.message`).

    Raises:
        Refused: A processor is not there.
    """
    if message["processors"]:
        use_processors(processors(message["processors"]))
    set_log_level(message["log_level"])
    loader.configure(
        message["load_path"],
        is_absolute_allowed=message["is_absolute_allowed"],
        is_search_allowed=message["is_search_allowed"],
    )


def set_log_level(level: str) -> None:
    """Log what is at least of this level; everything finer than DEBUG is DEBUG, "" is nothing."""
    silent = level in ("", "SILENT")
    logging.getLogger().setLevel(_SILENT if silent else _LEVELS.get(level, logging.DEBUG))


def use_processors(wanted: frozenset[int]) -> None:
    """Have all threads of this process run on these processors.

    Raises:
        Refused: There is none of them.
    """
    for thread in os.listdir("/proc/self/task"):
        try:
            os.sched_setaffinity(int(thread), wanted)
        except ProcessLookupError:
            continue
        except OSError as error:
            there = ",".join(map(str, sorted(os.sched_getaffinity(0))))
            raise Refused(
                f"cannot run on processors {','.join(map(str, sorted(wanted)))}"
                f" ({error.strerror}; this process has {there})"
            ) from error


def add_log_files(settings: Settings, name: str) -> None:
    """Log to the files of ``logger.file_name`` too.

    Raises:
        Refused: A file cannot be written.
    """
    layout = f"%(asctime)s {name} %(levelname)s %(name)s: %(message)s"
    formatter = logging.Formatter(layout, settings.text("logger.date_format"))
    for item in settings.items("logger.file_name"):
        path = item.replace("%p", str(os.getpid()))
        try:
            target: int | str = _STREAMS.get(path.lower(), path)
            stream = open(target, "a", encoding="utf-8", closefd=path is target)  # noqa: SIM115
        except OSError as error:
            raise Refused(f"cannot write log file {path}: {error.strerror}") from error
        handler = logging.StreamHandler(stream)
        handler.setFormatter(formatter)
        logging.getLogger().addHandler(handler)
