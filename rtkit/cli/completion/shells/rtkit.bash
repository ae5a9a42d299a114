rtcwd() {
    case "${1-}" in
        -*) command rtcwd "$@"; return ;;
    esac
    local line
    line=$(SHELL=bash command rtcwd "$@") || return
    eval "$line"
}

_rtkit_complete() {
    local -a answer
    mapfile -t answer < <(
        command rtkit complete bash "$COMP_TYPE" "$COMP_WORDBREAKS" \
            "${COMP_LINE:0:COMP_POINT}" 2>/dev/null </dev/null
    )
    COMPREPLY=("${answer[@]:1}")
    if [ "${answer[0]-}" = nospace ]; then compopt -o nospace; fi
}

complete -F _rtkit_complete @COMMANDS@
