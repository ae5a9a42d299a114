"""``rtkit shell-init SHELL``: the functions that a shell needs, to be evaluated by it."""

from __future__ import annotations

# Options ask the program for text to read, which is nothing to evaluate.
_POSIX = """\
rtcwd() {{
    case "${{1-}}" in
        -*) command rtcwd "$@"; return ;;
    esac
    local line
    line=$(SHELL={shell} command rtcwd "$@") || return
    eval "$line"
}}"""

_FISH = """\
function rtcwd
    if string match -q -- '-*' $argv[1]
        command rtcwd $argv
        return
    end
    set -l line (SHELL=fish command rtcwd $argv); or return
    eval $line
end"""

SCRIPTS: dict[str, str] = {
    "bash": _POSIX.format(shell="bash"),
    "zsh": _POSIX.format(shell="zsh"),
    "fish": _FISH,
}
"""What each shell evaluates, by its name."""

HELP = """\
Usage: {} shell-init bash|zsh|fish

Print the functions that a shell needs, among them rtcwd. Put into its start-up file:

  bash, zsh   eval "$(rtkit shell-init bash)"
  fish        rtkit shell-init fish | source"""
